"""Files of numbers: named arrays and a few words about them, without pickle.

A file is a zip of .npy arrays, as NumPy writes them, one of which holds JSON. Every array has a
checksum, and the zip's table of contents comes last, so a file that was cut off is found out.
"""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import TaskbuilderError, display_path
from taskbuilder.files import write_whole

Arrays = dict[str, NDArray[Any]]

_ABOUT = "about.json"

_DAMAGED = (
    *(zipfile.BadZipFile, zlib.error, EOFError, OSError),
    *(ValueError, KeyError, TypeError, RuntimeError),
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
    words = np.frombuffer(json.dumps(about).encode(), dtype=np.uint8)
    content = io.BytesIO()
    # As numpy.savez, which has no place for arrays with the names of its own parameters.
    with zipfile.ZipFile(content, "w") as file:
        for name, array in {_ABOUT: words, **arrays}.items():
            with file.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as part:
                np.lib.format.write_array(part, np.asanyarray(array), allow_pickle=False)
    write_whole(path, content.getvalue(), sync=True)


def read_arrays(path: Path, kind: str) -> tuple[Arrays, dict[str, Any]]:
    """Read a whole file and verify it.

    Args:
        path: Where it is.
        kind: What its words must say it is.

    Raises:
        StoreError: It is cut off, changed, or another kind of file.
        OSError: It cannot be read.
    """
    name = display_path(path)
    content = path.read_bytes()
    try:
        _check_sums(content)
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = {key: file[key] for key in file.files}
        about = json.loads(arrays.pop(_ABOUT).tobytes())
    except _DAMAGED as error:
        raise StoreError(f"{name}: is damaged, or no file of taskbuilder's ({error})") from None
    found = about.get("kind") if isinstance(about, dict) else None
    if found != kind:
        raise StoreError(f"{name}: is a {found or 'foreign file'}; a {kind} is needed")
    return arrays, about


def _check_sums(content: bytes) -> None:
    """Verify all arrays before any is made: a damaged shape could ask for all memory."""
    with zipfile.ZipFile(io.BytesIO(content)) as file:
        damaged, found = file.testzip(), len(file.infolist())
    if damaged is not None:
        raise zipfile.BadZipFile(f"{damaged} has another checksum")
    # Nothing sums up the table of contents, but the file's end says how long it should be.
    if found != int.from_bytes(content[-12:-10], "little"):
        raise zipfile.BadZipFile("its table of contents has gaps")
