"""What a policy's file says of the policy, checked when it is read; it may come from anybody."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ConfigDict, Field, ValidationError

from taskbuilder.schema.robot import GraspRule
from taskbuilder.schema.values import Model
from taskbuilder.wording import excerpt

MOST_PIXELS = 512 * 512
"""Maximum size of a picture that a policy observes, in pixels; those of the library have 84x84."""


class TrainingEnv(Model):
    """The environment of training, as far as pictures are concerned; other options are free here.

    Attributes:
        cameras: Cameras whose pictures agents observe.
        camera_size: Width and height of the pictures.
    """

    model_config = ConfigDict(extra="allow")

    cameras: list[str] = Field(default_factory=list)
    camera_size: tuple[int, int] | list[int] | None = None


class PolicyAbout(Model):
    """How a policy was trained. Policies of other programs and of earlier versions say less.

    Its task is looked up by `taskbuilder.evaluation`, which says what is wrong with its name.
    """

    model_config = ConfigDict(extra="allow")

    task_version: int = 1
    algorithm: str | None = None
    reward: str | None = None
    track: str | None = None
    command: str | None = None
    data: str | None = None
    seed: int | None = None
    step: int | None = None
    starts: float | None = None
    teachers: list[str] = Field(default_factory=list)
    stages: list[str] = Field(default_factory=list)
    encoders: list[str] = Field(default_factory=list)
    squash: bool = False
    norms: bool = False
    grasp_rules: dict[str, GraspRule] = Field(default_factory=dict)
    env: TrainingEnv | None = None


def problem_of(about: Mapping[str, Any]) -> str | None:
    """What is wrong with what a policy's file says, or None."""
    try:
        record = PolicyAbout.model_validate(dict(about))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        return f"{where} is not as in policies: {first['msg']}"
    env = record.env or TrainingEnv()
    if sorted(env.cameras) != sorted(record.encoders):
        seen, read = (", ".join(names) or "none" for names in (env.cameras, record.encoders))
        return f"it observes the cameras {excerpt(seen)}, and has networks for {excerpt(read)}"
    if env.cameras:
        width, height = env.camera_size or (0, 0)
        if not 0 < width * height <= MOST_PIXELS:
            return f"it observes pictures of {width}x{height}; at most 512x512 are played"
    return None
