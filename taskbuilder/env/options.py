"""The options that every view of an environment takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Literal, TypedDict, Unpack, get_args

from taskbuilder.errors import UsageError
from taskbuilder.extensions import RENDERERS
from taskbuilder.schema.agents import RobotEntry
from taskbuilder.schema.grasping import GraspChoice, with_grasp
from taskbuilder.schema.load import TaskFile
from taskbuilder.schema.other_robots import OtherRobots, other_robots, with_robots
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.values import frozen
from taskbuilder.task import Task
from taskbuilder.wording import suggestion

RewardSharing = Literal["team", "local", "sparse"]
Variation = int | Literal["random"]
Renderer = Literal["auto", "raster", "tiny", "egl"]
RenderMode = Literal["rgb_array"]
Seen = Literal["task", "scene"]
Frame = Literal["task", "base"]
Randomize = bool | Literal["looks", "all"]
Rotation = Literal["quaternion", "matrix"]
Distances = Literal["metres", "log"]


_FOR_TRAINING = {
    "end_on_setback": "EndOnSetback",
    "patience": "NoProgressTimeout",
    "openings": "StartPrefixes",
    "opening_share": "StartPrefixes",
}
"""Former options, and the training wrapper that replaces each."""

_DECISIVE = (
    *("normalize", "horizon", "control_hz", "variation", "randomize", "frame", "robots", "grasp"),
)


@dataclass(frozen=True)
class Options:
    """The options of an environment.

    Attributes:
        reward: ``team`` gives every agent the sum of all reward terms. ``local`` gives every agent
            its own terms and an equal share of the common terms; the local rewards add up to the
            team reward exactly. ``sparse`` gives every agent 1 at each control step at which the
            success condition is true, and otherwise 0.
        flat: Whether observations (apart from images) and actions are flat float32 arrays, instead
            of dictionaries.
        normalize: Whether actions are scaled to the range from -1 to 1, instead of being in
            physical units.
        horizon: Length of an episode in control steps; by default as in the task file.
        control_hz: Control steps per second; by default as in the task file. With a different rate,
            an action's maximum step and turn are scaled so that the maximum speeds of tools and
            joints stay the same.
        variation: Number of the variation, where 0 is the task as written; or ``random``, which
            draws a variation for each episode.
        randomize: Which quantities and which parts of the scene's appearance are drawn at random
            for each episode. False: none. True: the quantities that the task file lists under
            ``randomize``, and the parts of the appearance that it lists under ``looks``. ``looks``:
            all parts of the appearance, but no quantities. ``all``: the quantities under
            ``randomize``, and all parts of the appearance.
        position_noise: Standard deviation in metres of Gaussian noise on every coordinate of every
            observed position, in addition to the noise in the task file; ``state`` has no noise.
        observe: ``task``: every agent observes the channels that the task file lists for it.
            ``scene``: every agent observes the tools and grippers of all robots, all movable
            objects with their grasp points, all fixed objects that are placed at random, all
            joints of objects, all sites and the time left.
        frame: ``task``: observed poses and commanded motions are in the frames that the task file
            gives. ``base``: poses and motions that would otherwise be in the world's frame are in
            each robot's own base frame. Robots that face each other can then share a policy.
        rotation: Format of orientations. ``quaternion``: (x, y, z, w), which jumps where its sign
            flips. ``matrix``: the first two columns of the rotation matrix, which never jump.
        distances: Format of observed positions in the frame of a tool. ``metres``, or ``log``:
            asinh(x / 2 cm) / 2, which is linear near the tool and logarithmic far from it, so that
            small networks tell millimetres apart near the tool.
        cameras: Cameras whose colour images every agent observes in addition to its channels.
        camera_size: Width and height of observed images in pixels; by default, those of each
            camera.
        renderer: Renderer of images: ``raster``, ``tiny``, ``egl`` or ``auto``. ``auto`` stands for
            ``raster`` if the packages for it are installed, and otherwise for ``tiny``.
        render_camera: The camera of ``render()``; by default the first camera of the scene.
        robots: Models that replace those of the task file, by robot: ``{"left": "panda"}``. A model
            is a name in the catalogue, or the path of a robot file. Stored as a tuple of pairs.
        grasp: How grippers with fingers hold objects. ``task``: as the task file says, which is
            ``friction`` if it says nothing. ``friction``: by the friction of their fingers.
            ``attach``: a gripper that closes fixes the nearest object to itself, up to 4 cm from
            its tool centre point unless the robot has another distance, and lets go of it when it
            opens.
    """

    reward: RewardSharing = "team"
    flat: bool = True
    normalize: bool = True
    horizon: int | None = None
    control_hz: int | None = None
    variation: Variation = 0
    randomize: Randomize = False
    position_noise: float = 0.0
    observe: Seen = "task"
    frame: Frame = "task"
    rotation: Rotation = "quaternion"
    distances: Distances = "metres"
    cameras: tuple[str, ...] = ()
    camera_size: tuple[int, int] | None = None
    renderer: Renderer = "auto"
    render_camera: str | None = None
    robots: OtherRobots = ()
    grasp: GraspChoice = "task"

    @property
    def draws_quantities(self) -> bool:
        """Whether what the task lists under ``randomize`` is drawn in each episode."""
        return self.randomize in (True, "all")

    @property
    def decisive(self) -> dict[str, Any]:
        """The options on which the course of an episode depends, for given actions and seed."""
        return {name: getattr(self, name) for name in _DECISIVE}

    def applied(self, task: Task) -> TaskFile:
        """The task file with the horizon, control rate, robots and grasping of these options.

        Raises:
            UsageError: An option does not fit the task.
            UnknownNameError: There is no robot of a name in ``robots``.
            FileError: The files of such a robot have errors.
        """
        self._check(task)
        file = with_grasp(with_robots(task.file, self.robots, task.file.catalogue), self.grasp)
        timing = file.spec.timing
        changes = {"episode_steps": self.horizon, "control_hz": self.control_hz}
        wanted = {key: value for key, value in changes.items() if value is not None}
        changed = timing.model_copy(update=wanted)
        if changed.physics_hz % changed.control_hz:
            rates = [hz for hz in range(1, changed.physics_hz + 1) if changed.physics_hz % hz == 0]
            near = min(rates, key=lambda hz: abs(hz - changed.control_hz))
            raise UsageError(
                f"control_hz {changed.control_hz} does not divide physics_hz "
                f"{changed.physics_hz} of {task.name}; {near} does"
            )
        share = timing.control_hz / changed.control_hz
        scenes = tuple(_paced(scene, share) for scene in file.scenes)
        update = {"timing": changed, "scene": scenes[0]}
        return replace(file, spec=file.spec.model_copy(update=update), scenes=scenes)

    def _check(self, task: Task) -> None:
        _choice("reward", self.reward, get_args(RewardSharing))
        for name, value in (("horizon", self.horizon), ("control_hz", self.control_hz)):
            if value is not None and (not isinstance(value, int) or value < 1):
                raise UsageError(f"{name} is {value!r}; a whole number of at least 1")
        count = len(task.file.scenes)
        if self.variation != "random" and self.variation not in range(count):
            raise UsageError(
                f'variation is {self.variation!r}; {task.name} has 0 to {count - 1}, or "random"'
            )
        if not isinstance(self.randomize, bool):
            _choice("randomize", self.randomize, ("looks", "all"))
        if not 0.0 <= self.position_noise <= 1.0:
            raise UsageError(f"position_noise is {self.position_noise!r}; 0 to 1, in metres")
        _choice("observe", self.observe, ("task", "scene"))
        _choice("frame", self.frame, ("task", "base"))
        _choice("rotation", self.rotation, get_args(Rotation))
        _choice("distances", self.distances, get_args(Distances))
        _choice("renderer", self.renderer, RENDERERS.names(get_args(Renderer)))
        size = self.camera_size
        if size is not None and not all(isinstance(n, int) and 0 < n <= 4096 for n in size):
            raise UsageError(f"camera_size is {size!r}; a width and a height of 1 to 4096 pixels")
        shown = (self.render_camera,) if self.render_camera else ()
        for camera in (*self.cameras, *shown):
            _choice("camera", camera, tuple(task.file.spec.scene.cameras))


def _paced(scene: SceneSpec, share: float) -> SceneSpec:
    """Scale the action limits of a scene to another control rate, so that speeds stay the same.

    Args:
        scene: The scene of the task file.
        share: Duration of a control step, as a fraction of the task file's.
    """
    if share == 1.0:
        return scene

    def paced(robot: RobotEntry) -> RobotEntry:
        spec = robot.action
        limits = {"max_step": spec.max_step * share, "max_turn_deg": spec.max_turn_deg * share}
        return robot.model_copy(update={"action": spec.model_copy(update=limits)})

    robots = {name: paced(robot) for name, robot in scene.robots.items()}
    return scene.model_copy(update={"robots": frozen(robots)})


class EnvOptions(TypedDict, total=False):
    """The fields of `Options` as keyword arguments, for type checkers."""

    reward: RewardSharing
    flat: bool
    normalize: bool
    horizon: int | None
    control_hz: int | None
    variation: Variation
    randomize: Randomize
    position_noise: float
    observe: Seen
    frame: Frame
    rotation: Rotation
    distances: Distances
    cameras: tuple[str, ...]
    camera_size: tuple[int, int] | None
    renderer: Renderer
    render_camera: str | None
    robots: Mapping[str, str | Path] | OtherRobots
    grasp: GraspChoice


def make_options(**options: Unpack[EnvOptions]) -> Options:
    """Make options from keyword arguments.

    Raises:
        UsageError: There is no such option, or it is now a training wrapper.
    """
    moved = next((name for name in options if name in _FOR_TRAINING), None)
    if moved is not None:
        wrapper = f"taskbuilder.learn.wrappers.{_FOR_TRAINING[moved]}"
        raise UsageError(f"{moved} is no option of environments any more; wrap one in {wrapper}")
    known = [field.name for field in fields(Options)]
    for name in options:
        _choice("option", name, known)
    chosen: dict[str, Any] = {**options, "robots": other_robots(options.get("robots", ()))}
    return Options(**chosen)


def _choice(name: str, value: str, choices: Sequence[str]) -> None:
    if value not in choices:
        raise UsageError(f'{name} "{value}": {suggestion(str(value), choices, what="one of")}')
