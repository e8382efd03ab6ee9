"""Results of a validation as data of JSON and arrays of numbers, and back.

Reading them back runs no code of theirs: only the classes that are listed here are made.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import StrEnum
from importlib import import_module
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_MODULES = {
    "taskbuilder.errors": ("Finding", "Location"),
    "taskbuilder.validate.report": ("Check", "FamilyResult", "Making", "Probe", "TaskReport"),
    "taskbuilder.expert.baselines": ("Baseline", "BaselineKind"),
    "taskbuilder.validate.solo": ("Solo",),
    "taskbuilder.validate.env_cache": ("Start",),
    "taskbuilder.rollout.record": ("Rollout", "ScriptLog", "Trouble"),
    "taskbuilder.description.reasons": ("Reason",),
    "taskbuilder.env.options": ("Options",),
}
"""The classes that results consist of, by module. A static validation imports none of them."""

_HOMES = {name: module for module, names in _MODULES.items() for name in names}


def to_plain(value: Any) -> tuple[Any, dict[str, NDArray[Any]]]:
    """Data that JSON can hold, and the numbers of all arrays, joined by type.

    Args:
        value: Objects of the listed classes, mappings, tuples, lists, paths and arrays of numbers,
            within each other.

    Raises:
        TypeError: It contains something else.
    """
    parts: dict[str, list[NDArray[Any]]] = {}
    lengths: dict[str, int] = {}

    def plain(value: Any) -> Any:
        match value:
            case StrEnum():
                return {type(value).__name__: [value.value]}
            case None | bool() | int() | float() | str():
                return value
            case np.generic():
                return value.item()
            case np.ndarray() if value.dtype.kind in "biuf":
                dtype = value.dtype.name
                start = lengths.get(dtype, 0)
                parts.setdefault(dtype, []).append(value.ravel())
                lengths[dtype] = start + value.size
                return {"array": [dtype, start, list(value.shape)]}
            case Path():
                return {"path": str(value)}
            case Mapping():
                return {"mapping": [[plain(key), plain(item)] for key, item in value.items()]}
            case list():
                return [plain(item) for item in value]
        name = type(value).__name__
        if _HOMES.get(name) == type(value).__module__:
            return {name: [plain(item) for item in _values(value)]}
        if isinstance(value, tuple):
            return {"tuple": [plain(item) for item in value]}
        raise TypeError(f"{name} is no part of a result")

    data = plain(value)
    return data, {dtype: np.concatenate(arrays) for dtype, arrays in parts.items()}


def _values(value: Any) -> Iterator[Any]:
    if is_dataclass(value):
        return (getattr(value, field.name) for field in fields(value))
    return iter(value)


def from_plain(data: Any, arrays: Mapping[str, NDArray[Any]]) -> Any:
    """What `to_plain` was given; the arrays are copies.

    Raises:
        ValueError, TypeError, LookupError: The data are no such data.
    """

    def whole(data: Any) -> Any:
        if isinstance(data, list):
            return [whole(item) for item in data]
        if not isinstance(data, dict):
            return data
        ((name, content),) = data.items()
        match name:
            case "array":
                dtype, start, shape = content
                return arrays[dtype][start : start + prod(shape)].reshape(shape).copy()
            case "path":
                return Path(content)
            case "mapping":
                return {whole(key): whole(item) for key, item in content}
            case "tuple":
                return tuple(whole(item) for item in content)
        made = getattr(import_module(_HOMES[name]), name)
        return made(*(whole(item) for item in content))

    return whole(data)
