"""`taskbuilder mcp`."""

from __future__ import annotations

import argparse

from taskbuilder.agent_tools import make_server


def run(arguments: argparse.Namespace) -> int:
    """Serve coding agents on standard input and output, until the agent's program ends."""
    make_server(arguments.dir).run("stdio")
    return 0
