"""The learning algorithms, each in a module of its own name with its settings and presets.

Each module defines an `Algorithm` named ``ALGORITHM``. It is imported on first use, so that only
training needs torch, and the command's help needs none of them.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.extensions import ALGORITHMS as DOOR
from taskbuilder.extensions import ForeignPart

if TYPE_CHECKING:
    from taskbuilder.learn.learner import Algorithm

ALGORITHMS = tuple(
    sorted(file.stem for file in Path(__file__).parent.glob("*.py") if file.stem[0] != "_")
)
"""The names of the library's algorithms: those of the modules beside this one."""


def find_algorithm(name: str) -> Algorithm:
    """The algorithm with a given name; also one that another package adds.

    Raises:
        UsageError: There is no such algorithm.
        ExtensionError: It is of another package, and cannot be used.
    """
    part = _part(name)
    if part is not None:
        from taskbuilder.learn.foreign_learner import load_algorithm

        return load_algorithm(part)
    algorithm: Algorithm = import_module(f"{__name__}.{name}").ALGORITHM
    return algorithm


def check_name(name: str) -> None:
    """Refuse an unknown name.

    Raises:
        UsageError: There is no algorithm with this name.
        ExtensionError: Two packages have an algorithm with this name.
    """
    _part(name)


def package_of(name: str) -> str:
    """Name and version of the package that adds an algorithm; "" for the library's own.

    Raises:
        UsageError: There is no algorithm with this name.
        ExtensionError: Two packages have an algorithm with this name.
    """
    part = _part(name)
    return part.package if part is not None else ""


def _part(name: str) -> ForeignPart | None:
    try:
        return DOOR.part(name, ALGORITHMS)
    except UnknownNameError as error:
        raise UsageError(str(error)) from None
