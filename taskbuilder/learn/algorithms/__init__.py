"""The learning algorithms, each in a module of its own name with its settings and presets.

Each module defines an `Algorithm` named ``ALGORITHM``. It is imported on first use, so that only
training needs torch, and the command's help needs none of them.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from taskbuilder.errors import UsageError
from taskbuilder.wording import suggestion

if TYPE_CHECKING:
    from taskbuilder.learn.learner import Algorithm

ALGORITHMS = tuple(
    sorted(file.stem for file in Path(__file__).parent.glob("*.py") if file.stem[0] != "_")
)
"""The names of all algorithms: those of the modules beside this one."""


def find_algorithm(name: str) -> Algorithm:
    """The algorithm with a given name.

    Raises:
        UsageError: There is no such algorithm.
    """
    check_name(name)
    algorithm: Algorithm = import_module(f"{__name__}.{name}").ALGORITHM
    return algorithm


def check_name(name: str) -> None:
    """Refuse an unknown name.

    Raises:
        UsageError: There is no algorithm with this name.
    """
    if name not in ALGORITHMS:
        raise UsageError(f'no algorithm "{name}"; {suggestion(name, ALGORITHMS, what="one of")}')
