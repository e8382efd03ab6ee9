"""The options of environments, from the fields of their class."""

from __future__ import annotations

from typing import Any

from taskbuilder.env.option_info import OptionInfo
from taskbuilder.env.options import option_fields, option_infos
from taskbuilder.reference.markdown import table


def options(_: str) -> str:
    """What every option means, with its default."""
    rows = []
    for name, each in option_fields().items():
        info: OptionInfo = each.metadata["info"]
        meanings = [f"{_value(value)}: {meaning}" for value, meaning in info.choices.items()]
        default = info.unless_given or _value(each.default)
        rows.append([f"`{name}`", "; ".join([info.help, *meanings]), default])
    return table(["option", "meaning", "default"], rows)


def decisive(_: str) -> str:
    """The options on which the course of an episode depends."""
    names = [f"`{name}`" for name, info in option_infos().items() if info.decides_course]
    return f"These options must be the same: {', '.join(names[:-1])} and {names[-1]}."


def _value(value: Any) -> str:
    """A value as it is written in Python."""
    return f'`"{value}"`' if isinstance(value, str) else f"`{value}`"
