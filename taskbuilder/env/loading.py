"""Loading a task together with the options of its environments."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from taskbuilder.env.options import Options
from taskbuilder.env.timing import with_timing
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task, load_task


def load_with(
    options: Options,
    reference: str | Path,
    *,
    catalogue: Catalogue | None = None,
    guarded: bool = False,
) -> Task:
    """Load a task with the horizon, control rate, robots and grasping of some options.

    Args:
        options: The options.
        reference: Name or path of the task.
        catalogue: Catalogue in which to look up names; see `load_task`.
        guarded: Whether to import the description in a child process first; see `load_task`.

    Raises:
        UnknownNameError: There is no such task, or no robot of a name in the options.
        UsageError: An option does not fit the task.
        FileError: The files of the task, or of such a robot, have errors.
    """
    options.check()
    task = load_task(
        reference,
        catalogue=catalogue,
        guarded=guarded,
        robots=dict(options.robots),
        grasp=options.grasp,
    )
    return replace(task, file=with_timing(task.file, options.horizon, options.control_hz))
