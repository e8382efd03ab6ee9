"""The metadata of a report: versions, date and duration."""

from __future__ import annotations

import platform
import time
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version

from taskbuilder import __version__
from taskbuilder.engine import PACKAGES as ENGINES
from taskbuilder.validate.report import Making

_PACKAGES = (*ENGINES, "numpy", "gymnasium", "pettingzoo", "pydantic")
"""Packages that figures and verdicts depend on."""


class Stopwatch:
    """Measures the duration of a validation."""

    def __init__(self) -> None:
        self._date = datetime.now(UTC)
        self._started = time.perf_counter()

    def making(self, level: str, seeds: int, only: tuple[str, ...] | None = None) -> Making:
        """The metadata of a validation that ends now."""
        return Making(
            level,
            seeds if level != "static" else 0,
            f"{self._date:%Y-%m-%d %H:%M} UTC",
            time.perf_counter() - self._started,
            _versions(),
            only=only,
        )


def _versions() -> dict[str, str]:
    found = {"taskbuilder": __version__, "Python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # as in a program that was packed into one file
            continue
    return {**found, platform.system(): platform.machine()}
