"""Turn what pydantic says of a file into findings that a person can act on."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import UnionType
from typing import Annotated, Any, TypeVar, get_args, get_origin

from pydantic import Tag, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from taskbuilder.errors import Finding, Fix, Location
from taskbuilder.schema.source import Path_, Source, dotted
from taskbuilder.schema.values import ONE, SEVERAL, Model, is_number
from taskbuilder.wording import closest, suggestion

Spec = TypeVar("Spec", bound=Model)

_NEEDED = {
    "bool_type": "true or false",
    "dict_type": "a mapping of names",
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "finite_number": "a finite number",
    "mapping_type": "a mapping of names",
    "model_type": "a mapping",
    "string_type": "text",
    "tuple_type": "a list",
}
_BOUNDS = {
    "greater_than": ("gt", "more than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}
_CUSTOM = {"choice": "TB106", "length": "TB106", "order": "TB106", "timing": "TB106"}
_OWN = {**_CUSTOM, "declared_twice": "TB105", "mass": "TB101", "name": "TB107", "color": "TB108"}


def parse(model: type[Spec], source: Source) -> tuple[Spec | None, tuple[Finding, ...]]:
    """The model of a file, or None and what keeps the file from being one."""
    try:
        return model.model_validate(source.data), ()
    except ValidationError as error:
        details = error.errors(include_url=False)
        # A misspelt key is one mistake: its right spelling is not reported as missing too.
        meant = {_meant(detail, model) for detail in details if detail["type"] == "extra_forbidden"}
        shown = [d for d in details if d["type"] != "missing" or d["loc"] not in meant]
        shown = [d for d in shown if not _miscounted(d)]
        return None, tuple(_finding(detail, model, source) for detail in shown)


def _miscounted(detail: ErrorDetails) -> bool:
    """Whether a list is called too short only because its items, reported too, are wrong."""
    return detail["type"] == "too_short" and len(detail["input"]) >= detail["ctx"]["min_length"]


def _meant(detail: ErrorDetails, model: type[Model]) -> Path_:
    """The path that an unknown key was probably meant to be."""
    *parent, wrong = detail["loc"]
    known = _keys(_type_at(model, tuple(parent)))
    return (*parent, closest(str(wrong), known) or "")


def _finding(detail: ErrorDetails, model: type[Model], source: Source) -> Finding:
    path = _file_path(detail)
    code, message, on_key = _say(detail, model)
    on_key = on_key or _in_key(detail)
    if detail["type"] == "missing" and isinstance(path[-1], int):
        path = path[:-1]  # a list that is too short: the list is at fault, not its absent item
    place = path[:-1] if detail["type"] == "missing" and on_key else path
    location = source.locate(place, key=on_key)
    return Finding(code, message, dotted(path), location, fix=_fix(detail, model, location))


def _fix(detail: ErrorDetails, model: type[Model], location: Location) -> Fix | None:
    """What to write in place of a misspelt key or choice, or of a number with a comma."""
    kind, path, value = detail["type"], _model_path(detail), detail["input"]
    if kind == "extra_forbidden":
        parent = _type_at(model, path[:-1])
        advised = path[-1] in getattr(parent, "INSTEAD", {})
        written, near = str(path[-1]), None if advised else closest(str(path[-1]), _keys(parent))
    elif kind in ("literal_error", "no_choice"):
        written, near = str(value), closest(str(value), _choices(detail, model))
    elif kind in ("float_type", "int_type") and _has_comma(value):
        written, near = value, value.replace(",", ".")
    else:
        return None
    return Fix(location, written, near) if near else None


def _choices(detail: ErrorDetails, model: type[Model]) -> list[str]:
    """What may stand where there is no choice like the one that is written."""
    listed = detail.get("ctx", {}).get("choices")
    return [_plain(c) for c in listed or get_args(_type_at(model, _model_path(detail)))]


def _has_comma(value: Any) -> bool:
    """Whether a text is a number with a comma in place of its point."""
    return isinstance(value, str) and re.fullmatch(r"[-+]?\d+,\d+", value) is not None


def _in_key(detail: ErrorDetails) -> bool:
    """Whether an error is in a key: pydantic marks it by a last step of its own."""
    return detail["loc"][-1:] == ("[key]",) and detail["type"] != "extra_forbidden"


def _model_path(detail: ErrorDetails) -> Path_:
    """The steps through the models."""
    return detail["loc"][:-1] if _in_key(detail) else detail["loc"]


def _file_path(detail: ErrorDetails) -> Path_:
    """The steps through the file; models add the kind of an expert's stage, and of its orders."""
    kept: list[str | int] = []
    steps = iter(_model_path(detail))
    for step in steps:
        kept.append(step)
        if isinstance(step, int) and kept[0] == "expert" and kept[-2] in ("expert", "stages"):
            next(steps, None)
    return tuple(step for step in kept if step not in (ONE, SEVERAL))


