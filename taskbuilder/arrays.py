"""Files of numbers: named arrays and a few words about them, without pickle.

A file is a zip of .npy arrays, as NumPy writes them, one of which holds JSON. Every array has a
checksum, and the zip's table of contents comes last, so a file that was cut off is found out. None
is packed: what is read takes as much memory as the file is long, whatever it claims to be.
"""

from __future__ import annotations

import io
import json
import math
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import TaskbuilderError, display_path
from taskbuilder.files import write_whole
from taskbuilder.untrusted import parse_json, read_plain
from taskbuilder.wording import excerpt

Arrays = dict[str, NDArray[Any]]

_ABOUT = "about.json"

_DAMAGED = (
    *(zipfile.BadZipFile, zlib.error, EOFError, OSError),
    *(ValueError, KeyError, TypeError, RuntimeError),
    *(SyntaxError, tokenize.TokenError, MemoryError),  # of the text that tells an array's shape
)
"""What reading a file raises that is damaged or foreign: a changed bit may ask for a password."""


class StoreError(TaskbuilderError):
    """A file of numbers is not what it should be."""


def write_arrays(path: Path, arrays: Mapping[str, NDArray[Any]], about: Mapping[str, Any]) -> None:
    """Write a file, aside and synced: after a crash it is there whole or not at all.

    Args:
        path: Where.
        arrays: By name, of numbers only.
        about: What JSON can hold; its "kind" says what file this is.

    Raises:
        OSError: It cannot be written.
    """
    write_whole(path, packed_arrays(arrays, about), sync=True)


def packed_arrays(arrays: Mapping[str, NDArray[Any]], about: Mapping[str, Any]) -> bytes:
    """The content of a file; see `write_arrays`."""
    words = np.frombuffer(json.dumps(about).encode(), dtype=np.uint8)
    content = io.BytesIO()
    # As numpy.savez, which has no place for arrays with the names of its own parameters.
    with zipfile.ZipFile(content, "w") as file:
        for name, array in {_ABOUT: words, **arrays}.items():
            with file.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as part:
                np.lib.format.write_array(part, np.asanyarray(array), allow_pickle=False)
    return content.getvalue()


def read_arrays(
    path: Path, kind: str, *, largest: int | None = None
) -> tuple[Arrays, dict[str, Any]]:
    """Read a whole file and verify it.

    Args:
        path: Where it is.
        kind: What its words must say it is.
        largest: Bytes that it may have at most, for files that may come from anybody.

    Raises:
        StoreError: It is cut off, changed, larger than allowed, or another kind of file.
        OSError: It cannot be read.
    """
    name = display_path(path)
    if largest is None:
        return unpacked_arrays(path.read_bytes(), kind, name)
    if path.stat().st_size > largest:
        raise StoreError(f"{name}: is larger than a {kind} may be ({largest >> 20} MiB)")
    return unpacked_arrays(read_plain(path, largest), kind, name, parse=parse_json)


def unpacked_arrays(
    content: bytes, kind: str, name: str, *, parse: Callable[[bytes], Any] = json.loads
) -> tuple[Arrays, dict[str, Any]]:
    """The arrays and words of a file; see `read_arrays`.

    Args:
        content: What the file contains.
        kind: What its words must say it is.
        name: Its path, for messages.
        parse: Reads its words.

    Raises:
        StoreError: It is cut off, changed, or another kind of file.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as file:
            _check_sums(file, content)
            arrays = {
                part.removesuffix(".npy"): _array(file.read(part)) for part in file.namelist()
            }
        about = parse(arrays.pop(_ABOUT).tobytes())
    except _DAMAGED as error:
        raise StoreError(
            f"{name}: is damaged, or no file of taskbuilder's ({excerpt(error)})"
        ) from None
    found = about.get("kind") if isinstance(about, dict) else None
    if found != kind:
        raise StoreError(f"{name}: is a {excerpt(found or 'foreign file')}; a {kind} is needed")
    return arrays, about


def _check_sums(file: zipfile.ZipFile, content: bytes) -> None:
    """Verify all arrays before any is made, and that they are no more than the file itself."""
    parts = file.infolist()
    packed = [part.filename for part in parts if part.compress_type != zipfile.ZIP_STORED]
    if packed:
        raise zipfile.BadZipFile(f"{packed[0]} is packed, and could unpack to any size")
    if sum(part.file_size for part in parts) > len(content):
        raise zipfile.BadZipFile("its table of contents lists more than there is")
    # Nothing sums up the table of contents, but the file's end says how long it should be.
    if len(parts) != int.from_bytes(content[-12:-10], "little"):
        raise zipfile.BadZipFile("its table of contents has gaps")
    damaged = file.testzip()
    if damaged is not None:
        raise zipfile.BadZipFile(f"{damaged} has another checksum")


def _array(content: bytes) -> NDArray[Any]:
    """The array of a .npy file; NumPy would make one of the claimed shape before it reads any."""
    part = io.BytesIO(content)
    if np.lib.format.read_magic(part) != (1, 0):
        raise ValueError("an array of another format")
    shape, _, dtype = np.lib.format.read_array_header_1_0(part)
    if dtype.kind not in "biuf":
        raise ValueError(f"an array of {dtype}, which are no numbers")
    if min(shape, default=0) < 0 or math.prod(shape) * dtype.itemsize != len(content) - part.tell():
        raise ValueError(f"an array that is not of its shape {shape}")
    part.seek(0)
    array: NDArray[Any] = np.lib.format.read_array(part, allow_pickle=False)
    return array
