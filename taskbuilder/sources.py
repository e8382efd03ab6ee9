"""Digests of the files that a result depends on: those of the library, and those of a task."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from taskbuilder.assets.mesh import Mesh
from taskbuilder.assets.model import Urdf
from taskbuilder.assets.paths import pybullet_data_folder
from taskbuilder.digests import Digests, digests, digests_of_folder
from taskbuilder.task import Task

LIBRARY = Path(__file__).resolve().parent
"""The folder of taskbuilder itself."""

NOT_LIBRARY = ("tasks", "robots")
"""Folders of tasks and robots in it; these have digests of their own."""


def digests_of_library() -> Digests:
    """Digests of taskbuilder's own files."""
    return digests_of_folder(LIBRARY, NOT_LIBRARY)


def digests_of_task(task: Task) -> Digests:
    """Digests of a task's files: its own, those beside it that it imports, robots and meshes."""
    bases = [(task.file.entry.root, "")]
    models = task.file.robots.values()
    bases += [(model.entry.root, f"{model.name}/") for model in models]
    data = pybullet_data_folder()
    if data is not None:
        bases.append((data, f"{data.name}/"))
    return digests(_files(task), bases)


def files_to_carry(task: Task) -> frozenset[Path]:
    """The files of a task that come with no package; none if the task itself is in a package."""
    if task.file.entry.trusted:
        return frozenset()
    data = pybullet_data_folder()
    packaged = [model.entry.root for model in task.file.robots.values() if model.entry.trusted]
    folders = [*packaged, *([data] if data is not None else [])]
    files = {file.resolve() for file in _files(task)}
    return frozenset(f for f in files if not any(f.is_relative_to(folder) for folder in folders))


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
    for asset in task.file.assets.values():
        yield from _files_of(asset)


def _files_of(asset: Mesh | Urdf) -> Iterator[Path]:
    yield asset.path
    if isinstance(asset, Urdf):
        yield from asset.meshes
