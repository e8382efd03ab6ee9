"""Sub-tasks as numbers: the stages of the expert that are under way in each control step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.data.dataset import RecordedEpisode
from taskbuilder.schema.expert import DONE

NO_SUBTASK = "none"


def subtask_labels(task: Mapping[str, Any]) -> tuple[str, ...]:
    """The labels of sub-tasks in the order of their numbers; number 0 is ``none``.

    Equal stages have the same label.

    Args:
        task: What the data set says of the task.
    """
    return tuple(dict.fromkeys((NO_SUBTASK, *task["expert"], DONE)))


def subtask_numbers(episode: RecordedEpisode, labels: tuple[str, ...]) -> NDArray[np.int64]:
    """The number of the label in each control step: (steps,).

    Args:
        episode: An episode.
        labels: All labels of its task.
    """
    places = {label: number for number, label in enumerate(labels)}
    numbers = {0: 0, **{part["stage"]: places[part["label"]] for part in episode.subtasks}}
    rows = [numbers[stage] for stage in episode.arrays["subtask"].tolist()]
    return np.array(rows, dtype=np.int64)


def subtask_begins(episode: RecordedEpisode) -> list[tuple[int, str]]:
    """The control step at which each sub-task of an episode begins, and its label.

    There is none before the first sub-task. After a stage that the expert could not complete, the
    label is ``none``.
    """
    labels = {0: NO_SUBTASK, **{part["stage"]: part["label"] for part in episode.subtasks}}
    stages = episode.arrays["subtask"]
    return [(int(n), labels[int(stages[n])]) for n in np.flatnonzero(np.diff(stages, prepend=0))]
