"""`taskbuilder explain`."""

from __future__ import annotations

import argparse
import re
import shutil
import textwrap
from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any

from taskbuilder.cli.output import paint, print_json
from taskbuilder.extensions import (
    ACTION_MODES,
    ALGORITHMS,
    CHANNELS,
    DATA_FORMATS,
    RENDERERS,
    REPORT_FORMATS,
    ForeignPart,
)
from taskbuilder.reference.lookup import Entry, as_data, explain

_LOADERS: Mapping[str, tuple[str, str]] = {
    ACTION_MODES.noun: ("taskbuilder.env.actions", "load_mode"),
    ALGORITHMS.noun: ("taskbuilder.learn.foreign_learner", "load_algorithm"),
    CHANNELS.noun: ("taskbuilder.env.foreign_channels", "load_reader"),
    DATA_FORMATS.noun: ("taskbuilder.data.formats", "load_writer"),
    RENDERERS.noun: ("taskbuilder.sim.pictures", "load_renderer"),
    REPORT_FORMATS.noun: ("taskbuilder.validate.formats", "load_writer"),
}
"""Module and function that load parts of other packages; imported only when there is one."""


def run(arguments: argparse.Namespace) -> int:
    """Print what the reference says of a name."""
    entries = explain(arguments.name, _load)
    if arguments.json:
        print_json({"entries": [as_data(entry) for entry in entries]})
        return 0
    width = min(shutil.get_terminal_size((88, 24)).columns, 100)
    print("\n\n".join("\n".join(_lines(entry, width)) for entry in entries))
    return 0


def _load(part: ForeignPart) -> Any:
    module, function = _LOADERS[part.noun]
    return getattr(import_module(module), function)(part)


def _lines(entry: Entry, width: int) -> Iterator[str]:
    yield f"{paint(entry.name, 'bold')}  {paint(entry.kind, 'dim')}"
    code = False
    for paragraph in entry.text.split("\n\n"):
        yield ""
        code = code or paragraph.startswith("```")
        if code:
            yield textwrap.indent(re.sub(r"^```\w*\n?", "", paragraph, flags=re.M).rstrip(), "  ")
        else:
            yield _wrapped(paragraph.replace("**", ""), width)
        code = code and not paragraph.rstrip().endswith("```")
    if entry.keys:
        yield ""
        yield "Its keys:"
    for line in as_data(entry)["keys"]:
        yield f"  {line['key'].strip('`')}: {line['value']}; {line['default']}"
        yield _wrapped(line["meaning"], width, "      ")


def _wrapped(text: str, width: int, indent: str = "") -> str:
    parts = [text] if not re.search(r"^- ", text, re.M) else text.splitlines()
    return "\n".join(
        textwrap.fill(
            part,
            width,
            initial_indent=indent,
            subsequent_indent=f"{indent}  " if part[:2] == "- " else indent,
        )
        for part in parts
    )
