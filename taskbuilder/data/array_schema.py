"""The arrays that an episode must have: their names, shapes, types and bounds.

This is the only place that knows them; everything that reads the arrays of a data set gets them
through `check_arrays`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from taskbuilder.arrays import Arrays, StoreError

OPERATOR = "operator"
"""Whose each control step of a robot was: the number of a person, counted from 1; 0 for the policy;
-1 for nobody, where the robot held still because its person had left."""

_POSE = re.compile(r"objects/[A-Za-z][A-Za-z0-9_.]{0,99}/pose")
"""Poses of movable objects; which objects can move may differ between variations."""

_LARGEST_ACTION = 1.0 + 1e-6
"""Actions are from -1 to 1; float32 may round away from zero."""

_BYTES_BESIDE = 4096
"""Most bytes of a file beside the numbers of an array: its header, and its lines in the zip."""

_MOST_OBJECTS = 1000

_LARGEST_FILE = 96 << 20
"""Most bytes of a file of arrays: 50,000 control steps of two robots."""


class ArrayKind(NamedTuple):
    """What an array must be.

    Attributes:
        shape: Its shape.
        dtype: Its type.
        largest: Most that its numbers may differ from zero.
        values: The only numbers that it may have; None for any.
    """

    shape: tuple[int, ...]
    dtype: str = "float64"
    largest: float = np.inf
    values: frozenset[int] | None = None


def expected_arrays(
    task: Mapping[str, Any], episode: Mapping[str, Any], *, normalized: bool = True
) -> dict[str, ArrayKind]:
    """The arrays of an episode by name, besides the poses of objects.

    Args:
        task: What the data set says of the task.
        episode: What the episode says of itself.
        normalized: Whether actions are from -1 to 1.
    """
    steps: int = episode["steps"]
    states = steps + 1
    stages = frozenset((0, *(part["stage"] for part in episode["subtasks"])))
    kinds = {
        "state": ArrayKind((states, len(task["state_names"])), "float32"),
        "reward": ArrayKind((steps,)),
        "progress": ArrayKind((states,)),
        "stage": ArrayKind((states,), "int64"),
        "success": ArrayKind((states,), "bool"),
        "subtask": ArrayKind((steps,), "int64", values=stages),
        **{f"terms/{name}": ArrayKind((steps,)) for name in task["terms"]},
        **{f"conditions/{name}": ArrayKind((states,), "bool") for name in task["conditions"]},
    }
    for agent, robot in task["robots"].items():
        for name, kind in _of_robot(robot, steps, normalized=normalized):
            kinds[f"agents/{agent}/{name}"] = kind
        if people := len(episode.get("operators", ())):
            labels = frozenset(range(-1, people + 1))
            kinds[f"agents/{agent}/{OPERATOR}"] = ArrayKind((steps,), "int64", values=labels)
    for camera in episode["cameras"]:
        kinds[f"cameras/{camera}/intrinsics"] = ArrayKind((3, 3))
        kinds[f"cameras/{camera}/extrinsics"] = ArrayKind((states, 4, 4))
    return kinds


def _of_robot(
    robot: Mapping[str, Any], steps: int, *, normalized: bool
) -> Iterator[tuple[str, ArrayKind]]:
    states, joints = steps + 1, len(robot["joint_names"])
    actions = (steps, len(robot["action_names"]))
    yield "observation", ArrayKind((states, len(robot["observation_names"])), "float32")
    yield "action", ArrayKind(actions, "float32", _LARGEST_ACTION if normalized else np.inf)
    yield "reward", ArrayKind((steps,))
    yield "joint_position", ArrayKind((states, joints))
    yield "joint_velocity", ArrayKind((states, joints))
    yield "joint_target", ArrayKind((steps, joints))
    yield "gripper_target", ArrayKind((steps,))
    yield "gripper", ArrayKind((states,))
    yield "tcp", ArrayKind((states, 7))


def largest_file(expected: Mapping[str, ArrayKind], steps: int) -> int:
    """Most bytes that the file of an episode's arrays can have.

    Args:
        expected: As `expected_arrays` has them.
        steps: Length of the episode in control steps.
    """
    pose = ArrayKind((steps + 1, 7))
    kinds = [*expected.values(), *[pose] * _MOST_OBJECTS]
    numbers = sum(int(np.prod(k.shape)) * np.dtype(k.dtype).itemsize for k in kinds)
    return min(numbers + _BYTES_BESIDE * (len(kinds) + 1), _LARGEST_FILE)


def check_arrays(arrays: Arrays, expected: Mapping[str, ArrayKind], steps: int, name: str) -> None:
    """Check the arrays of an episode.

    Args:
        arrays: The arrays.
        expected: As `expected_arrays` has them.
        steps: Length of the episode in control steps.
        name: Path of their file, for the message.

    Raises:
        StoreError: One is missing, is too many, has another shape or type, or has numbers that are
            not finite or too large.
    """
    for missing in expected.keys() - arrays.keys():
        raise StoreError(f"{name}: the array {missing} is missing")
    pose = ArrayKind((steps + 1, 7))
    for array in arrays:
        kind = expected.get(array) or (pose if _POSE.fullmatch(array) else None)
        if kind is None:
            raise StoreError(f"{name}: {array!a} is no array of an episode of this task")
        for wrong in _faults(arrays[array], kind):
            raise StoreError(f"{name}: the array {array} {wrong}")


def _faults(array: np.ndarray[Any, Any], kind: ArrayKind) -> Iterator[str]:
    """What is wrong with an array, in words."""
    if array.shape != kind.shape:
        yield f"has the shape {array.shape}; {kind.shape} is right"
        return
    if array.dtype != kind.dtype:
        yield f"has the type {array.dtype}; {kind.dtype} is right"
        return
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        row = int(np.argwhere(~np.isfinite(array))[0][0])
        yield f"has a number in row {row} that is not finite"
    elif np.isfinite(kind.largest) and array.size and np.abs(array).max() > kind.largest:
        yield f"has numbers up to {np.abs(array).max():.4g}; at most {kind.largest:.4g} is right"
    elif kind.values is not None and (others := set(array.tolist()) - kind.values):
        yield f"has the number {min(others)}; one of {', '.join(map(str, sorted(kind.values)))}"
