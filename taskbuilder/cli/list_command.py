"""`taskbuilder list`."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from taskbuilder.cli.output import paint, print_json, print_table
from taskbuilder.cli.tasks import asked_suite, catalogue_of, tell_of_clashes
from taskbuilder.errors import display_path
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.proofs import proof_of
from taskbuilder.schema.summaries import indexed_suites, summarize


def run(arguments: argparse.Namespace) -> int:
    """List the tasks of the catalogue, or of a suite."""
    catalogue = catalogue_of(arguments)
    suite = asked_suite(arguments, catalogue)
    tell_of_clashes(catalogue, "task")
    names = suite.tasks if suite else catalogue.tasks
    tasks = [_describe(catalogue.tasks[name], catalogue) for name in names]
    if arguments.json:
        print_json({"tasks": tasks, **({"suite": suite.as_data()} if suite else {})})
        return 0
    rows = [["task", "robots", "steps", "proved", "summary"]]
    for task in tasks:
        robots = " + ".join(task["robots"].values()) if task["robots"] else "-"
        steps = str(task["episode_steps"] or "-")
        rows.append([task["name"], robots, steps, _proved(task["proof"]), task["summary"]])
    print_table(rows, prose=True)
    broken = [task["name"] for task in tasks if not task["robots"]]
    if broken:
        print(paint(f"\nto see what is wrong: taskbuilder validate {' '.join(broken)}", "dim"))
    return 0


def _describe(entry: CatalogueEntry, catalogue: Catalogue) -> dict[str, Any]:
    summary = summarize(entry, catalogue)
    proof = proof_of(entry)
    return {
        "name": entry.name,
        "version": summary.version,
        "path": display_path(entry.file),
        "robots": summary.robots,
        "objects": list(summary.objects),
        "episode_steps": summary.episode_steps,
        "summary": summary.summary,
        "suites": _suites(entry, catalogue),
        "proof": asdict(proof) if proof else None,
    }


def _proved(proof: Mapping[str, Any] | None) -> str:
    if proof is None:
        return "-"
    return str(proof["date"])[:10] if proof["current"] else "before a change"


def _suites(entry: CatalogueEntry, catalogue: Catalogue) -> list[str]:
    known = indexed_suites(entry)
    if known is not None:
        return known
    from taskbuilder.schema.suites import suites_of  # validates, which takes its time

    return suites_of(entry, catalogue)
