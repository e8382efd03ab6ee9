"""`taskbuilder list`."""

from __future__ import annotations

import argparse
from typing import Any

from taskbuilder.cli.output import paint, print_json, print_table
from taskbuilder.cli.tasks import catalogue_of
from taskbuilder.errors import display_path
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.summaries import summarize


def run(arguments: argparse.Namespace) -> int:
    """List the tasks: robots, length, summary."""
    catalogue = catalogue_of(arguments)
    tasks = [_describe(entry, catalogue) for entry in catalogue.tasks.values()]
    if arguments.json:
        print_json({"tasks": tasks})
        return 0
    rows = [["task", "robots", "steps", "summary"]]
    for task in tasks:
        robots = " + ".join(task["robots"].values()) if task["robots"] else "-"
        rows.append([task["name"], robots, str(task["episode_steps"] or "-"), task["summary"]])
    print_table(rows)
    broken = [task["name"] for task in tasks if not task["robots"]]
    if broken:
        print(paint(f"\nto see what is wrong: taskbuilder validate {' '.join(broken)}", "dim"))
    return 0


def _describe(entry: CatalogueEntry, catalogue: Catalogue) -> dict[str, Any]:
    summary = summarize(entry, catalogue)
    return {
        "name": entry.name,
        "path": display_path(entry.file),
        "robots": summary.robots,
        "episode_steps": summary.episode_steps,
        "summary": summary.summary,
    }
