"""Reading files that may come from anybody: plain files of bounded size, and JSON of bounded shape.

A data set, a policy or a certificate may have been made to do harm. What reads one must not wait
for a FIFO, follow a link out of its folder, or take more memory than the file has a right to.
"""

from __future__ import annotations

import errno
import hashlib
import json
import math
import os
import re
import stat
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO

DEEPEST_JSON = 32
"""Arrays and objects of JSON that may be nested in each other."""

_FEWEST_VALUES, _BYTES_PER_VALUE = 10_000, 8
"""A JSON file of n bytes may hold ``_FEWEST_VALUES`` + n / ``_BYTES_PER_VALUE`` values.

An empty list takes three bytes in a file and 64 in memory; files of numbers and names have more
bytes for each value.
"""

_LARGEST_INTEGER = 2**63

_UNPRINTABLE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
"""What a terminal would obey, what reverses the order of letters, and halves of characters."""


def read_plain(path: Path, largest: int) -> bytes:
    """The contents of a plain file; links to it are followed.

    Args:
        path: The file.
        largest: Most bytes that it may have.

    Raises:
        OSError: It is a folder, a device or a FIFO, is too large, or cannot be read.
    """
    with _opened(path, largest, os.O_RDONLY) as file:
        return _read(file, path, largest)


def read_within(folder: Path, name: str, largest: int) -> bytes:
    """The contents of a plain file in a folder that came from somebody else.

    Args:
        folder: The folder, which may itself be a link.
        name: Path of the file in the folder, with ``/`` between folders.
        largest: Most bytes that the file may have.

    Raises:
        OSError: The name leads out of the folder, a part of it is a link, the file is a folder, a
            device or a FIFO, it is too large, or it cannot be read.
    """
    with _opened_within(folder, name, largest) as file:
        return _read(file, folder / name, largest)


def digest_within(folder: Path, name: str, largest: int) -> str:
    """SHA-256 of such a file, in hexadecimal, which is not held in memory as a whole.

    Raises:
        OSError: As `read_within` does.
    """
    sha = hashlib.sha256()
    with _opened_within(folder, name, largest) as file:
        while part := file.read(1 << 20):
            sha.update(part)
    return sha.hexdigest()


def copy_within(folder: Path, name: str, largest: int, to: Path) -> str:
    """Copy such a file to a new file; returns the SHA-256 of what was copied, in hexadecimal.

    Raises:
        OSError: As `read_within` does, or the new file is there or cannot be written.
    """
    sha = hashlib.sha256()
    with _opened_within(folder, name, largest) as file, to.open("xb") as copied:
        while part := file.read(1 << 20):
            sha.update(part)
            copied.write(part)
    return sha.hexdigest()


def place_within(folder: Path, name: str) -> Path:
    """The path of a file or folder in a folder that came from somebody else.

    Raises:
        OSError: The name leads out of the folder, or a part of it is a link or does not exist.
    """
    parts = PurePosixPath(name).parts
    if not parts or "\0" in name or "\\" in name or name.startswith("/") or ".." in parts:
        raise OSError(errno.EINVAL, "leads to another folder", name)
    place = folder
    for part in parts:
        place /= part
        if stat.S_ISLNK(place.lstat().st_mode):
            raise OSError(errno.ELOOP, "is a link; only plain files are read", str(place))
    return place


def _opened_within(folder: Path, name: str, largest: int) -> BinaryIO:
    place = place_within(folder, name)
    return _opened(place, largest, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))


def _opened(path: Path, largest: int, flags: int) -> BinaryIO:
    # O_NONBLOCK: opening a FIFO would otherwise wait for somebody to write to it.
    extra = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
    _check_plain(path.stat(), path, largest)  # to open a device may already do something
    file = open(os.open(path, flags | extra), "rb")  # noqa: PTH123, SIM115  # of a descriptor
    try:
        _check_plain(os.fstat(file.fileno()), path, largest)
    except OSError:
        file.close()
        raise
    return file


def _check_plain(about: os.stat_result, path: Path, largest: int) -> None:
    if not stat.S_ISREG(about.st_mode):
        raise OSError(errno.EINVAL, "is no plain file", str(path))
    if about.st_size > largest:
        raise OSError(errno.EFBIG, f"has more than {largest:,} bytes", str(path))


def _read(file: BinaryIO, path: Path, largest: int) -> bytes:
    size = os.fstat(file.fileno()).st_size
    content = file.read(size + 1)
    if len(content) > size:  # it has grown meanwhile
        raise OSError(errno.EFBIG, f"has more than {largest:,} bytes", str(path))
    return content


def names_within(folder: Path) -> Iterator[str]:
    """The paths of everything in a folder that is no folder, relative to it; links unfollowed.

    Raises:
        OSError: A folder cannot be read.
    """
    folders = [""]
    while folders:
        prefix = folders.pop()
        with os.scandir(folder / prefix) as entries:
            for entry in entries:
                name = f"{prefix}{entry.name}"
                if entry.is_dir(follow_symlinks=False):
                    folders.append(f"{name}/")
                else:
                    yield name


def parse_json(content: bytes) -> Any:
    """The data of a JSON file, whose numbers are finite and whose texts can be printed.

    Raises:
        ValueError: It is no JSON, a key occurs twice in an object, it is nested too deeply, has
            more values than its length has room for, a number is not finite or has more than 64
            bits, or a text has control characters.
    """
    values = sum(map(content.count, (b",", b"[", b"{")))
    if values > _FEWEST_VALUES + len(content) // _BYTES_PER_VALUE:
        raise ValueError(f"{values:,} values are more than a file of {len(content):,} bytes has")
    try:
        data = json.loads(content, parse_constant=_refuse, object_pairs_hook=_object)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    _check_values(data)
    return data


def _refuse(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        raise ValueError("an object has a key twice")
    return made


def _check_values(data: Any) -> None:
    """Check all values, level by level, so that no nesting is too deep for this function."""
    level = [data]
    for _ in range(DEEPEST_JSON + 1):
        inner: list[Any] = []
        for value in level:
            if isinstance(value, dict):
                for key in value:
                    _check_text(key)
                inner += value.values()
            elif isinstance(value, list):
                inner += value
            elif isinstance(value, str):
                _check_text(value)
            elif isinstance(value, float) and not math.isfinite(value):
                raise ValueError("a number is not finite")
            elif isinstance(value, int) and abs(value) >= _LARGEST_INTEGER:
                raise ValueError("a number has more than 64 bits")
        if not inner:
            return
        level = inner
    raise ValueError(f"it is nested more than {DEEPEST_JSON} deep")


def _check_text(text: str) -> None:
    if _UNPRINTABLE.search(text):
        raise ValueError(f"the text {text[:40]!a} has control characters")
