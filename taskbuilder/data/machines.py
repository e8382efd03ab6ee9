"""What the bits of a data set depend on besides files: the machines and versions that made it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from taskbuilder.digests import digest_of
from taskbuilder.machine import processor, system, versions

PICTURE_PACKAGES = ("av", "numba", "fast-simplification")
"""Packages that make pictures and videos, and no other numbers."""

_KERNEL = "kernel"


def machine_here(*, pictures: bool) -> dict[str, Any]:
    """Versions, processor and system of this machine.

    Args:
        pictures: Whether the packages that make pictures count.
    """
    used = versions()
    if pictures:
        for name in PICTURE_PACKAGES:
            with suppress(PackageNotFoundError):
                used[name] = version(name)
    return {"versions": used, "processor": processor(), "system": system()}


def machine_of_episode(machine: Mapping[str, Any]) -> dict[str, str]:
    """What an episode says of the machine that played it; the same for machines of one kind.

    Args:
        machine: As `machine_here` has it; a data set says the same of the machine that began it.
    """
    system = {name: value for name, value in machine["system"].items() if name != _KERNEL}
    name = machine["processor"].get("name") or machine["processor"].get("architecture", "")
    return {
        "processor": str(name),
        "digest": digest_of([machine["versions"], machine["processor"], system]),
    }


def machine_changes(
    there: Mapping[str, Any], here: Mapping[str, Any]
) -> Iterator[tuple[str, str | None, str | None]]:
    """In what machines and versions differ that may change the last digits of numbers.

    Args:
        there: What a data set says of itself.
        here: ``versions``, ``processor`` and ``system`` of this machine.

    Yields:
        What differs, how it is there, and how it is here.
    """
    for name in ("versions", "processor", "system"):
        then, now = there.get(name, {}), here[name]
        for key in dict.fromkeys((*then, *now)):
            counts = name != "system" or key == "c library"  # no number depends on the kernel
            if counts and then.get(key) != now.get(key):
                yield f"{name}: {key}", then.get(key), now.get(key)
