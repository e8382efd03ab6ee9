"""`taskbuilder schema`."""

from __future__ import annotations

import argparse

from taskbuilder.cli.output import print_json
from taskbuilder.reference.json_schema import described_schema


def run(arguments: argparse.Namespace) -> int:
    """Print the JSON Schema of task or robot files."""
    print_json(described_schema(arguments.sort))
    return 0
