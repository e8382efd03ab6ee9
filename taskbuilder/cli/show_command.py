"""`taskbuilder show`."""

from __future__ import annotations

import argparse

from taskbuilder.cli.tasks import catalogue_of
from taskbuilder.schema.dump import as_yaml
from taskbuilder.schema.load import read_task


def run(arguments: argparse.Namespace) -> int:
    """Print the task as it was understood, defaults filled in."""
    catalogue = catalogue_of(arguments)
    print(as_yaml(read_task(catalogue.task(arguments.task), catalogue)), end="")
    return 0
