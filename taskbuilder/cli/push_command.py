"""`taskbuilder push`."""

from __future__ import annotations

import argparse

from taskbuilder.cli.output import print_json, print_table, warn
from taskbuilder.cli.tasks import catalogue_of
from taskbuilder.sharing.hub import is_on_hub
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
    rows.append(
        ["to get it", f"taskbuilder pull {manifest.folder}{_at(pushed)} {pushed.destination}"]
    )
    print_table(rows, indent="  ")


def _at(pushed: Pushed) -> str:
    """The commit as `pull` takes it: git knows one by its beginning, the hub in full alone."""
    if pushed.revision is None:
        return ""
    return f"@{pushed.revision if is_on_hub(pushed.destination) else pushed.revision[:12]}"
