"""What an option of environments means, to its users and to the rest of the library."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from taskbuilder.arguments import as_whole, several
from taskbuilder.errors import UsageError
from taskbuilder.extensions import Door
from taskbuilder.wording import excerpt, suggestion

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
        numbers: How many numbers it has, where it is a tuple of them.
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
    numbers: int = 1
    true_word: str = ""
    flag: str = ""
    decides_course: bool = False
    decides_policy: bool = False
    disturbs: bool = False


def about(help_: str, kind: OptionKind, *choices: Any, **more: Any) -> dict[str, OptionInfo]:
    """The metadata of a field of `Options`; the arguments are those of `OptionInfo`."""
    return {"info": OptionInfo(help_, kind, *choices, **more)}


def check_value(name: str, value: Any, info: OptionInfo, default: Any) -> None:
    """Check the value of an option.

    Raises:
        UsageError: It is none of the choices, out of bounds, or of another type.
    """
    if isinstance(default, bool) and not (info.choices or isinstance(value, bool)):
        raise UsageError(f"{name} is {excerpt(repr(value))}; True or False")
    if isinstance(default, tuple):
        several(name, value)
    if info.choices and not isinstance(value, bool):
        own = tuple(choice for choice in info.choices if isinstance(choice, str))
        check_choice(name, value, info.others.names(own) if info.others else own)
    if info.bounds is None or value is None:
        return
    least, most = info.bounds
    whole = isinstance(least, int)
    parts = value if info.numbers > 1 and isinstance(value, tuple) else (value,)
    if len(parts) != info.numbers or not all(_is_within(n, least, most, whole) for n in parts):
        kind = "a whole number from " if whole else ""
        kind = f"{_COUNTS[info.numbers]} whole numbers from " if info.numbers > 1 else kind
        unit = f", in {info.unit}" if info.unit else ""
        given = excerpt(repr(value))
        raise UsageError(f"{name} is {given}; {kind}{least:g} to {most:.7g}{unit}")


_COUNTS = {2: "two"}


def _is_within(number: Any, least: float, most: float, whole: bool) -> bool:
    if whole and as_whole(number) is None:
        return False
    if isinstance(number, bool) or not hasattr(type(number), "__float__"):
        return False
    return bool(least <= number <= most)


def check_choice(name: str, value: str, choices: Sequence[str]) -> None:
    """Check that a value is one of the choices.

    Raises:
        UsageError: It is not.
    """
    if value not in choices:
        raise UsageError(f'{name} "{value}": {suggestion(str(value), choices, what="one of")}')
