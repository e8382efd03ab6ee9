"""Messages of policy servers: msgpack with NumPy arrays, in the form of openpi's servers.

An array is a map of its bytes, type and shape, so reading a message executes nothing.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from itertools import count
from typing import Any

import numpy as np

from taskbuilder.errors import TaskbuilderError, UsageError
from taskbuilder.wording import excerpt

HOW_TO_GET = 'pip install "taskbuilder[serve]"'

LARGEST = 8 << 20
"""Maximum size of a message of a server in bytes; a chunk of 4096 steps of 60 numbers has 2 MB."""

_MOST_VALUES, _MOST_CONTAINERS = 8192, 20_000
"""Values of one map or list, and maps and lists of a message.

An empty list takes one byte in a message and over 64 in memory, and msgpack makes room for a list
of whatever length a message claims. With these limits, a message takes less than 250 MB.
"""

_MOST_AXES, _LONGEST_AXIS = 8, 2**31

_NUMBERS = "fiub"
_TYPE = re.compile(r"[<>|=]?[fiub](1|2|4|8|16)")
"""Types of arrays as `numpy.dtype.str` writes them."""


class MessageError(TaskbuilderError):
    """A message is not what it should be."""


def packed(message: Mapping[str, Any]) -> bytes:
    """A message as bytes.

    Args:
        message: Text, numbers, arrays, and maps and lists of these.

    Raises:
        UsageError: msgpack is not installed.
    """
    content: bytes = _msgpack().packb(message, default=_plain)
    return content


def unpacked(content: bytes) -> dict[str, Any]:
    """The message of some bytes, which may be anybody's.

    Raises:
        UsageError: msgpack is not installed.
        MessageError: The bytes are no message, or one that takes too much memory.
    """
    if len(content) > LARGEST:
        raise MessageError(f"a message of more than {LARGEST >> 20} MiB")
    counted = count(1)

    def limited(value: Any) -> Any:
        if next(counted) > _MOST_CONTAINERS:
            raise ValueError(f"more than {_MOST_CONTAINERS:,} lists and maps")
        return value

    limits = {f"max_{kind}_len": _MOST_VALUES for kind in ("array", "map")}
    try:
        message = _msgpack().unpackb(
            content,
            object_hook=lambda value: _array(limited(value)),
            list_hook=limited,
            ext_hook=_refuse,
            strict_map_key=False,
            **limits,
        )
    except (ValueError, TypeError, KeyError, OverflowError) as error:
        # msgpack's own errors are ValueErrors
        raise MessageError(f"no message of msgpack and arrays ({excerpt(error)})") from None
    if not isinstance(message, dict):
        raise MessageError(f"a {type(message).__name__}, not a map")
    return message


def _refuse(code: int, _: bytes) -> None:
    raise ValueError(f"an extension type {code}")


def _msgpack() -> Any:
    try:
        import msgpack
    except ModuleNotFoundError:
        raise UsageError(f"policy servers need msgpack; {HOW_TO_GET}") from None
    return msgpack


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray) and value.dtype.kind in _NUMBERS:
        fields = {b"data": value.tobytes(), b"dtype": value.dtype.str, b"shape": value.shape}
        return {b"__ndarray__": True, **fields}
    if isinstance(value, np.generic) and value.dtype.kind in _NUMBERS:
        return {b"__npgeneric__": True, b"data": value.item(), b"dtype": value.dtype.str}
    raise TypeError(f"a message cannot hold {type(value).__name__}")


def _array(fields: dict[Any, Any]) -> Any:
    """The array or the number of a map; any other map as it is."""
    if b"__ndarray__" not in fields and b"__npgeneric__" not in fields:
        return fields
    kind, data = fields[b"dtype"], fields[b"data"]
    if not isinstance(kind, str) or not _TYPE.fullmatch(kind):
        raise ValueError("an array of what are no numbers")
    dtype = np.dtype(kind)
    if b"__npgeneric__" in fields:
        if not isinstance(data, int | float):
            raise ValueError(f"a {type(data).__name__} as a number")
        return dtype.type(data)
    shape = fields[b"shape"]
    if not isinstance(shape, list | tuple) or len(shape) > _MOST_AXES:
        raise ValueError(f"an array with no shape of at most {_MOST_AXES} axes")
    if not all(isinstance(n, int) and 0 <= n < _LONGEST_AXIS for n in shape):
        raise ValueError("an array whose shape is none")
    if not isinstance(data, bytes) or math.prod(shape) * dtype.itemsize != len(data):
        raise ValueError(f"an array that is not of its shape {tuple(shape)}")
    return np.frombuffer(data, dtype).reshape(shape)
