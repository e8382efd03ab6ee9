"""Packages that import what they export when it is first used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

Names = tuple[Callable[[str], Any], Callable[[], list[str]]]


def exported(package: str, homes: Mapping[str, str]) -> Names:
    """``__getattr__`` and ``__dir__`` of a package.

    Args:
        package: Its full name.
        homes: The full name of the module that each exported name is in.
    """

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(homes[name]), name)

    return get, lambda: sorted(homes)
