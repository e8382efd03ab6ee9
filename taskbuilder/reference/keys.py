"""The keys of task and robot files, from the models that read them."""

from __future__ import annotations

import json
import types
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from taskbuilder.reference.markdown import code, number
from taskbuilder.reference.markdown import table as as_table
from taskbuilder.reference.meanings import MEANINGS, SECTIONS, VALUES
from taskbuilder.schema import (
    agents,
    arrangement,
    bodies,
    expert,
    joints,
    object_files,
    objects,
    order,
    placing,
    postures,
    robot,
    scene,
    shapes,
    sites,
    task,
    values,
)
from taskbuilder.schema.names import Refers
from taskbuilder.schema.order import ONLY_WITH, VERBS
from taskbuilder.schema.values import PALETTE, OneOf, Shorthand, rgb

MODELS: Mapping[str, type[BaseModel]] = {
    name: model
    for module in (
        *(shapes, bodies, placing, objects, object_files, sites, agents, scene),
        *(postures, arrangement, joints, task, robot, expert, order),
    )
    for name, model in vars(module).items()
    if isinstance(model, type) and issubclass(model, BaseModel) and name in MEANINGS
}

# What the aliases of the models' vocabulary are called.
_ALIASES: tuple[tuple[Any, str], ...] = (
    (values.Position, "[x, y, z] in m"),
    (values.Edges, "[x, y, z] in m"),
    (values.RpyDeg, "[roll, pitch, yaw] in degrees"),
    (values.Coordinate, "m"),
    (values.Length, "m"),
    (values.Extent, "m"),
    (values.Degrees, "degrees"),
    (values.Mass, "kg"),
    (values.Friction, "number"),
    (values.Positive, "number"),
    (values.Pixels, "pixels"),
    (values.Name, "name"),
    (values.Reference, "name in the scene"),
    (values.Text, "text"),
    (values.Color, "[colour](#colours)"),
    (order.Condition, "name of a condition"),
    (order.Above, "m"),
    (expert.Seconds, "s"),
    (robot.LinkName, "name in the URDF"),
)
_NOUNS = ("number", "name", "text", "list")
HEAD = ("key", "value", "default", "meaning")

_UNITS = {"_deg": "degrees", "_hz": "Hz"}
_METRES = {"max_step", "stroke", "near", "far"}
_UNBOUNDED = (values.Name, values.Reference, values.Text, order.Condition, robot.LinkName)


ELSEWHERE = ("ObjectFileSpec",)
"""Models whose keys are not explained on the page of task files."""


def table(name: str) -> str:
    """The keys of a model: what each takes, its default, what it means.

    Raises:
        ValueError: A key has no meaning, or a meaning has no key.
    """
    text = as_table(HEAD, rows(name))
    # The sections that keys of objects link to are on the page of task files.
    return text.replace("](#", "](task-file.md#") if name in ELSEWHERE else text


def rows(name: str) -> list[list[str]]:
    """The lines of that table.

    Raises:
        ValueError: A key has no meaning, or a meaning has no key.
    """
    model, given = MODELS[name], MEANINGS[name]
    if gone := set(given) - {field.alias or key for key, field in model.model_fields.items()}:
        raise ValueError(f"meanings.py speaks of {name}.{', '.join(gone)}, which does not exist")
    return _rows(name, [*model.model_fields])


def verbs(_: str) -> str:
    """The verbs of the expert's orders."""
    rows = _rows("Order", list(VERBS))
    return as_table(["verb", "value", "meaning"], ([row[0], row[1], row[3]] for row in rows))


def manners(_: str) -> str:
    """What an order may say besides its verb."""
    own = [key for key in order.Order.model_fields if key not in VERBS]
    rows = []
    for key, row in zip(own, _rows("Order", own), strict=True):
        default = "required" if key in ("to", "to_deg") else row[2]
        rows.append([row[0], row[1], default, ", ".join(map(code, ONLY_WITH[key])), row[3]])
    return as_table(["key", "value", "default", "with", "meaning"], rows)


def _rows(name: str, keys: list[str]) -> list[list[str]]:
    model, given = MODELS[name], MEANINGS[name]
    hints = get_type_hints(model, include_extras=True)
    rows = []
    for key in keys:
        field = model.model_fields[key]
        shown = field.alias or key
        own = field.description or _inner_description(hints[key])
        meaning = given.get(shown) or own
        if not meaning:
            raise ValueError(f"{name}.{shown} has no meaning; write one in meanings.py")
        value = VALUES.get((name, shown)) or _with_unit(shown, describe(hints[key]))
        default = _default(field)
        if default == "none" and "default" in meaning:
            default = "see meaning"
        rows.append([code(shown), value, default, meaning])
    return rows


