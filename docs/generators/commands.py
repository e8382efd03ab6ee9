"""The command line's own help, and what `taskbuilder new` writes."""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from unittest import mock

from taskbuilder.cli import main
from taskbuilder.cli.arguments import make_parser
from taskbuilder.reference.markdown import fence


def helps(_: str) -> str:
    """The help of every command, a section each."""
    with mock.patch.dict(os.environ, {"COLUMNS": "88"}):
        parts = [
            f"## taskbuilder {name}\n\n{fence('text', parser.format_help())}"
            for name, parser in _commands().items()
        ]
    return "\n\n".join(parts)


def scaffold(name: str) -> str:
    """The YAML and Python files that `taskbuilder new` writes for a task of a name.

    Raises:
        ValueError: The command failed.
    """
    with tempfile.TemporaryDirectory() as folder:
        with contextlib.redirect_stdout(io.StringIO()):
            if main(["new", name, "--dir", folder]):
                raise ValueError(f"taskbuilder new {name} failed")
        return "\n\n".join(
            (
                f"`{name}.yaml`, the scene:",
                fence("yaml", Path(folder, f"{name}.yaml").read_text(encoding="utf-8")),
                f"`{name}.py`, the description:",
                fence("python", Path(folder, f"{name}.py").read_text(encoding="utf-8")),
            )
        )


def _commands() -> Mapping[str, argparse.ArgumentParser]:
    actions = make_parser()._actions
    (commands,) = [a for a in actions if isinstance(a, argparse._SubParsersAction)]
    found: Mapping[str, argparse.ArgumentParser] = commands.choices
    return found
