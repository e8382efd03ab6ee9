"""`taskbuilder push`."""

from __future__ import annotations

import argparse

from taskbuilder.cli.output import print_json, print_table, warn
from taskbuilder.cli.tasks import catalogue_of
from taskbuilder.sharing.pushing import Pushed, push


def run(arguments: argparse.Namespace) -> int:
    """Share a task, a data set, a policy or a certificate."""
    pushed = push(
        arguments.what,
        arguments.destination,
        name=arguments.name,
        tag=arguments.tag,
        replace=arguments.replace,
        catalogue=catalogue_of(arguments),
    )
    if arguments.json:
        print_json(pushed.as_data())
        return 0
    _print(pushed)
    for remark in pushed.remarks:
        warn(remark)
    return 0


def _print(pushed: Pushed) -> None:
    manifest = pushed.manifest
    state = "is now" if pushed.changed else "was already"
    print(f"{manifest.label} {state} in {pushed.destination}")
    rows = [["SHA-256", manifest.digest]]
    if pushed.revision is not None:
        rows.append(["commit", pushed.revision])
    at = f"@{pushed.revision[:12]}" if pushed.revision is not None else ""
    rows.append(["to get it", f"taskbuilder pull {manifest.folder}{at} {pushed.destination}"])
    print_table(rows, indent="  ")
