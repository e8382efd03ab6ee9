"""Messages of policy servers: msgpack with NumPy arrays, in the form of openpi's servers.

An array is a map of its bytes, type and shape, so reading a message executes nothing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from taskbuilder.errors import TaskbuilderError, UsageError

HOW_TO_GET = 'pip install "taskbuilder[serve]"'

_NUMBERS = "fiub"


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
    """The message of some bytes.

    Raises:
        UsageError: msgpack is not installed.
        MessageError: The bytes are no message.
    """
    try:
        message = _msgpack().unpackb(content, object_hook=_array, strict_map_key=False)
    except (ValueError, TypeError, KeyError) as error:  # msgpack's own errors are ValueErrors
        raise MessageError(f"no message of msgpack and arrays ({error})") from None
    if not isinstance(message, dict):
        raise MessageError(f"a {type(message).__name__}, not a map")
    return message


def _msgpack() -> Any:
    try:
        import msgpack
    except ModuleNotFoundError:
        raise UsageError(f"policy servers need msgpack; {HOW_TO_GET}") from None
    return msgpack


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray) and value.dtype.kind in _NUMBERS:
        told = {b"data": value.tobytes(), b"dtype": value.dtype.str, b"shape": value.shape}
        return {b"__ndarray__": True, **told}
    if isinstance(value, np.generic) and value.dtype.kind in _NUMBERS:
        return {b"__npgeneric__": True, b"data": value.item(), b"dtype": value.dtype.str}
    raise TypeError(f"a message cannot hold {type(value).__name__}")


def _array(told: dict[Any, Any]) -> Any:
    if b"__ndarray__" not in told and b"__npgeneric__" not in told:
        return told
    dtype = np.dtype(told[b"dtype"])
    if dtype.kind not in _NUMBERS:
        raise ValueError(f"an array of {dtype}, which are no numbers")
    if b"__npgeneric__" in told:
        return dtype.type(told[b"data"])
    shape = tuple(int(length) for length in told[b"shape"])
    if math.prod(shape) * dtype.itemsize != len(told[b"data"]):
        raise ValueError(f"an array that is not of its shape {shape}")
    return np.frombuffer(told[b"data"], dtype).reshape(shape)
