"""The benchmark: methods measured on suites of tasks, by protocols that others can repeat.

The package can be called: ``taskbuilder.benchmark("seed", "bench/bc", algorithm="bc")`` is
`taskbuilder.benchmark.running.benchmark`.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from taskbuilder.benchmark.running import benchmark

    __all__ = ["benchmark"]


class _Benchmark(ModuleType):
    """A package by the name of a function, as which it can be used."""

    @property
    def benchmark(self) -> Any:
        """The function; its module is imported when it is first used."""
        return import_module("taskbuilder.benchmark.running").benchmark

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        return self.benchmark(*arguments, **options)


sys.modules[__name__].__class__ = _Benchmark
