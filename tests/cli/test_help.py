"""The help of every command, as it is shown on a terminal of 80 columns."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from taskbuilder import __version__
from taskbuilder.cli.arguments import _COMMANDS

HELP = Path(__file__).parent / "help"


@pytest.mark.parametrize("command", ["", *_COMMANDS])
def test_help_reads_as_reviewed(command, run, update_golden):
    """After a change: pytest tests/cli --update-golden, then review the files."""
    ran = run(*command.split(), "--help")
    assert (ran.status, ran.err) == (0, "")
    file = HELP / f"{command or 'taskbuilder'}.txt"
    if update_golden:
        file.write_text(ran.out)
    assert ran.out == file.read_text()


@pytest.mark.parametrize("command", _COMMANDS)
def test_help_has_an_example_that_the_parser_takes(command, run):
    from taskbuilder.cli.arguments import parse

    text = " ".join(run(command, "--help").out.split())
    example = re.search(r"example: taskbuilder (.*?)(?: >.*)?$", text)
    assert example, text
    assert parse(example[1].split()).command == command


def test_every_help_file_is_of_a_command():
    assert {file.stem for file in HELP.glob("*.txt")} == {"taskbuilder", *_COMMANDS}


def test_the_version_is_that_of_the_package(run):
    assert run("--version").out == f"taskbuilder {__version__}\n"