def colours(_: str) -> str:
    """The palette."""
    swatches = []
    for name in PALETTE:
        shade = "".join(f"{round(part * 255):02x}" for part in rgb(name))
        swatches.append(
            f'<div><span class="swatch" style="background:#{shade}"></span>'
            f'<span class="name">{name}</span></div>'
        )
    return f'<div class="swatches">\n{"".join(swatches)}\n</div>'


def describe(hint: Any) -> str:
    """What a value of an annotation is, in a few words."""
    hint = _unmarked(hint)
    origin, inner = get_origin(hint), get_args(hint)
    for alias, words in _ALIASES:
        if hint == alias:
            bounds = _range(inner[0], "each ") if origin is tuple else _range(hint)
            return f"{words}{bounds}"
    if origin is Annotated:
        return _annotated(inner)
    if origin in (Union, types.UnionType):
        return " or ".join(describe(part) for part in inner if part is not type(None))
    if origin is Literal:
        return ", ".join(code("true" if choice is True else choice) for choice in inner)
    if origin is tuple:
        if inner[-1] is Ellipsis:
            return f"list of {_plural(describe(inner[0]))}"
        parts = [describe(part) for part in inner]
        alike = len(set(parts)) == 1
        return f"two {_plural(parts[0])}" if alike and len(parts) == 2 else f"[{', '.join(parts)}]"
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return f"mapping: {describe(inner[0])} → {describe(inner[1])}"
    if isinstance(hint, type) and issubclass(hint, BaseModel):
        return f"[{SECTIONS[hint.__name__]}](#{SECTIONS[hint.__name__].replace(' ', '-')})"
    return {bool: "true or false", int: "whole number", float: "number", str: "text"}.get(
        hint, "any value"
    )


def _unmarked(hint: Any) -> Any:
    """An annotation without what it says its text refers to."""
    inner = get_args(hint) if get_origin(hint) is Annotated else ()
    kept = tuple(extra for extra in inner if not isinstance(extra, Refers))
    return Annotated[kept] if len(kept) < len(inner) else hint


def _annotated(inner: tuple[Any, ...]) -> str:
    own = next((extra.own for extra in inner[1:] if isinstance(extra, OneOf)), ())
    words = ", ".join(map(code, own)) or describe(inner[0]) + _range(Annotated[inner])
    for extra in inner[1:]:
        if isinstance(extra, Shorthand):
            words += f", or the word {code(extra.word)}"
    return words


def _plural(words: str) -> str:
    """Several of what ``words`` call one: ``numbers in m, 0 to 10`` for ``m, 0 to 10``."""
    if words.startswith("`"):
        return f"any of the words {words}"
    if words == "any value":
        return "values of any type"
    noun = next((noun for noun in _NOUNS if words.startswith(noun)), "")
    return f"{noun}s{words.removeprefix(noun)}" if noun else f"numbers in {words}"


def _range(hint: Any, each: str = "") -> str:
    """The bounds of an annotated number, such as ``, 0 to 10``."""
    if any(hint == alias for alias in _UNBOUNDED):
        return ""
    bounds = dict(_bounds(hint))
    least = max((bounds[key] for key in ("ge", "gt") if key in bounds), default=None)
    most = min((bounds[key] for key in ("le", "lt") if key in bounds), default=None)
    if least is None or most is None:
        return ""
    if least == bounds.get("gt") and least != bounds.get("ge"):
        return f", above {number(least)} and at most {number(most)}"
    return f", {each}{number(least)} to {number(most)}"


def _bounds(hint: Any) -> Iterator[tuple[str, float]]:
    for extra in getattr(hint, "__metadata__", ()):
        for limit in extra.metadata if isinstance(extra, FieldInfo) else (extra,):
            for key in ("ge", "gt", "le", "lt"):
                if (bound := getattr(limit, key, None)) is not None:
                    yield key, bound


def _inner_description(hint: Any) -> str | None:
    for extra in getattr(hint, "__metadata__", ()):
        if isinstance(extra, FieldInfo) and extra.description:
            return extra.description
    return None


def _with_unit(key: str, words: str) -> str:
    unit = next((unit for end, unit in _UNITS.items() if key.endswith(end)), "")
    unit = unit or ("m" if key in _METRES else "")
    if not unit or unit in words:
        return words
    for plain in ("whole number", "number", "m,"):
        if words.startswith(plain):
            return unit + words.removeprefix(plain.rstrip(","))
    return f"{words}, {unit}"


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    if isinstance(value, BaseModel):
        section = SECTIONS[type(value).__name__]
        return f"the defaults under [{section}](#{section.replace(' ', '-')})"
    if isinstance(value, Mapping):
        return ", ".join(code(name) for name in value) or "none"
    if value is None or value == ():
        return "none"
    if value == ("all",):
        return code("all")
    plain = json.dumps(_plain(value)).strip('"') if not isinstance(value, str) else value
    return code(plain)


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    whole = isinstance(value, float) and value.is_integer()
    return int(value) if whole else value