def _say(detail: ErrorDetails, model: type[Model]) -> tuple[str, str, bool]:
    """Code, message, and whether the key rather than the value is to blame."""
    kind, path = detail["type"], _model_path(detail)
    value, context = detail["input"], detail.get("ctx", {})
    if kind == "missing" and isinstance(path[-1], int):
        wanted = _fixed_length(_type_at(model, path[:-1])) or path[-1] + 1
        return "TB104", f"has {_values(len(value))}; {wanted} are needed", False
    if kind == "missing":
        field = _field_at(model, path)
        hint = (field.description or "").rstrip(".") if field else ""
        return "TB101", f"missing; {hint[:1].lower()}{hint[1:]}" if hint else "missing", True
    if kind == "extra_forbidden":
        parent = _type_at(model, path[:-1])
        advice = getattr(parent, "INSTEAD", {}).get(path[-1])
        help_ = advice.format(_spelt(value)) if advice else suggestion(str(path[-1]), _keys(parent))
        return "TB102", f"unknown key; {help_}", True
    if kind in ("literal_error", "no_choice"):
        choices = _choices(detail, model)
        help_ = suggestion(str(value), choices, what="choices")
        if "mean" in help_:
            help_ += f" (one of {', '.join(choices)})"
        return "TB105", f"{_shown(value)} is no choice here; {help_}", False
    if kind in _BOUNDS:
        key, words = _BOUNDS[kind]
        return "TB104", f"is {_shown(value)}; must be {words} {context[key]:g}", False
    if kind == "too_long" and (most := _fixed_length(_type_at(model, path))):
        return "TB104", f"has {_values(len(value))}; {most} are needed", False
    if kind in ("too_short", "too_long", "string_too_short", "string_too_long"):
        return "TB104", _length_message(kind, context, value), False
    if kind == "tuple_type" and path[-1] == "box" and is_number(value):
        edges = f"[{value:g}, {value:g}, {value:g}]"
        return "TB103", f"is {value:g}; three edge lengths are needed: {edges}", False
    if kind in _NEEDED:
        return "TB103", f"is {_described(value)}; {_needed(kind, value)}", False
    if kind in _OWN:
        return _OWN[kind], detail["msg"], False
    return "TB103", f"{detail['msg']} (got {_described(value)})", False


def _spelt(value: Any) -> str:
    """A value as YAML spells it in a line, or dots where that is long."""
    if isinstance(value, dict):
        text = f"{{{', '.join(f'{key}: {_spelt(inner)}' for key, inner in value.items())}}}"
    elif isinstance(value, tuple):
        text = f"[{', '.join(map(_spelt, value))}]"
    else:
        text = _plain(value)
    return text if len(text) <= 60 else "…"


def _values(count: int, unit: str = "values") -> str:
    return f"{count} {unit.removesuffix('s') if count == 1 else unit}"


def _needed(kind: str, value: Any) -> str:
    """What is needed in place of a value, and how the value that was probably meant is written."""
    needed = f"{_NEEDED[kind]} is needed"
    if not isinstance(value, str) or kind not in ("float_type", "int_type"):
        return needed
    if _has_comma(value):
        return f"{needed}, and decimals take a point: {value.replace(',', '.')}"
    number = re.match(r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?", value)
    if number and number[0] == value:
        return f"{needed}, without quotation marks"
    return f"{needed}, without a unit" if number else needed


def _length_message(kind: str, context: Mapping[str, Any], value: Any) -> str:
    unit = "characters" if kind.startswith("string") else "values"
    least, most = context.get("min_length"), context.get("max_length")
    if least == 1:
        return "is empty; at least one is needed"
    allowed = f"at least {least} are needed" if least else f"at most {most} are allowed"
    return f"has {_values(context.get('actual_length', len(value)), unit)}; {allowed}"


def _shown(value: Any) -> str:
    text = f'"{value}"' if isinstance(value, str) else _plain(value)
    return text if len(text) <= 40 else f"{text[:37]}…"


def _plain(value: Any) -> str:
    """A value as YAML spells it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return "nothing" if value is None else str(value)


def _described(value: Any) -> str:
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, tuple):
        return f"a list of {len(value)}"
    if isinstance(value, str):
        return f"the text {_shown(value)}"
    return _shown(value)


def _unwrap(annotation: Any) -> Any:
    """An annotation without Annotated and without `| None`."""
    while True:
        if get_origin(annotation) is Annotated:
            annotation = get_args(annotation)[0]
            continue
        members = [a for a in get_args(annotation) if a is not type(None)]
        models = [a for a in members if isinstance(a, type) and issubclass(a, Model)]
        if get_origin(annotation) is UnionType and len(models) == 1:
            annotation = models[0]
            continue
        if type(None) in get_args(annotation) and len(members) == 1:
            annotation = members[0]
            continue
        return annotation


def _field_at(model: type[Model], path: Path_) -> FieldInfo | None:
    parent = _type_at(model, path[:-1])
    if not (isinstance(parent, type) and issubclass(parent, Model)):
        return None
    by_key = {field.alias or name: field for name, field in parent.model_fields.items()}
    return by_key.get(str(path[-1]))


def _type_at(annotation: Any, path: Path_) -> Any:
    """The annotation that a value at a path has, or None where the path leads nowhere."""
    for step in path:
        annotation = _unwrap(annotation)
        arguments = get_args(annotation)
        if isinstance(annotation, type) and issubclass(annotation, Model):
            field = _field_at(annotation, (step,))
            annotation = field.annotation if field else None
        elif get_origin(annotation) is tuple and isinstance(step, int):
            fixed = len(arguments) > step and arguments[-1] is not Ellipsis
            annotation = arguments[step] if fixed else arguments[0]
        elif tagged := [member for member in arguments if _tag(member) == step]:
            annotation = tagged[0]
        elif len(arguments) == 2 and isinstance(step, str):
            annotation = arguments[1]
        else:
            return None
    return _unwrap(annotation)


def _tag(member: Any) -> str | None:
    """The tag of a member of a tagged union."""
    return next((extra.tag for extra in get_args(member) if isinstance(extra, Tag)), None)


def _keys(annotation: Any) -> list[str]:
    if isinstance(annotation, type) and issubclass(annotation, Model):
        return [field.alias or name for name, field in annotation.model_fields.items()]
    return []


def _fixed_length(annotation: Any) -> int | None:
    arguments = get_args(annotation)
    if get_origin(annotation) is tuple and arguments[-1] is not Ellipsis:
        return len(arguments)
    return None
