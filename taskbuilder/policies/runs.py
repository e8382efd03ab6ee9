"""The task of a training run, found without importing anything.

A run that somebody else has made may record any path, and a task is a Python program.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from taskbuilder.errors import UnknownNameError, UsageError, display_path
from taskbuilder.schema.catalogue import Catalogue, looks_like_path
from taskbuilder.untrusted import parse_json, read_within
from taskbuilder.wording import excerpt

RUN_FILE = "run.json"
"""File in the folder of a training run that describes the run."""

FORMAT = 1
"""Version of the format of a run's folder; others are refused."""

_LARGEST = 1 << 20
"""Maximum size of this file in bytes."""


def read_run(folder: Path) -> dict[str, Any]:
    """What a run says of itself.

    Raises:
        UsageError: There is no run, its file is damaged, or its format is not supported.
    """
    file, name = folder / RUN_FILE, display_path(folder)
    if not file.is_file():
        raise UsageError(f"{name} is no training run; it has no {RUN_FILE}")
    try:
        about = parse_json(read_within(folder, RUN_FILE, _LARGEST))
        version = about["format"]
    except (ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{display_path(file)} is damaged: {excerpt(error)}") from None
    if version != FORMAT:
        raise UsageError(
            f"{name} is a run of format {excerpt(version)}; this version reads {FORMAT}"
        )
    task = about.get("task")
    if not isinstance(task, str):
        raise UsageError(f"{display_path(file)} is damaged: its task is {excerpt(task)}")
    read: dict[str, Any] = about
    return read


def task_of_run(folder: Path, catalogue: Catalogue, *, trust: bool = False) -> Path:
    """Find the file of the task of a run, without importing anything.

    Args:
        folder: Folder of the run.
        catalogue: The catalogue in which the task is looked up by name, and by its file name.
        trust: Whether the task at the path that the run records may be run.

    Raises:
        UsageError: The task is not in a place that the user has named, or is not trusted.
    """
    if (path := task_to_trust(folder, catalogue)) is not None:
        if trust:
            return path
        raise UsageError(
            f"{display_path(folder)} is of the task {excerpt(path)}, which is not in the catalogue "
            "here. A task is a program: if it is yours, or you have read it, give --trust (in "
            "Python: trust=True), or name its folder by --task-path"
        )
    task = read_run(folder)["task"]
    if task not in catalogue.tasks and looks_like_path(task):
        task = Path(task).stem
    return named_task(display_path(folder), task, catalogue)


def task_to_trust(folder: Path, catalogue: Catalogue) -> Path | None:
    """The file of the task of a run if it is not in the catalogue; None if the catalogue has it.

    A run that somebody else has made may record any path. Relative paths and paths into the folder
    of the run count for nothing, because the folder could bring its own code.

    Args:
        folder: Folder of the run.
        catalogue: The catalogue, with the folders that the user has named.

    Raises:
        UsageError: There is no run.
    """
    task = read_run(folder)["task"]
    path = Path(task)
    if task in catalogue.tasks or "\0" in task or not path.is_absolute():
        return None
    path = path.resolve()  # /proc/self/cwd/task.yaml is a file of the working directory
    if path.is_relative_to(folder.resolve()) or not path.is_file():
        return None
    trusted = {entry.file.resolve() for entry in catalogue.tasks.values()}
    return None if path in trusted else path


def named_task(name: str, task: object, catalogue: Catalogue) -> Path:
    """The file of a task that is given by a plain name of the catalogue.

    Args:
        name: Name of the policy or run that refers to the task, for messages.
        task: Name of the task.
        catalogue: The catalogue to look it up in.

    Raises:
        UsageError: The catalogue has no such task.
    """
    try:
        return catalogue.named_task(task).file
    except UnknownNameError as error:
        hint = "name the folder of its files by --task-path"
        raise UsageError(f"{name} is for a task that is not here ({error}); {hint}") from None
