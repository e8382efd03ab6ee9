"""The environment that a data set was recorded in.

The task of a data set is looked up in the catalogue. A task of somebody's own comes with the data
set; as it is code, it is imported only after somebody has said to trust its digest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from taskbuilder.arrays import StoreError
from taskbuilder.carried import (
    LARGEST,
    CarriedTask,
    Trust,
    UntrustedTaskError,
    is_trusted,
    load_carried,
)
from taskbuilder.data import layout
from taskbuilder.digests import differences
from taskbuilder.env.options import Renderer, from_json, make_options
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError, display_path
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.sources import digests_of_task
from taskbuilder.task import Task, load_task


def make_from(
    folder: str | Path,
    *,
    task: str | Path | Task | None = None,
    variation: int | None = None,
    cameras: bool = True,
    renderer: Renderer | None = None,
    catalogue: Catalogue | None = None,
    trust: bool | str = False,
) -> TaskEnv:
    """Make the environment in which a data set was recorded, with the same options.

    Args:
        folder: Folder of the data set.
        task: The task, if the data set has several tasks; or the path of the task file, if the task
            is not in the catalogue.
        variation: Number of the variation; by default the first variation that was recorded.
        cameras: Whether agents observe the images of the recorded cameras, with the image size and
            the renderer of the data set.
        renderer: Renderer to use instead of the data set's own; the images then differ from the
            recorded images.
        catalogue: Catalogue in which to look up the task; by default the catalogue of this
            installation.
        trust: Whether to run a task that comes with the data set, if the catalogue does not have
            the same task: False, True, or the SHA-256 of the task that is trusted. Such a task is a
            Python program of whoever made the data set.

    Raises:
        UsageError: The folder is not a data set, or the data set has several tasks and ``task`` is
            not given; or the task comes with the data set and is not trusted.
        UnknownNameError: The task is not in the catalogue and does not come with the data set.
        FileError: The task has errors.
        StoreError: The data set is damaged.
        SimulationError: The renderer of the data set does not work on this machine; give another
            as ``renderer``.
    """
    about = layout.read_about(Path(folder))
    loaded = task_of_dataset(about, Path(folder), task, catalogue, trust)
    options = options_of_dataset(about, cameras=cameras)
    if renderer is not None:
        options["renderer"] = renderer
    if variation is None:
        played = about["collected"]["variations"]
        variation = 0 if played == "all" else played[0]
    return TaskEnv(loaded, make_options(**{**options, "variation": variation}))


def options_of_dataset(about: Mapping[str, Any], *, cameras: bool) -> dict[str, Any]:
    """The options of the environment of a data set, besides the variation.

    Args:
        about: What the data set says of itself.
        cameras: Whether agents observe the recorded cameras.
    """
    options: dict[str, Any] = from_json(about["options"])
    collected = about["collected"]
    if cameras and collected["cameras"]:
        options["cameras"] = tuple(collected["cameras"])
        options["camera_size"] = tuple(collected["size"]) if collected["size"] else None
        options["renderer"] = about["renderer"]
    return options


def played_options(about: Mapping[str, Any]) -> dict[str, Any]:
    """The options of the environment of a data set, with its cameras and its variation.

    The variation is ``random`` if several were played.

    Args:
        about: What the data set says of itself.
    """
    played = about["collected"]["variations"]
    variation = played[0] if played != "all" and len(set(played)) == 1 else "random"
    return {**options_of_dataset(about, cameras=True), "variation": variation}


def task_of_dataset(
    about: Mapping[str, Any],
    folder: Path,
    task: str | Path | Task | None = None,
    catalogue: Catalogue | None = None,
    trust: Trust = False,
) -> Task:
    """The task of a data set; for the arguments and errors see `make_from`.

    A name leads to the catalogue, never to a path. What comes with the data set is used where the
    catalogue has no such task, or another one, and only if it is trusted.
    """
    names = list(about["tasks"])
    if isinstance(task, Task):
        return _recorded(task, names, folder)
    if task is None and len(names) > 1:
        raise UsageError(f"{display_path(folder)} has several tasks; name one: {', '.join(names)}")
    catalogue = catalogue or Catalogue.discover()
    if task is not None and str(task) not in names:
        return _recorded(load_task(task, catalogue=catalogue), names, folder)
    name = str(task) if task is not None else str(names[0])
    carried = carried_task(about, folder, name)
    if name not in catalogue.tasks and carried is not None:
        return _trusted(carried, folder, trust)
    here = load_task(catalogue.named_task(name).file, catalogue=catalogue)
    if carried is None or trust is False:
        return here
    same = not differences(about["tasks"][name]["files"], digests_of_task(here))
    return here if same else _trusted(carried, folder, trust)


def _recorded(task: Task, names: Sequence[str], folder: Path) -> Task:
    """A task that was named, if the data set has episodes of it.

    Raises:
        UsageError: It has none.
    """
    if task.name not in names:
        where = display_path(folder)
        raise UsageError(f"{where} has no episodes of {task.name}; it has: {', '.join(names)}")
    return task


def carried_task(about: Mapping[str, Any], folder: Path, task: str) -> CarriedTask | None:
    """The task that comes with a data set; None if there is none. Nothing is imported.

    Args:
        about: What the data set says of itself.
        folder: Of the data set.
        task: Name of the task.

    Raises:
        StoreError: A file of it is missing, or is not as it was written.
    """
    record = about["tasks"][task].get("carried")
    if record is None:
        return None
    files, left = {}, LARGEST
    for name, digest in record["files"].items():
        file = f"{layout.TASKS}/{task}/{name}"
        if layout.digest_file(folder, file) != digest:
            raise StoreError(f"{display_path(folder / file)} is not as it was written")
        files[name] = layout.read_file(folder, file, left)
        left -= len(files[name])
    return CarriedTask(record["file"], tuple(record["folders"]), files)


def tasks_to_trust(
    about: Mapping[str, Any], folder: Path, catalogue: Catalogue, task: str | None = None
) -> list[CarriedTask]:
    """The tasks that come with a data set and that the catalogue does not have.

    Args:
        about: What the data set says of itself.
        folder: Of the data set.
        catalogue: The catalogue.
        task: Name of the only task that counts; by default all.

    Raises:
        StoreError: A file of a task is missing, or is not as it was written.
    """
    names = [task] if task is not None else list(about["tasks"])
    carried_tasks = (
        carried_task(about, folder, name) for name in names if name not in catalogue.tasks
    )
    return [carried for carried in carried_tasks if carried is not None]


def where_carried(folder: Path, carried: CarriedTask) -> str:
    """Where in a data set the file of a task is, as messages show it."""
    return display_path(folder / layout.TASKS / carried.name / carried.file)


def _trusted(carried: CarriedTask, folder: Path, trust: Trust) -> Task:
    """Load a task that comes with a data set.

    Raises:
        UntrustedTaskError: It is not trusted.
    """
    if is_trusted(carried, trust):
        return load_carried(carried)
    what = "this is not the one that is trusted" if trust else "it is not in the catalogue here"
    where = where_carried(folder, carried)
    raise UntrustedTaskError(
        f"the task {carried.name} comes with the data set, and {what}. A task is a program: read "
        f"{where} and the Python file beside it, then give --trust (in Python: trust=True), or "
        f"name the folder of your own copy by --task-path. SHA-256: {carried.digest}",
        carried,
    )
