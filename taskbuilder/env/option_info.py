"""What an option of environments means, to its users and to the rest of the library."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from taskbuilder.errors import UsageError
from taskbuilder.extensions import Door
from taskbuilder.wording import suggestion

OptionKind = Literal["reward", "arrays", "scene", "observed", "pictures", "view"]
"""What an option is about: rewards; the form of actions and observations as arrays; what is played;
what agents observe of it; the pictures that they observe; or what people see."""


@dataclass(frozen=True)
class OptionInfo:
    """What an option means to its users, and to the rest of the library.

    Attributes:
        help: What it chooses.
        kind: What it is about.
        choices: Meaning of each value, if there are only these and False.
        others: Where other packages add choices, if they can.
        unless_given: What holds by default, where the default does not say it.
        bounds: Minimum and maximum of a number.
        unit: Of the number.
        true_word: The word for True on a command line, besides the option alone.
        flag: Its name on a command line, if it is another.
        decides_course: Whether the course of an episode depends on it, for given actions and seed.
        decides_policy: Whether a policy is trained for a value: policies record it, and evaluations
            keep to it.
        disturbs: Whether an evaluation may add it to test a policy.
    """

    help: str
    kind: OptionKind
    choices: Mapping[str | bool, str] = field(default_factory=dict)
    others: Door | None = None
    unless_given: str = ""
    bounds: tuple[float, float] | None = None
    unit: str = ""
    true_word: str = ""
    flag: str = ""
    decides_course: bool = False
    decides_policy: bool = False
    disturbs: bool = False


def about(help_: str, kind: OptionKind, *choices: Any, **more: Any) -> dict[str, OptionInfo]:
    """The metadata of a field of `Options`; the arguments are those of `OptionInfo`."""
    return {"info": OptionInfo(help_, kind, *choices, **more)}


def check_value(name: str, value: Any, info: OptionInfo) -> None:
    """Check the value of an option.

    Raises:
        UsageError: It is none of the choices, or out of bounds.
    """
    if info.choices and not isinstance(value, bool):
        own = tuple(choice for choice in info.choices if isinstance(choice, str))
        check_choice(name, value, info.others.names(own) if info.others else own)
    if info.bounds is None or value is None:
        return
    least, most = info.bounds
    whole = isinstance(least, int)
    parts = value if isinstance(value, tuple) else (value,)
    if not all(isinstance(n, int if whole else int | float) and least <= n <= most for n in parts):
        kind = "a whole number from " if whole else ""
        kind = "whole numbers from " if isinstance(value, tuple) else kind
        unit = f", in {info.unit}" if info.unit else ""
        raise UsageError(f"{name} is {value!r}; {kind}{least:g} to {most:.7g}{unit}")


def check_choice(name: str, value: str, choices: Sequence[str]) -> None:
    """Check that a value is one of the choices.

    Raises:
        UsageError: It is not.
    """
    if value not in choices:
        raise UsageError(f'{name} "{value}": {suggestion(str(value), choices, what="one of")}')
