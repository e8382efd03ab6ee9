"""The options that every view of an environment takes.

A field of `Options` says all that is to be known of an option: its type, its default, what it means
to users, and what it means to the rest of the library (`OptionInfo`). The command line, the table
of the documentation, training plans, data sets, policies and the grouping of runs go through the
fields. So a new option is a new field, and the same field in `EnvOptions` for type checkers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field, dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack, cast

from taskbuilder.arguments import as_whole
from taskbuilder.env.option_info import OptionInfo, OptionKind, about, check_choice, check_value
from taskbuilder.errors import UsageError
from taskbuilder.extensions import RENDERERS
from taskbuilder.schema.choices import GraspChoice, OtherRobots
from taskbuilder.schema.disturbances import AXES, Disturbances, DisturbancesGiven, disturbances

if TYPE_CHECKING:  # models of files, which the command line does without until a command runs
    from taskbuilder.schema.load import TaskFile
    from taskbuilder.task import Task

RewardSharing = Literal["team", "local", "sparse"]
Variation = int | Literal["random"]
Renderer = Literal["auto", "raster", "tiny", "egl"]
RenderMode = Literal["rgb_array"]
ObservedPart = Literal["task", "scene"]
Frame = Literal["task", "base"]
Randomize = bool | Literal["looks", "all"]
Rotation = Literal["quaternion", "matrix"]
Distances = Literal["metres", "log"]

FORMER = {
    "end_on_setback": "EndOnSetback",
    "patience": "NoProgressTimeout",
    "openings": "StartPrefixes",
    "opening_share": "StartPrefixes",
}
"""Former options, and the training wrapper that replaces each."""


@dataclass(frozen=True)
class Options:
    """The options of an environment, which the table on the page *Environments* explains.

    In Python, `option_infos` says what each option means.
    """

    reward: RewardSharing = field(
        default="team",
        metadata=about(
            "who gets which reward",
            "reward",
            {
                "team": "every agent gets the sum of all reward terms",
                "local": "every agent gets its own terms and an equal share of the common terms; "
                "the local rewards add up to the team reward exactly",
                "sparse": "every agent gets 1 at each control step at which the success condition "
                "is true, and otherwise 0",
            },
        ),
    )
    flat: bool = field(
        default=True,
        metadata=about(
            "whether observations (apart from images) and actions are flat float32 arrays, instead "
            "of dictionaries: of channels, and with the keys arm and gripper",
            "arrays",
        ),
    )
    normalize: bool = field(
        default=True,
        metadata=about(
            "whether every number of an action is from -1 to 1, instead of in physical units",
            "arrays",
            decides_course=True,
        ),
    )
    horizon: int | None = field(
        default=None,
        metadata=about(
            "length of an episode in control steps",
            "scene",
            unless_given="as in the task file",
            bounds=(1, 1_000_000),
            decides_course=True,
            decides_policy=True,
        ),
    )
    control_hz: int | None = field(
        default=None,
        metadata=about(
            "control steps per second, a divisor of the physics rate; an action's maximum step and "
            "turn are scaled, so that the maximum speeds of tools and joints stay the same",
            "scene",
            unless_given="as in the task file",
            bounds=(1, 10_000),
            decides_course=True,
            decides_policy=True,
        ),
    )
    variation: Variation = field(
        default=0,
        metadata=about(
            "number of the variation, where 0 is the task as written; or random, which draws a "
            "variation for each episode",
            "scene",
            decides_course=True,
            decides_policy=True,
        ),
    )
    randomize: Randomize = field(
        default=False,
        metadata=about(
            "what is drawn at random in every episode, besides the initial states",
            "scene",
            {
                True: "what the task lists under randomize and looks",
                "looks": "all parts of the appearance, such as light and textures",
                "all": "what the task lists under randomize, and all parts of the appearance",
            },
            unless_given="nothing",
            true_word="quantities",
            decides_course=True,
            disturbs=True,
        ),
    )
    position_noise: float = field(
        default=0.0,
        metadata=about(
            "standard deviation, in metres, of Gaussian noise on each coordinate of every observed "
            "position, in addition to the noise in the task file; the state has none",
            "observed",
            bounds=(0.0, 1.0),
            unit="metres",
            decides_policy=True,
            disturbs=True,
        ),
    )
    observe: ObservedPart = field(
        default="task",
        metadata=about(
            "what robots observe",
            "observed",
            {
                "task": "the channels that the task file lists for each",
                "scene": "the whole scene: tools and grippers of all robots, movable objects and "
                "their grasp points, fixed objects that are placed at random, joints of objects, "
                "sites, and the time left",
            },
            decides_policy=True,
        ),
    )
    frame: Frame = field(
        default="task",
        metadata=about(
            "frame of observed poses and commanded motions",
            "observed",
            {
                "task": "the frames in the task file",
                "base": "the base frame of each robot, in place of the world's; robots that face "
                "each other can then share a policy",
            },
            decides_course=True,
            decides_policy=True,
        ),
    )
    rotation: Rotation = field(
        default="quaternion",
        metadata=about(
            "format of orientations",
            "observed",
            {
                "quaternion": "x, y, z, w, which jumps where its sign flips",
                "matrix": "the first two columns of the rotation matrix, which never jump",
            },
            decides_policy=True,
        ),
    )
    distances: Distances = field(
        default="metres",
        metadata=about(
            "format of positions in the frame of a tool",
            "observed",
            {
                "metres": "as they are",
                "log": "asinh(x / 2 cm) / 2, which is finer near the tool",
            },
            decides_policy=True,
        ),
    )
    cameras: tuple[str, ...] = field(
        default=(),
        metadata=about(
            "cameras whose colour images every agent observes in addition to its channels",
            "pictures",
            unless_given="none",
            decides_policy=True,
        ),
    )
    camera_size: tuple[int, int] | None = field(
        default=None,
        metadata=about(
            "width and height of observed images in pixels",
            "pictures",
            unless_given="the size of each camera",
            bounds=(1, 4096),
            unit="pixels",
            numbers=2,
            decides_policy=True,
        ),
    )
    renderer: Renderer = field(
        default="auto",
        metadata=about(
            "renderer of images",
            "pictures",
            {
                "auto": "raster if it is installed, otherwise tiny",
                "raster": "fast rasteriser on the CPU",
                "tiny": "PyBullet's TinyRenderer",
                "egl": "OpenGL",
            },
            others=RENDERERS,
            decides_policy=True,
        ),
    )
    render_camera: str | None = field(
        default=None,
        metadata=about(
            "the camera of render()", "view", unless_given="the first camera of the scene"
        ),
    )
    robots: OtherRobots = field(
        default=(),
        metadata=about(
            "models that replace those of robots, such as left=panda; a model is the name of a "
            "robot, or the path of a robot file",
            "scene",
            unless_given="as in the task file",
            flag="robot",
            decides_course=True,
            decides_policy=True,
        ),
    )
    grasp: GraspChoice = field(
        default="task",
        metadata=about(
            "how grippers with fingers hold objects",
            "scene",
            {
                "task": "as the task file says, which is by friction if it says nothing",
                "friction": "by the friction of their fingers",
                "attach": "a closing gripper fixes the nearest object to itself, and lets go of it "
                "when it opens",
            },
            decides_course=True,
            decides_policy=True,
        ),
    )

    disturbances: Disturbances = field(
        default=(),
        metadata=about(
            "what every episode has otherwise than the task file says, all at once: axes, each "
            f"with a level or at that by default, such as mass=0.5; {', '.join(AXES)}",
            "scene",
            unless_given="none",
            flag="disturb",
            decides_course=True,
            disturbs=True,
        ),
    )

    @property
    def draws_quantities(self) -> bool:
        """Whether what the task lists under ``randomize`` is drawn in each episode."""
        return self.randomize in (True, "all")

    @property
    def disturbance_levels(self) -> dict[str, float]:
        """The level of each axis that is disturbed."""
        return dict(self.disturbances)

    @property
    def decisive(self) -> dict[str, Any]:
        """The options on which the course of an episode depends, for given actions and seed."""
        return {
            name: getattr(self, name)
            for name, info in option_infos().items()
            if info.decides_course
        }

    @property
    def chosen(self) -> EnvOptions:
        """The options that differ from their defaults."""
        chosen = {
            each.name: value
            for each in fields(self)
            if (value := getattr(self, each.name)) != each.default
        }
        return cast("EnvOptions", chosen)

    def applied(self, task: Task) -> TaskFile:
        """The task file with the timing, robots, grasping and layout of these options.

        Raises:
            UsageError: An option does not fit the task.
            UnknownNameError: There is no robot of a name in ``robots``.
            FileError: The files of such a robot have errors.
        """
        from taskbuilder.env.disturbing import with_disturbances
        from taskbuilder.env.timing import with_timing
        from taskbuilder.schema.grasping import with_grasp
        from taskbuilder.schema.other_robots import with_robots

        self._check(task)
        file = with_grasp(with_robots(task.file, self.robots, task.file.catalogue), self.grasp)
        file = with_timing(file, self.horizon, self.control_hz)
        return with_disturbances(file, self.disturbances, self.renderer)

    def check(self) -> None:
        """Check what can be checked without a task.

        Raises:
            UsageError: A value is none of the choices, or out of bounds.
        """
        for name, each in option_fields().items():
            check_value(name, getattr(self, name), each.metadata["info"], each.default)

    def _check(self, task: Task) -> None:
        self.check()
        count = len(task.file.scenes)
        if self.variation != "random" and as_whole(self.variation) not in range(count):
            raise UsageError(
                f'variation is {self.variation!r}; {task.name} has 0 to {count - 1}, or "random"'
            )
        rendered = (self.render_camera,) if self.render_camera else ()
        for camera in (*self.cameras, *rendered):
            check_choice("camera", camera, tuple(task.file.spec.scene.cameras))


def option_fields() -> dict[str, Field[Any]]:
    """The fields of `Options`, by name."""
    return {each.name: each for each in fields(Options)}


def option_infos() -> dict[str, OptionInfo]:
    """What every option means, by name."""
    return {name: each.metadata["info"] for name, each in option_fields().items()}


def flag_of(name: str) -> str:
    """What an option is called on the command line."""
    return f"--{(option_infos()[name].flag or name).replace('_', '-')}"


def options_about(*kinds: OptionKind) -> tuple[str, ...]:
    """The names of the options of some kinds."""
    return tuple(name for name, info in option_infos().items() if info.kind in kinds)


class _PlayedOptions(TypedDict, total=False):
    """The options about what is played, in any variation, and what agents observe of it."""

    horizon: int | None
    control_hz: int | None
    randomize: Randomize
    position_noise: float
    observe: ObservedPart
    frame: Frame
    rotation: Rotation
    distances: Distances
    robots: Mapping[str, str | Path] | OtherRobots
    grasp: GraspChoice


class ValidationOptions(_PlayedOptions, total=False):
    """The options of environments that a validation chooses, for type checkers."""

    reward: RewardSharing


class TrainingOptions(_PlayedOptions, total=False):
    """The options of environments that a training run chooses, for type checkers."""

    variation: Variation
    cameras: tuple[str, ...]
    camera_size: tuple[int, int] | None
    renderer: Renderer
    disturbances: DisturbancesGiven


class EnvOptions(TrainingOptions, total=False):
    """The fields of `Options` as keyword arguments, for type checkers."""

    reward: RewardSharing
    flat: bool
    normalize: bool
    render_camera: str | None


def make_options(**options: Unpack[EnvOptions]) -> Options:
    """Make options from keyword arguments.

    Raises:
        UsageError: There is no such option, or it is now a training wrapper.
    """
    from taskbuilder.schema.other_robots import other_robots

    moved = next((name for name in options if name in FORMER), None)
    if moved is not None:
        wrapper = f"taskbuilder.learn.wrappers.{FORMER[moved]}"
        raise UsageError(f"{moved} is no option of environments any more; wrap one in {wrapper}")
    names = tuple(option_fields())
    for name in options:
        check_choice("option", name, names)
    chosen: dict[str, Any] = {
        **from_json(options),
        "robots": other_robots(options.get("robots", ())),
        "disturbances": disturbances(options.get("disturbances", ())),
    }
    return Options(**chosen)


def from_json(options: Mapping[str, Any]) -> Any:
    """Options that were read from JSON, whose tuples are lists."""
    return {name: _tuples(value) for name, value in options.items()}


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value
