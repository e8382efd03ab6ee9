"""`taskbuilder pull`."""

from __future__ import annotations

import argparse

from taskbuilder.carried import Trust, UntrustedTaskError
from taskbuilder.cli.output import can_ask, confirmed, print_json, print_table
from taskbuilder.errors import display_path
from taskbuilder.sharing.pulling import Pulled, pull

_NEXT = {
    "task": "validate {} --quick",
    "data set": "dataset check {}",
    "policy": "evaluate {}",
    "certificate": "evaluate --verify {}",
}


def run(arguments: argparse.Namespace) -> int:
    """Get what was shared, and say what can be done with it."""
    try:
        pulled = _pulled(arguments, arguments.trust)
    except UntrustedTaskError as error:
        if arguments.trust or not can_ask() or not confirmed(f"{error}. Accept it?"):
            raise
        pulled = _pulled(arguments, error.carried.digest)
    if arguments.json:
        print_json(pulled.as_data())
        return 0
    print(f"{pulled.manifest.label} is in {display_path(pulled.folder)}")
    rows = [["SHA-256", pulled.manifest.digest]]
    if pulled.revision is not None:
        rows.append(["commit", pulled.revision])
    next_command = _NEXT[pulled.manifest.kind].format(display_path(pulled.path))
    rows.append(["next", f"taskbuilder {next_command}"])
    print_table(rows, indent="  ")
    return 0


def _pulled(arguments: argparse.Namespace, trust: Trust) -> Pulled:
    return pull(arguments.name, arguments.source, out=arguments.out, trust=trust)
