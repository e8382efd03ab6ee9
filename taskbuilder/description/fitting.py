"""Whether values are what an annotation asks for, and how to say what it asks for."""

from __future__ import annotations

import math
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from taskbuilder.description.measures import Measure
from taskbuilder.description.node import Condition
from taskbuilder.schema.names import Refers

_WORDS = {
    bool: "True or False",
    float: "a finite number",
    int: "a whole number",
    str: "text",
    Condition: "a condition",
    Measure: "a measure",
}


def fits(value: Any, annotation: Any) -> bool:
    """Whether a value is what an annotation asks for, as far as that can be told."""
    inner = get_args(annotation)
    match get_origin(annotation):
        case None:
            return _is_a(value, annotation)
        case origin if origin is Annotated:
            return fits(value, inner[0])
        case origin if origin is Literal:
            return value in inner
        case origin if origin in (Union, UnionType):
            return any(fits(value, member) for member in inner)
        case origin if origin is tuple:
            if not isinstance(value, tuple):
                return False
            wanted = inner[:1] * len(value) if inner[-1] is Ellipsis else inner
            return len(value) == len(wanted) and all(map(fits, value, wanted))
        case origin:
            return not isinstance(origin, type) or isinstance(value, origin)


def wanted(annotation: Any) -> str:
    """What an annotation asks for, in words."""
    inner = get_args(annotation)
    origin = get_origin(annotation)
    if origin is Annotated:
        kinds = [extra.kind for extra in inner if isinstance(extra, Refers)]
        return f"the name of a {kinds[0]}" if kinds else wanted(inner[0])
    if origin in (Union, UnionType):
        return " or ".join(wanted(member) for member in inner if member is not NoneType)
    if origin is tuple:
        return f"a tuple, each {wanted(inner[0])}"
    if origin is Literal:
        return " or ".join(map(repr, inner))
    return _WORDS.get(annotation) or str(getattr(annotation, "__name__", annotation))


def _is_a(value: Any, sort: Any) -> bool:
    if sort is None:
        return value is None
    if sort is float or sort is int:
        number = isinstance(value, Real if sort is float else Integral)
        return number and not isinstance(value, bool) and math.isfinite(value)
    try:
        return not isinstance(sort, type) or isinstance(value, sort)
    except TypeError:  # a protocol that cannot be checked
        return True
