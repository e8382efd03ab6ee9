"""The catalogue: task, robot and object files by name.

Files come from the library itself, from folders named by ``--task-path`` or TASKBUILDER_PATH, and
from installed packages that declare the entry-point groups ``taskbuilder.tasks``,
``taskbuilder.robots`` and ``taskbuilder.objects``, whose names then read ``namespace/name``.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

from taskbuilder._library import folder as library_folder
from taskbuilder.errors import FileError, Finding, Location, UnknownNameError, display_path
from taskbuilder.extensions import declares
from taskbuilder.wording import closest, suggestion

Sort = Literal["task", "robot", "object"]

PATH_VARIABLE = "TASKBUILDER_PATH"

_ALL_TASKS = "`taskbuilder list` shows all there are"
_ALL = {"task": _ALL_TASKS, "object": "`taskbuilder objects` shows all there are"}
"""Where there are too many for one line."""

_SHOWN_BY: Mapping[Sort, str] = {
    "task": "show",
    "robot": "robots check",
    "object": "objects check",
}
"""The command that tells about one."""

SUITES = "suites.yaml"
"""The file of a folder of tasks that is no task: its suites."""


@dataclass(frozen=True)
class CatalogueEntry:
    """A task, robot or object file.

    Attributes:
        name: Its name: ``handover``, or ``namespace/name`` from another package.
        file: Absolute path of the YAML file.
        module: Dotted name of the Python module beside a packaged task file, or "".
        trusted: Part of an installed package, so its assets need no probe.
    """

    name: str
    file: Path
    module: str = ""
    trusted: bool = False

    @property
    def root(self) -> Path:
        """The folder that its assets must lie in."""
        return self.file.parent

    @property
    def description_file(self) -> Path:
        """Where a task's description is."""
        return self.file.with_suffix(".py")


@dataclass(frozen=True)
class Catalogue:
    """Finds task and robot files by their names, in installed packages and in ``folders``."""

    folders: tuple[Path, ...] = ()

    @classmethod
    def discover(cls, folders: Iterable[Path | str] = ()) -> Catalogue:
        """Make a catalogue of tasks and robots.

        They come from installed packages, from the folders that the environment variable
        TASKBUILDER_PATH names, and from ``folders``.

        Raises:
            UnknownNameError: A folder does not exist.
        """
        named = [part for part in os.environ.get(PATH_VARIABLE, "").split(os.pathsep) if part]
        paths = tuple(Path(folder).resolve() for folder in (*folders, *named))
        for path in paths:
            if not path.is_dir():
                raise UnknownNameError(f"the task path {display_path(path)} is not a folder")
        return cls(tuple(dict.fromkeys(paths)))

    @cached_property
    def tasks(self) -> Mapping[str, CatalogueEntry]:
        """All tasks by name; of several with one name, the first. See `clashes`."""
        return _first_of_each(self._entries("task"))

    @cached_property
    def robots(self) -> Mapping[str, CatalogueEntry]:
        """All robots by name; of several with one name, the first. See `clashes`."""
        return _first_of_each(self._entries("robot"))

    @cached_property
    def objects(self) -> Mapping[str, CatalogueEntry]:
        """All objects by name; of several with one name, the first. See `clashes`."""
        return _first_of_each(self._entries("object"))

    def clashes(self, sort: Sort) -> Mapping[str, tuple[Finding, ...]]:
        """What is wrong with the names that several tasks or robots have, by name.

        Such a name cannot be looked up, as it would not be clear which file is meant.
        """
        return _clashes(sort, self._known(sort), self._entries(sort))

    def task(self, reference: str) -> CatalogueEntry:
        """Look up a task by its name, or by the path of its YAML file.

        Raises:
            UnknownNameError: There is no such task or file.
            FileError: Two tasks have this name.
        """
        return self._find("task", reference, Path())

    def named_task(self, name: object) -> CatalogueEntry:
        """Look up a task by name only, never by path. Use this for names from untrusted files.

        Raises:
            UnknownNameError: There is no such task.
            FileError: Two tasks have this name.
        """
        if isinstance(name, str) and name in self.tasks:
            return self._only("task", name)
        help_ = suggestion(str(name), self.tasks, otherwise=_ALL_TASKS)
        raise UnknownNameError(f'no task "{name}"; {help_}')

    def robot(self, reference: str, folder: Path) -> CatalogueEntry:
        """Look up a robot by its name, or by the path of its robot.yaml relative to ``folder``.

        Raises:
            UnknownNameError: There is no such robot or file.
            FileError: Two robots have this name.
        """
        return self._find("robot", reference, folder)

    def object(self, reference: str, folder: Path) -> CatalogueEntry:
        """Look up an object by its name, or by the path of its object.yaml relative to ``folder``.

        Raises:
            UnknownNameError: There is no such object or file.
            FileError: Two objects have this name.
        """
        return self._find("object", reference, folder)

    def _known(self, sort: Sort) -> Mapping[str, CatalogueEntry]:
        return {"task": self.tasks, "robot": self.robots, "object": self.objects}[sort]

    def _find(self, sort: Sort, reference: str, folder: Path) -> CatalogueEntry:
        if looks_like_path(reference):
            return self._at_path(sort, folder / reference)
        known = self._known(sort)
        if reference in known:
            return self._only(sort, reference)
        otherwise = _ALL.get(sort, "")
        help_ = suggestion(reference, known, what="there are", otherwise=otherwise)
        meant = closest(reference, known)
        beside = (folder / f"{reference.removesuffix('.py')}.yaml") if reference else None
        if beside and beside.is_file():
            help_, meant = f"did you mean the file {display_path(beside)}?", None
        for other, command in _SHOWN_BY.items():
            if other != sort and reference in self._known(other):
                help_ = f"{reference} is the name of a {other}: `taskbuilder {command} {reference}`"
        raise UnknownNameError(f'no {sort} "{reference}"; {help_}', meant)

    def _only(self, sort: Sort, name: str) -> CatalogueEntry:
        """The one entry of a name."""
        wrong = self.clashes(sort).get(name)
        if wrong:
            raise FileError(wrong)
        return self._known(sort)[name]

    def _at_path(self, sort: Sort, path: Path) -> CatalogueEntry:
        if not _exists(path):
            raise UnknownNameError(f"there is no file {display_path(path)}{similar(path)}")
        if sort != "task" and (path / f"{sort}.yaml").is_file():
            path /= f"{sort}.yaml"
        if path.is_dir():
            raise UnknownNameError(f"{display_path(path)} is a folder; name the YAML file in it")
        actual = path.resolve()
        # A catalogued file opened by its path is the same task, with the same description class.
        for entry in self._entries(sort):
            if entry.file == actual:
                return entry
        return CatalogueEntry(actual.stem if sort == "task" else actual.parent.name, actual)

    def _entries(self, sort: Sort) -> tuple[CatalogueEntry, ...]:
        """What there was when it was first asked for, also of one name."""
        if sort not in self._found:
            self._found[sort] = tuple(self._look_for(sort))
        return self._found[sort]

    @cached_property
    def _found(self) -> dict[Sort, tuple[CatalogueEntry, ...]]:
        return {}

    def _look_for(self, sort: Sort) -> Iterator[CatalogueEntry]:
        yield from _packaged(sort, f"taskbuilder.{sort}s", "", [library_folder(f"{sort}s")])
        for folder in self.folders:
            for name, file in _files(sort, folder):
                yield CatalogueEntry(name, file)
        for namespace, package in _plugins(f"taskbuilder.{sort}s"):
            yield from _packaged(sort, package, f"{namespace}/", _folders_of(package))


