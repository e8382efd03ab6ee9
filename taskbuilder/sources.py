"""Digests of the files that a result depends on: those of the library, and those of a task."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from taskbuilder.assets.mesh import Mesh
from taskbuilder.assets.model import Urdf
from taskbuilder.assets.paths import pybullet_data_folder
from taskbuilder.digests import Digests, digests, digests_of_folder
from taskbuilder.schema.load import TaskFile
from taskbuilder.task import Task

LIBRARY = Path(__file__).resolve().parent
"""The folder of taskbuilder itself."""

NOT_LIBRARY = ("tasks", "robots", "objects")
"""Folders of tasks, robots and objects in it; these have digests of their own."""


def digests_of_library() -> Digests:
    """Digests of taskbuilder's own files."""
    return digests_of_folder(LIBRARY, NOT_LIBRARY)


def digests_of_task(task: Task) -> Digests:
    """Digests of a task's files: its own, those beside it that it imports, robots and meshes."""
    return digests(_files(task), _bases(task.file))


def digests_of_objects(file: TaskFile) -> Digests:
    """Digests of the files that the objects of a task are made of."""
    return digests(_files_of_objects(file), _bases(file))


def _bases(file: TaskFile) -> list[tuple[Path, str]]:
    """Folders that the names of a task's files are relative to, with what they then begin with."""
    bases = [(file.entry.root, "")]
    bases += [(folder, f"{name}/") for name, folder, _ in _folders_of_models(file)]
    data = pybullet_data_folder()
    return bases if data is None else [*bases, (data, f"{data.name}/")]


def files_to_carry(task: Task, *, packaged: bool = False) -> frozenset[Path]:
    """The files of a task that come with no package; none if the task itself is in a package.

    Args:
        task: The task.
        packaged: Whether the files of a task in a package count, too, apart from those of robots
            and objects of the catalogue.
    """
    if task.file.entry.trusted and not packaged:
        return frozenset()
    data = pybullet_data_folder()
    models = [folder for _, folder, trusted in folders_of_models(task) if trusted]
    folders = [*models, *([data] if data is not None else [])]
    files = {file.resolve() for file in _files(task)}
    return frozenset(f for f in files if not any(f.is_relative_to(folder) for folder in folders))


def folders_of_models(task: Task) -> list[tuple[str, Path, bool]]:
    """Name and folder of each robot and object of the catalogue, and whether it is packaged."""
    return _folders_of_models(task.file)


def _folders_of_models(file: TaskFile) -> list[tuple[str, Path, bool]]:
    robots = [(robot.name, robot.entry) for robot in file.robots.values()]
    objects = [(thing.spec.object, thing.entry) for thing in file.models.values()]
    return [(name, entry.root, entry.trusted) for name, entry in (*robots, *objects)]


def _files(task: Task) -> Iterator[Path]:
    entry = task.file.entry
    yield entry.file
    yield entry.description_file
    # A description may import any Python file of its folder, so all of them count.
    if not entry.module:
        yield from entry.root.glob("*.py")
    for model in task.file.robots.values():
        yield model.entry.file
        yield from _files_of(model.urdf)
    yield from _files_of_objects(task.file)


def _files_of_objects(file: TaskFile) -> Iterator[Path]:
    for thing in file.models.values():
        yield thing.entry.file
    for asset in (*file.assets.values(), *file.collisions.values()):
        yield from _files_of(asset)


def _files_of(asset: Mesh | Urdf) -> Iterator[Path]:
    yield asset.path
    if isinstance(asset, Urdf):
        yield from asset.meshes
