"""Parts that other packages add to the library: found by entry points, imported when first used.

A package declares its parts under the groups below, such as ``taskbuilder.action_modes``. Looking
for them reads what is declared, and imports nothing. What is found is kept for each import path.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from taskbuilder.errors import ExtensionError, TaskbuilderError, UnknownNameError
from taskbuilder.wording import suggestion


@dataclass(frozen=True)
class ForeignPart:
    """A part of the library that another package declares.

    Attributes:
        noun: What it is: "action mode".
        name: Its name.
        value: Where it is: ``module:attribute``.
        package: Name and version of the package that declares it.
    """

    noun: str
    name: str
    value: str
    package: str

    def __str__(self) -> str:
        return f'the {self.noun} "{self.name}" of {self.package} ({self.value})'

    def error(self, message: str) -> ExtensionError:
        """An error that says what is wrong with this part."""
        return ExtensionError(f"{self} {message}; update or remove {self.package.split()[0]}")

    def load(self, problem: Callable[[Any], str | None]) -> Any:
        """Import it.

        Args:
            problem: What is wrong with what is found there, such as "is no subclass of ArmMode".

        Raises:
            ExtensionError: It cannot be imported, or is not what it has to be.
        """
        module, _, attribute = self.value.partition(":")
        try:
            found: Any = import_module(module.strip())
            for name in filter(None, attribute.strip().split(".")):
                found = getattr(found, name)
        except (Exception, SystemExit) as error:
            raise self.error(f"cannot be imported: {_described(error)}") from error
        if wrong := problem(found):
            raise self.error(wrong)
        return found

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Name the package in errors of its code; taskbuilder's own errors pass as they are.

        Raises:
            ExtensionError: The code of the package raised an error.
        """
        try:
            yield
        except (TaskbuilderError, OSError, MemoryError):
            raise
        except Exception as error:
            raise self.error(f"failed: {_described(error)}") from error


@dataclass(frozen=True)
class Door:
    """A kind of part that packages can add.

    Attributes:
        group: The group of entry points.
        noun: What a part is called.
    """

    group: str
    noun: str

    def declared(self) -> Mapping[str, tuple[ForeignPart, ...]]:
        """All parts that packages declare, by name; several only where a name is there twice."""
        return _declared(self, tuple(sys.path))

    def names(self, own: Collection[str] = ()) -> tuple[str, ...]:
        """The library's own names, then those of packages."""
        return (*own, *(name for name in self.declared() if name not in own))

    def problem(self, name: str, own: Collection[str] = ()) -> str | None:
        """What is wrong with a name that packages declare, or None.

        Args:
            name: The name.
            own: The library's own names. One of these is never another package's; that a package
                declares it, too, is said once.
        """
        parts = self.declared().get(name, ())
        if name in own:
            for part in parts:
                _tell_of_own_name(part)
            return None
        if len(parts) < 2:
            return None
        packages = " and ".join(f"{part.package} ({part.value})" for part in parts)
        return f'the {self.noun} "{name}" is declared twice, by {packages}; remove one of them'

    def part(self, name: str, own: Collection[str] = ()) -> ForeignPart | None:
        """The part of a name; None for the library's own.

        Raises:
            UnknownNameError: There is none of this name.
            ExtensionError: Two packages declare it.
        """
        if wrong := self.problem(name, own):
            raise ExtensionError(wrong)
        if name in own:
            return None
        if name not in self.declared():
            known = self.names(own)
            raise UnknownNameError(
                f'no {self.noun} "{name}"; {suggestion(name, known, what="one of")}'
            )
        return self.declared()[name][0]


ACTION_MODES = Door("taskbuilder.action_modes", "action mode")
ALGORITHMS = Door("taskbuilder.algorithms", "algorithm")
CHANNELS = Door("taskbuilder.channels", "observation channel")
CHECKS = Door("taskbuilder.checks", "check")
CONDITIONS = Door("taskbuilder.conditions", "condition")
DATA_FORMATS = Door("taskbuilder.data_formats", "data set format")
RENDERERS = Door("taskbuilder.renderers", "renderer")
REPORT_FORMATS = Door("taskbuilder.report_formats", "report format")

DOORS = (
    *(ACTION_MODES, ALGORITHMS, CHANNELS, CHECKS, CONDITIONS),
    *(DATA_FORMATS, RENDERERS, REPORT_FORMATS),
)
"""Every kind of part that packages can add, besides tasks and robots, which are files."""


def declares(group: str) -> bool:
    """Whether an installed package has entry points of a group; far quicker than finding them."""
    return any(f"[{group}]".encode() in text for text in _entry_points(tuple(sys.path)))


def forget() -> None:
    """Look anew for what packages declare, in folders that have been looked at already."""
    for kept in (_declared, _entry_points, _tell_of_own_name):
        kept.cache_clear()


@cache
def _entry_points(path: tuple[str, ...]) -> tuple[bytes, ...]:
    """The entry points of all packages that have any of taskbuilder's, as text."""
    texts = []
    for place in path:
        for pattern in ("*.dist-info/entry_points.txt", "*.egg-info/entry_points.txt"):
            for file in Path(place or ".").glob(pattern):
                with suppress(OSError):
                    texts.append(file.read_bytes())
    return tuple(text for text in texts if b"[taskbuilder." in text)


@cache
def _declared(door: Door, path: tuple[str, ...]) -> Mapping[str, tuple[ForeignPart, ...]]:
    del path  # the finders of Python read it
    if not declares(door.group):
        return {}
    from importlib.metadata import entry_points  # slow to import, and reads every package

    parts: dict[str, dict[ForeignPart, None]] = {}
    for point in sorted(entry_points(group=door.group)):
        package = f"{point.dist.name} {point.dist.version}" if point.dist else "an unknown package"
        part = ForeignPart(door.noun, point.name, point.value, package)
        parts.setdefault(point.name, {})[part] = None
    return {name: tuple(same) for name, same in parts.items()}


@cache
def _tell_of_own_name(part: ForeignPart) -> None:
    import logging  # `--help` does without

    from taskbuilder.quiet import HINTS

    logging.getLogger(HINTS).warning(
        "%s has the name of one of taskbuilder's own, which is used; %s must rename it",
        part,
        part.package.split()[0],
    )


def _described(error: BaseException) -> str:
    """The last line of a traceback."""
    lines = str(error).strip().splitlines()
    return f"{type(error).__name__}: {lines[0]}" if lines else type(error).__name__
