"""Digests of files, by which two places can be compared file by file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

Digests = Mapping[str, str]
"""SHA-256 of each file, in hexadecimal, by its name."""

_NOT_SOURCE = ("__pycache__",)
_LEFT_OUT = (".pyc", ".pyo")


def digest(content: bytes) -> str:
    """SHA-256, in hexadecimal."""
    return hashlib.sha256(content).hexdigest()


def digest_of(data: Any) -> str:
    """The digest of what JSON can hold, whatever the order of its keys."""
    return digest(json.dumps(data, sort_keys=True, ensure_ascii=True).encode())


def digests(files: Iterable[Path], bases: Iterable[tuple[Path, str]] = ()) -> dict[str, str]:
    """The digest of each file.

    Args:
        files: Which; each counts once.
        bases: Folders that names are relative to, with what the names then begin with; the first
            that a file lies in counts. A file that lies in none is called by its own name.
    """
    known = list(bases)
    return {
        _name(file, known): digest(file.read_bytes())
        for file in sorted({file.resolve() for file in files})
    }


def _name(file: Path, bases: Iterable[tuple[Path, str]]) -> str:
    for folder, prefix in bases:
        if file.is_relative_to(folder.resolve()):
            return prefix + file.relative_to(folder.resolve()).as_posix()
    return file.name


def digests_of_folder(folder: Path, apart: Collection[str] = ()) -> dict[str, str]:
    """The digest of every file in a folder, what Python caches and hidden files left out.

    Args:
        folder: Which.
        apart: Folders right in it that are left out.
    """
    files = [
        file
        for file in folder.rglob("*")
        if file.suffix not in _LEFT_OUT
        and not any(
            part in _NOT_SOURCE or part.startswith(".") for part in file.relative_to(folder).parts
        )
        and file.relative_to(folder).parts[0] not in apart
        and file.is_file()
    ]
    return digests(files, [(folder, f"{folder.name}/")])


def differences(there: Digests, here: Digests) -> tuple[str, ...]:
    """Every file that is not the same, in words: ``a.py``, ``b.py is gone``, ``c.py is new``."""
    told = []
    for name in sorted({*there, *here}):
        if name not in here:
            told.append(f"{name} is gone")
        elif name not in there:
            told.append(f"{name} is new")
        elif there[name] != here[name]:
            told.append(name)
    return tuple(told)
