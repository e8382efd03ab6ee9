"""`taskbuilder objects import`."""

from __future__ import annotations

import argparse


def run(arguments: argparse.Namespace) -> int:
    """Import an object."""
    from taskbuilder.cli.importing import run_import

    return run_import(arguments, robot=False)
