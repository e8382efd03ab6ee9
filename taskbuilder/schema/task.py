"""The task file: a scene, its timing, what agents observe, and how experts do it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.schema.expert import ExpertStage
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.values import (
    Extent,
    Model,
    Name,
    Reference,
    RobotName,
    Shorthand,
    Text,
    frozen,
)

LookPart = Literal["light", "background", "furniture", "textures", "distractors", "cameras"]

LOOK_PARTS: tuple[LookPart, ...] = get_args(LookPart)
"""Of what a scene looks like, what can be drawn at random."""


class Timing(Model):
    """Rates and length of an episode."""

    control_hz: Annotated[int, Field(ge=1, le=1000)] = Field(
        10, description="Control steps (actions) per second."
    )
    physics_hz: Annotated[int, Field(ge=20, le=10_000)] = Field(
        120, description="Physics steps per second; must be a multiple of control_hz."
    )
    episode_steps: Annotated[int, Field(ge=1, le=100_000)] = Field(
        50, description="Length of an episode in control steps."
    )
    ends_on: tuple[Literal["success", "failure"], ...] = Field(
        (), description="Conditions that end an episode early."
    )

    @property
    def substeps(self) -> int:
        """Physics steps in a control step."""
        return self.physics_hz // self.control_hz

    @model_validator(mode="after")
    def _whole_substeps(self) -> Timing:
        if self.physics_hz % self.control_hz:
            nearest = max(1, round(self.physics_hz / self.control_hz)) * self.control_hz
            raise PydanticCustomError(
                "timing",
                "physics_hz {physics} is no multiple of control_hz {control}; {nearest} is",
                {"physics": self.physics_hz, "control": self.control_hz, "nearest": nearest},
            )
        return self


class Noise(Model):
    """Gaussian noise on an observation channel."""

    std: Extent | None = Field(
        None,
        description="Standard deviation of the noise on every component of the channel that is "
        "not part of an orientation, in the unit of the channel.",
    )
    position_std: Extent | None = Field(
        None,
        description="Standard deviation of the noise on each coordinate of a position, in metres.",
    )
    angle_std_deg: Extent | None = Field(
        None,
        description="Standard deviation of the noise on an orientation, about each axis, in "
        "degrees.",
    )


class Distribution(Model):
    """What a randomised quantity is drawn from."""

    uniform: tuple[float, float] | None = Field(
        None, description="Minimum and maximum of a uniform distribution."
    )
    choice: Annotated[tuple[Any, ...], Field(min_length=1), AfterValidator(frozen)] | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Distribution:
        if (self.uniform is None) == (self.choice is None):
            raise PydanticCustomError("choice", "give exactly one of uniform, choice")
        if self.uniform is not None and self.uniform[0] > self.uniform[1]:
            raise PydanticCustomError("order", "uniform is [least, greatest]; swap them")
        return self


class TaskSpec(Model):
    """A task file."""

    task: Name = Field(description="Name of the task: the file name without .yaml.")
    version: Annotated[int, Field(ge=1, le=9999)] = Field(
        1,
        description="Number of the task's version, which the id of its environment ends with. A "
        "task whose scene, reward or success has changed has the next number.",
    )
    summary: Text = Field(description="One sentence: who does what.")
    instructions: tuple[Text, ...] = Field(
        (),
        description="Instructions for language-conditioned policies; placeholders such as "
        "{stick.color} are filled in.",
    )
    cooperation: Literal["required", "optional"] = Field(
        "required",
        description="For tasks with several robots. `required`: the task cannot be done unless "
        "all its robots take part, which `validate` checks. `optional`: some of its robots, or "
        "one robot alone, may be enough.",
    )
    timing: Timing = Timing()
    scene: SceneSpec = Field(description="The robots, objects, sites and cameras.")
    observe: Annotated[Mapping[RobotName, tuple[Reference, ...]], AfterValidator(frozen)] | None = (
        Field(
            None,
            description="Channels that each robot observes; by default its own joints, tool and "
            "gripper, all objects and sites, and the time left.",
        )
    )
    observation_noise: Annotated[
        Mapping[RobotName, Mapping[Reference, Noise]], AfterValidator(frozen)
    ] = Field(default_factory=lambda: frozen({}))
    state: Annotated[tuple[Reference, ...], Shorthand("all", ("all",))] = Field(
        ("all",),
        description="Channels that a centralised critic observes; `all` stands for the joints "
        "and tools of all robots, the poses and velocities of all movable objects, the joint "
        "positions of objects, the positions of all sites, the time left, and all else that a "
        "reset draws.",
    )
    expert: tuple[ExpertStage, ...] = ()
    variations: tuple[
        Annotated[Mapping[Reference, Any], Field(min_length=1), AfterValidator(frozen)], ...
    ] = Field(
        (),
        description="Variations of the task. Each one is a mapping of changed values, such as "
        "{stick.color: green}. Variation 0 is the task as written and is not listed.",
    )
    randomize: Annotated[Mapping[Reference, Distribution], AfterValidator(frozen)] = Field(
        default_factory=lambda: frozen({}),
        description="Quantities that are drawn at random in each episode, in environments with "
        "`randomize=True`.",
    )
    looks: Annotated[tuple[LookPart, ...], Shorthand("all", LOOK_PARTS)] = Field(
        (),
        description="Parts of the scene's appearance that environments with `randomize=True` "
        "randomise in each episode; `all` stands for all parts.",
    )
