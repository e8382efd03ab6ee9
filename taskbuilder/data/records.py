"""What the JSON files of a data set must hold; more keys than these may be there.

A data set may come from anybody, so every key that the library reads has its type and its bounds
here, and what the files say of each other is compared.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, Literal, get_type_hints

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from taskbuilder.arrays import StoreError
from taskbuilder.data.videos import LARGEST_SIDE
from taskbuilder.env.options import EnvOptions
from taskbuilder.schema.expert import DONE


def _check_path(name: str) -> str:
    if "\\" in name or any(part in ("", ".", "..") for part in name.split("/")):
        raise ValueError("not a path within a folder")
    return name


_Identifier = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,39}$")]
_TaskName = Annotated[str, Field(pattern=r"^([A-Za-z][A-Za-z0-9_-]{0,39}/)?[A-Za-z]\w{0,39}$")]
_EpisodeName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,99}$")]
_Label = Annotated[str, Field(min_length=1, max_length=200)]
_Text = Annotated[str, Field(max_length=4000)]
_Digest = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
_FileName = Annotated[str, Field(pattern=r"^[A-Za-z0-9_][A-Za-z0-9_.-]{0,119}$")]
_PathName = Annotated[str, Field(min_length=1, max_length=400), AfterValidator(_check_path)]
_Seed = Annotated[int, Field(ge=0, lt=2**63)]
_Variation = Annotated[int, Field(ge=0, le=10_000)]
_Steps = Annotated[int, Field(ge=0, le=1_000_000)]
_Pixels = Annotated[int, Field(ge=2, le=LARGEST_SIDE)]
_Hertz = Annotated[int, Field(ge=1, le=100_000)]
_Names = Annotated[list[_Label], Field(max_length=10_000)]
_Numbers = Annotated[list[float], Field(max_length=10_000)]


class _Record(BaseModel):
    model_config = ConfigDict(strict=True, extra="ignore", allow_inf_nan=False)


# --- dataset.json


class _Action(_Record):
    arm: _Label
    gripper: _Label


class _Robot(_Record):
    model: _Label
    action: _Action
    action_names: Annotated[_Names, Field(min_length=1)]
    action_low: _Numbers
    action_high: _Numbers
    observation_names: _Names
    joint_names: _Names
    grasp: _Label | None = None


class _Camera(_Record):
    width: _Pixels
    height: _Pixels


class _Carried(_Record):
    file: _PathName
    folders: Annotated[list[Literal["."] | _PathName], Field(max_length=100)]
    files: Annotated[dict[_PathName, _Digest], Field(min_length=2, max_length=10_000)]


class _Task(_Record):
    task_version: Annotated[int, Field(ge=1, le=9999)] = 1
    summary: _Text
    control_hz: _Hertz
    max_episode_steps: Annotated[int, Field(ge=1, le=1_000_000)]
    variations: Annotated[int, Field(ge=1, le=10_000)]
    terms: _Names
    conditions: _Names
    expert: list[_Text]
    robots: Annotated[dict[_Identifier, _Robot], Field(min_length=1)]
    state_names: _Names
    cameras: dict[_Identifier, _Camera]
    files: dict[_Text, _Digest]
    carried: _Carried | None = None


class _Policy(_Record):
    name: _Label


class _Collected(_Record):
    episodes: Annotated[int, Field(ge=0)]
    policies: list[_Policy]
    cameras: list[_Identifier]
    size: Annotated[list[_Pixels], Field(min_length=2, max_length=2)] | None
    depth: bool
    variations: Literal["all"] | Annotated[list[_Variation], Field(min_length=1)]


class _About(_Record):
    license: Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^\n\r\t]*$")]
    collected: _Collected
    options: dict[_Label, Any]
    renderer: _Label | None
    tasks: Annotated[dict[_TaskName, _Task], Field(min_length=1, max_length=1000)]
    library: _Text
    versions: dict[_Text, _Text]
    processor: dict[_Text, Any]
    system: dict[_Text, Any]


# --- index.json


class _Line(_Record):
    name: _EpisodeName
    task: _TaskName
    seed: _Seed
    variation: _Variation
    policy: _Label
    instruction: _Text
    steps: _Steps
    success: bool
    return_: float = Field(alias="return")


class _NotKept(_Record):
    name: _EpisodeName
    task: _TaskName
    policy: _Label
    variation: _Variation = 0


class _Index(_Record):
    episodes: list[_Line]
    not_kept: list[_NotKept]


# --- episode.json


class _Video(_Camera):
    fps: _Hertz
    frames: _Steps
    video: _FileName
    depth: _FileName | None = None


class _Subtask(_Record):
    stage: Annotated[int, Field(ge=1, le=10_000)]
    label: _Text


class _Episode(_Line):
    operators: Annotated[_Names, Field(max_length=1000)] = []
    control_hz: _Hertz
    terminated: bool = False
    truncated: bool = False
    subtasks: list[_Subtask]
    cameras: dict[_Identifier, _Video]
    files: dict[_FileName, _Digest]


# --- manifest.json


class _Manifest(_Record):
    seal: _Digest
    files: dict[_Text, _Digest]


_ROBOT = re.compile(r"([A-Za-z][A-Za-z0-9_-]{0,39}/)?[A-Za-z][A-Za-z0-9_-]{0,39}")
"""The name of a robot model in the catalogue."""


@cache
def _options() -> Mapping[str, TypeAdapter[Any]]:
    """What validates each option of an environment, by name."""
    return {name: TypeAdapter(hint) for name, hint in get_type_hints(EnvOptions).items()}


def check_about(about: Mapping[str, Any], name: str) -> None:
    """Check what a data set says of itself.

    Args:
        about: Contents of ``dataset.json``.
        name: Path of the file, for the message.

    Raises:
        StoreError: A key is missing, or its value is not what it should be.
    """
    _check(_About, about, name)
    _check_options(about["options"], name)
    cameras = set(about["collected"]["cameras"])
    for task, task_about in about["tasks"].items():
        carried = task_about.get("carried")
        if carried and f"{task}.yaml" != carried["file"].rpartition("/")[2]:
            raise StoreError(f"{name} is damaged: the file of {task} is {carried['file']}")
        if set(task_about["cameras"]) != cameras:
            raise StoreError(f"{name} is damaged: {task} has other cameras than were recorded")
        for agent, robot in task_about["robots"].items():
            sizes = {len(robot[key]) for key in ("action_names", "action_low", "action_high")}
            if len(sizes) > 1:
                raise StoreError(f"{name} is damaged: {agent} has fewer bounds than actions")
    if cameras and about["renderer"] is None:
        raise StoreError(f"{name} is damaged: it has cameras, but no renderer")


def _check_options(options: Mapping[str, Any], name: str) -> None:
    for option, value in options.items():
        if option not in _options():
            raise StoreError(f"{name} has the option {option}, which this version does not know")
        try:
            _options()[option].validate_json(json.dumps(value), strict=True)
        except ValidationError as error:
            raise StoreError(f"{name} is damaged: options.{option}: {_words(error)}") from None
    for robot, model in dict(options.get("robots", {})).items():
        if not _ROBOT.fullmatch(str(model)):  # a path of the machine that reads it
            raise StoreError(f"{name} is damaged: options.robots.{robot} is no name of a robot")


def check_index(index: Mapping[str, Any], about: Mapping[str, Any], name: str) -> None:
    """Check the index of a data set.

    Raises:
        StoreError: It is damaged, or lists episodes of tasks that the data set does not have.
    """
    _check(_Index, index, name)
    lines = index["episodes"]
    for line in (*lines, *index["not_kept"]):
        if line["task"] not in about["tasks"]:
            raise StoreError(f"{name} is damaged: {line['name']} is of {line['task']}")
    for task in about["tasks"].keys() - {line["task"] for line in lines}:
        raise StoreError(f"{name} is damaged: it lists no episode of {task}")
    if len({line["name"] for line in lines}) < len(lines):
        raise StoreError(f"{name} is damaged: an episode is listed twice")


def check_manifest(manifest: Mapping[str, Any], name: str) -> None:
    """Check that a manifest lists digests.

    Raises:
        StoreError: It is damaged.
    """
    _check(_Manifest, manifest, name)


def check_episode(
    episode: Mapping[str, Any], line: Mapping[str, Any], task: Mapping[str, Any], name: str
) -> None:
    """Check what an episode says of itself.

    Args:
        episode: Contents of ``episode.json``.
        line: The line of the index about it.
        task: What the data set says of its task.
        name: Path of the file, for the message.

    Raises:
        StoreError: It is damaged, or says other than the index or the data set.
    """
    _check(_Episode, episode, name)
    for key, value in line.items():
        if episode.get(key) != value:
            raise StoreError(f"{name} is damaged: {key} is not that of the index")
    for wrong in _contradictions(episode, task):
        raise StoreError(f"{name} is damaged: {wrong}")


def _contradictions(episode: Mapping[str, Any], task: Mapping[str, Any]) -> list[str]:
    """In what an episode contradicts what the data set says of its task."""
    wrong = []
    if episode["steps"] > task["max_episode_steps"]:
        wrong.append(f"{episode['steps']} steps, and episodes have {task['max_episode_steps']}")
    if episode["control_hz"] != task["control_hz"]:
        wrong.append(f"control_hz is {episode['control_hz']}, and {task['control_hz']} of the task")
    if any(part["label"] not in (*task["expert"], DONE) for part in episode["subtasks"]):
        wrong.append("a sub-task is no stage of the expert")
    if list(episode["cameras"]) != list(task["cameras"]):
        wrong.append("it has other cameras than were recorded")
        return wrong
    for name, video in episode["cameras"].items():
        camera = task["cameras"][name]
        size = camera["width"], camera["height"], task["control_hz"], episode["steps"] + 1
        if (video["width"], video["height"], video["fps"], video["frames"]) != size:
            width, height, fps, frames = size
            wrong.append(f"{name} is not {width}x{height} pixels, {frames} frames at {fps} Hz")
        if any(video.get(kind) not in (None, *episode["files"]) for kind in ("video", "depth")):
            wrong.append(f"a video of {name} is no file of it")
    return wrong


def _check(kind: type[_Record], data: Mapping[str, Any], name: str) -> None:
    try:
        kind.model_validate(data)
    except ValidationError as error:
        raise StoreError(f"{name} is damaged: {_words(error)}") from None


def _words(error: ValidationError) -> str:
    """The first mistake, with the keys that lead to it."""
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    place = ".".join(str(part) for part in first["loc"] if part != "[key]")
    return f"{place}: {first['msg']}" if place else first["msg"]
