"""The settings of algorithms: types with ranges for their fields, and reading and checking values.

An algorithm's settings are a frozen dataclass. The type of a field says its range, and its former
name if it had one.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Annotated, Any, get_args, get_type_hints

from pydantic import AliasChoices, Field, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from taskbuilder.errors import UsageError
from taskbuilder.wording import suggestion

Count = Annotated[int, Field(ge=1)]
"""A number of things, of which there is at least one."""

Whole = Annotated[int, Field(ge=0)]
"""A number of things, of which there may be none."""

Share = Annotated[float, Field(ge=0.0, le=1.0)]
"""A fraction or a probability."""

Weight = Annotated[float, Field(ge=0.0)]
"""A weight, or a standard deviation."""

Positive = Annotated[float, Field(gt=0.0)]
"""A rate or a limit that is not 0."""

Layers = tuple[Count, ...]
"""Units or channels of each layer."""

_LIMITS = {"ge": "at least", "gt": "above", "le": "at most", "lt": "below"}


def formerly(name: str, old: str) -> FieldInfo:
    """The name of a setting, and a former name that is still read."""
    field: FieldInfo = Field(validation_alias=AliasChoices(name, old))
    return field


def read_settings(kind: type[Any], given: Mapping[str, Any] | Sequence[str]) -> dict[str, Any]:
    """Read and check settings, and return those that are given.

    Args:
        kind: The dataclass of the settings.
        given: Settings by name, or texts of a command line, ``name=value`` with the value in JSON,
            such as ``noise=0.2`` or ``hidden=[64,64]``.

    Raises:
        UsageError: There is no such setting, it is given twice with different values, or its value
            has another type or is out of range.
    """
    defaults = {each.name: each.default for each in fields(kind)}
    chosen: dict[str, Any] = {}
    for name, value in _pairs(kind, given, defaults):
        if name in chosen and chosen[name] != value:
            raise UsageError(f"{name} is given twice, as {chosen[name]} and {value}; give it once")
        chosen[name] = value
    made = make_settings(kind, chosen)
    return {name: getattr(made, name) for name in chosen}


def _pairs(
    kind: type[Any], given: Mapping[str, Any] | Sequence[str], defaults: Mapping[str, Any]
) -> list[tuple[str, Any]]:
    """Names and values, former names replaced."""
    texts = [] if isinstance(given, Mapping) else given
    pairs = list(given.items()) if isinstance(given, Mapping) else []
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            name = _current(kind, name, defaults)
            raise UsageError(f'"{text}" sets nothing; write {name}={json.dumps(defaults[name])}')
        try:
            pairs.append((name, json.loads(value, parse_constant=str)))
        except json.JSONDecodeError:
            pairs.append((name, value))
    return [(_current(kind, name, defaults), value) for name, value in pairs]


def _current(kind: type[Any], name: str, defaults: Mapping[str, Any]) -> str:
    """The current name of a setting; warns if a former name is given."""
    now = _former_names(kind).get(name)
    if now is not None:
        warnings.warn(
            f"the setting {name} is called {now} now; the old name goes with the next version",
            FutureWarning,
            stacklevel=2,
        )
        return now
    if name not in defaults:
        raise UsageError(f'no setting "{name}"; {suggestion(name, tuple(defaults), what="one of")}')
    return name


def _former_names(kind: type[Any]) -> Mapping[str, str]:
    """Former names of settings, each with the current one."""
    names: dict[str, str] = {}
    for name, hint in get_type_hints(kind, include_extras=True).items():
        for part in get_args(hint)[1:]:
            alias = part.validation_alias if isinstance(part, FieldInfo) else None
            if isinstance(alias, AliasChoices):
                names |= {str(old): name for old in alias.choices if old != name}
    return names


def make_settings(kind: type[Any], chosen: Mapping[str, Any]) -> Any:
    """An algorithm's settings: the defaults, with the chosen values.

    Raises:
        UsageError: A value has another type or is out of range.
    """
    defaults = {each.name: each.default for each in fields(kind)}
    chosen = {_current(kind, name, defaults): value for name, value in chosen.items()}
    try:
        text = json.dumps(chosen, allow_nan=False)
    except ValueError:
        raise UsageError(f"settings are finite numbers, and not {chosen}") from None
    try:
        return TypeAdapter(kind).validate_json(text, strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
    name, *parts = first["loc"]
    value, context = chosen[str(name)], first.get("ctx", {})
    limits = [f"{word} {context[key]}" for key, word in _LIMITS.items() if key in context]
    if limits and not parts:
        raise UsageError(f"{name} is {value}; {limits[0]}")
    text = value if isinstance(value, str) else json.dumps(value)
    raise UsageError(f'{name} is "{text}"; something like {json.dumps(defaults[str(name)])}')


def check_values(kind: type[Any], values: Mapping[str, Any], *, needed: Sequence[str]) -> None:
    """Check values for the fields of a dataclass that were read from a file.

    Args:
        kind: The dataclass.
        values: Values of some of its fields, by name.
        needed: Names of fields that must be among them.

    Raises:
        ValueError: A value has another type, or is missing.
    """
    if lacking := [name for name in needed if name not in values]:
        raise ValueError(f"it lacks {', '.join(lacking)}")
    hints = get_type_hints(kind)
    for name, value in values.items():
        try:
            TypeAdapter(hints[name]).validate_python(value, strict=True)
        except ValidationError as error:
            raise ValueError(f"{name}: {error.errors()[0]['msg']}") from None
