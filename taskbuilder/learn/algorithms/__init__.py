"""The learning algorithms by name, each in a module with its settings and presets.

Each module defines an `Algorithm` named ``ALGORITHM``. It is imported on first use, so that only
training needs torch. To add an algorithm, write a module and add a line to ``MODULES``.
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
"""The module of each algorithm."""


def find_algorithm(name: str) -> Algorithm:
    """The algorithm with a given name.

    Raises:
        UsageError: There is no such algorithm.
    """
    check_name(name)
    algorithm: Algorithm = import_module(MODULES[name]).ALGORITHM
    return algorithm


def check_name(name: str) -> None:
    """Refuse an unknown name.

    Raises:
        UsageError: There is no algorithm with this name.
    """
    if name not in MODULES:
        raise UsageError(f'no algorithm "{name}"; {suggestion(name, MODULES, what="one of")}')
