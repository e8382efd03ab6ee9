"""The algorithms by name, each in a module of its own with its settings and presets.

A module has an `Algorithm` named ``ALGORITHM``. It is imported when the algorithm is asked for, so
that only training needs torch. A new algorithm is a new module and a line in ``MODULES``.
"""

from __future__ import annotations

from importlib import import_module

from taskbuilder.errors import UsageError
from taskbuilder.learn.learner import Algorithm
from taskbuilder.wording import suggestion

MODULES = {
    "maddpg": "taskbuilder.learn.algorithms.maddpg",
    "maddpg_openai": "taskbuilder.learn.algorithms.maddpg_openai",
    "ppo": "taskbuilder.learn.algorithms.ppo",
}
"""Where each algorithm is."""


def find_algorithm(name: str) -> Algorithm:
    """The algorithm of that name.

    Raises:
        UsageError: There is none.
    """
    check_name(name)
    algorithm: Algorithm = import_module(MODULES[name]).ALGORITHM
    return algorithm


def check_name(name: str) -> None:
    """Refuse a name that no algorithm has.

    Raises:
        UsageError: There is none of that name.
    """
    if name not in MODULES:
        raise UsageError(f'no algorithm "{name}"; {suggestion(name, MODULES, what="one of")}')
