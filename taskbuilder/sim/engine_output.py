"""What Bullet prints, told in sentences."""

from __future__ import annotations

import importlib
import re
import sys
from typing import Any

from taskbuilder.engine import MODULE, check_engine
from taskbuilder.quiet import captured

_RECORD = re.compile(r"b3(?:Warning|Error)\[[^\]\n]*\]:\n?")
_UNLABELLED_WARNING = re.compile(r"warning|cannot find|convex hull|unsupported", re.IGNORECASE)
_PLACE = re.compile(r"^\S*?[^/\s]+:\d+: ")
_LONGEST = 200
_WORDINGS = {
    "No inertial data for link": "link {} has no <inertial>; Bullet takes a mass of 1 kg",
    "Could not parse visual element for Link": "a <visual> of link {} was not understood",
    "Could not parse collision element for Link": "a <collision> of link {} was not understood",
    "Could not parse inertial element for Link": "the <inertial> of link {} was not understood",
    "Bad inertia tensor properties": "a principal moment of inertia of link {} exceeds the sum of "
    "the other two, perhaps only by rounding; Bullet takes 0 for all three, so make it smaller",
}


def import_pybullet() -> Any:
    """The module pybullet, imported without the line that it prints about its build.

    Raises:
        EngineError: It is not installed, or two packages provide it.
    """
    if MODULE in sys.modules:
        return sys.modules[MODULE]
    check_engine()
    with captured():
        return importlib.import_module(MODULE)


def warnings(text: str) -> tuple[str, ...]:
    """The warnings in what Bullet printed, one sentence each, without repetitions.

    Args:
        text: As in `quiet.Printed.text`.
    """
    unlabelled, *records = _RECORD.split(text)
    sentences = [_without_place(line) for line in _warning_lines(unlabelled)]
    for record in records:
        first, *others = record.strip().splitlines() or [""]
        # Bullet names the part in a record of its own, after the one that says what is wrong.
        if sentences and first and " " not in first:
            sentences[-1] = _about(sentences[-1], first)
        else:
            sentences.append(_without_place(first))
        sentences += [_without_place(line) for line in _warning_lines("\n".join(others))]
    return tuple(dict.fromkeys(filter(None, sentences)))


def _warning_lines(text: str) -> list[str]:
    return [line for line in text.splitlines() if _UNLABELLED_WARNING.search(line)]


def _without_place(line: str) -> str:
    """A line without the place in Bullet's or the asset's source that it begins with."""
    return _PLACE.sub("", line.strip())[:_LONGEST].rstrip(" :.")


def _about(sentence: str, name: str) -> str:
    """What a sentence says, of a part of the asset."""
    name = name[:_LONGEST]
    for beginning, wording in _WORDINGS.items():
        if sentence.startswith(beginning):
            return wording.format(name)
    return f"{sentence}: {name}"
