"""Where the files of the library are: beside the package in a checkout, inside it in a wheel."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def folder(name: str) -> Path:
    """The folder of the library's ``tasks``, ``robots`` or ``objects``."""
    inside = _PACKAGE / name
    packed = next(inside.glob("[a-z]*"), None) if inside.is_dir() else None
    return inside if packed else _PACKAGE.parent / name