def looks_like_path(reference: str) -> bool:
    """Whether a reference is a path rather than a name: by its ending, or by leading to a file."""
    if reference.endswith((".yaml", ".yml")) or reference.startswith((".", "/", "~")):
        return True
    return os.sep in reference and _exists(Path(reference))


def _exists(path: Path) -> bool:
    """Whether a path leads anywhere; one that no file can have does not."""
    try:
        path.stat()
    except (OSError, ValueError):
        return False
    return True


def similar(path: Path) -> str:
    """A hint at the file that a wrong path was probably meant to lead to."""
    try:
        if path.is_symlink():
            return "; it is a link that leads nowhere"
        beside = [file.name for file in path.parent.iterdir()]
    except (OSError, ValueError):
        return ""
    near = closest(path.name, beside)
    return f"; did you mean {display_path(path.with_name(near))}?" if near else ""


def _files(sort: Sort, folder: Path) -> Iterator[tuple[str, Path]]:
    pattern = "*.yaml" if sort == "task" else f"*/{sort}.yaml"
    for file in sorted(folder.glob(pattern)):
        if file.name in ("robot.yaml", "object.yaml", SUITES) and sort == "task":
            continue
        name = file.stem if sort == "task" else file.parent.name
        if not name.startswith((".", "_")):
            yield name, file.resolve()


def _packaged(
    sort: Sort, package: str, prefix: str, folders: Iterable[Path]
) -> Iterator[CatalogueEntry]:
    for folder in folders:
        for name, file in _files(sort, folder):
            yield CatalogueEntry(f"{prefix}{name}", file, f"{package}.{name}", trusted=True)


def _folders_of(package: str) -> list[Path]:
    from importlib.util import find_spec

    try:
        spec = find_spec(package)
    except ImportError:  # an installed package that lost its tasks: the others are still there
        spec = None
    return [Path(place) for place in spec.submodule_search_locations or ()] if spec else []


def _plugins(group: str) -> Iterator[tuple[str, str]]:
    if not declares(group):
        return
    from importlib.metadata import entry_points  # slow to import, and reads every package

    for point in sorted(entry_points(group=group)):
        yield point.name, point.value


def _first_of_each(entries: Iterable[CatalogueEntry]) -> Mapping[str, CatalogueEntry]:
    known: dict[str, CatalogueEntry] = {}
    for entry in entries:
        known.setdefault(entry.name, entry)
    return known


def _clashes(
    sort: Sort, known: Mapping[str, CatalogueEntry], entries: Iterable[CatalogueEntry]
) -> Mapping[str, tuple[Finding, ...]]:
    clashes: dict[str, tuple[Finding, ...]] = {}
    for entry in entries:
        other = known[entry.name]
        if other.file != entry.file:
            message = (
                f'the {sort} "{entry.name}" is also {display_path(other.file)}; '
                f"rename one of them, or take its folder off the task path"
            )
            finding = Finding("TB008", message, location=Location(entry.file))
            clashes[entry.name] = (*clashes.get(entry.name, ()), finding)
    return clashes
