"""The state of the scene, and the motions and grips that change it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from taskbuilder.expert.planning.planner import Move
from taskbuilder.expert.script.joints import Joint
from taskbuilder.geometry import Pose, Vec3
from taskbuilder.schema.bodies import Grasp
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.world.world import World

TOOL_TOLERANCE_M = 0.01
LOAD_TOLERANCE_M = 0.02

DOWN: Vec3 = (0.0, 0.0, -1.0)


class Situation(Protocol):
    """The state of the scene, in the simulation or in a dry run."""

    @property
    def world(self) -> World:
        """The world, for its shapes and joints; where things are may differ from it."""

    @property
    def scene(self) -> SceneSpec:
        """The scene that was built."""

    def pose(self, frame: str) -> Pose:
        """A named frame in the world."""

    def tool(self, robot: str) -> Pose:
        """The commanded pose of a robot's tcp, in the world."""

    def load(self, robot: str) -> str | None:
        """The object that a robot holds."""

    def handle(self, robot: str) -> str | None:
        """The link of an articulated object that a robot holds, such as ``chest.lid``."""

    def joint(self, name: str) -> float:
        """Position of an articulated object's joint, in rad or m."""

    def is_open(self, robot: str) -> bool:
        """Whether a robot's gripper is open."""


@dataclass(frozen=True)
class Foreseen:
    """A predicted situation, as differences from the current one.

    Attributes:
        now: The current situation.
        moved: World poses of objects, and of links such as ``chest.lid``, that differ.
        tools: World poses of tools that differ.
        loads: Held objects, or None, of robots for which they differ.
        handles: Held links of articulated objects, or None, of robots for which they differ.
        joints: Positions of joints that differ, in rad or m.
    """

    now: Situation
    moved: Mapping[str, Pose] = field(default_factory=dict)
    tools: Mapping[str, Pose] = field(default_factory=dict)
    loads: Mapping[str, str | None] = field(default_factory=dict)
    handles: Mapping[str, str | None] = field(default_factory=dict)
    joints: Mapping[str, float] = field(default_factory=dict)

    @property
    def world(self) -> World:
        """The world, for its shapes and joints."""
        return self.now.world

    @property
    def scene(self) -> SceneSpec:
        """The scene that was built."""
        return self.now.scene

    def pose(self, frame: str) -> Pose:
        """The predicted pose of a named frame, in the world."""
        carrier = carrier_of(self.scene, frame)
        owner, _, inner = carrier.partition(".")
        at = self.now.pose(frame)
        for mover in (carrier, owner):
            if mover in self.moved:
                return self.moved[mover] @ self.now.pose(mover).inverse() @ at
        if owner in self.tools and inner == "tcp":
            return self.tools[owner] @ self.now.pose(carrier).inverse() @ at
        return at

    def tool(self, robot: str) -> Pose:
        """The predicted commanded pose of a robot's tcp, in the world."""
        return self.tools[robot] if robot in self.tools else self.now.tool(robot)

    def load(self, robot: str) -> str | None:
        """The object that a robot will hold."""
        return self.loads[robot] if robot in self.loads else self.now.load(robot)

    def handle(self, robot: str) -> str | None:
        """The link of an articulated object that a robot will hold."""
        return self.handles[robot] if robot in self.handles else self.now.handle(robot)

    def joint(self, name: str) -> float:
        """The predicted position of a joint, in rad or m."""
        return self.joints[name] if name in self.joints else self.now.joint(name)

    def is_open(self, robot: str) -> bool:
        """Whether a robot's gripper is open now."""
        return self.now.is_open(robot)


class NotHeldError(Exception):
    """A robot does not hold what its order takes."""

    def __init__(self, robot: str, message: str) -> None:
        super().__init__(f"{robot} {message}")
        self.robot = robot


@dataclass(frozen=True)
class Go:
    """A motion.

    Attributes:
        choices: Equivalent moves, the nearest first.
        brings: The object that has to arrive, or "" for the tool itself.
        tolerance: Tolerance of the end position, in metres, or in rad for a joint that turns;
            None to continue without waiting.
        joint: A joint that is moved to a position (rad or m), or None.
        pushes: An object that is pushed to a pose in the world, or None.
        holds: The link that must stay in the gripper, or "".
        gap: Remaining distance in metres, or in rad for a joint that turns, if it is not that of
            the tool or the load.
        until: The condition of the description that ends it, or "".
    """

    choices: tuple[Move, ...]
    brings: str = ""
    tolerance: float | None = None
    joint: tuple[str, float] | None = None
    pushes: tuple[str, Pose] | None = None
    holds: str = ""
    gap: Callable[[Situation], float] | None = None
    until: str = ""

    def moved(self, now: Situation) -> dict[str, Pose]:
        """World poses of what it pushes or moves on a joint, when it is done."""
        if self.pushes is not None:
            return dict([self.pushes])
        if self.joint is None:
            return {}
        name, position = self.joint
        joint = Joint(now.world, name)
        shift = joint.shift(now.pose(joint.child), position - now.joint(name))
        return {link: shift @ now.pose(link) for link in joint.below}

    @property
    def subject(self) -> str:
        """The object or joint that has to arrive, or "" for the tool itself."""
        return self.brings or next((named[0] for named in (self.joint, self.pushes) if named), "")


@dataclass(frozen=True)
class Grip:
    """A gripper opens or closes.

    Attributes:
        robot: The robot.
        opening: From 0 (closed) to 1.
        load: The object to hold or to release; "" for none in particular.
        link: The link of the object that is held, if the task file names it; else "".
        inside: Whether the object is held from inside, by opening.
    """

    robot: str
    opening: float
    load: str = ""
    link: str = ""
    inside: bool = False

    @property
    def releases(self) -> bool:
        """Whether the gripper lets go of something, instead of taking hold."""
        return (self.opening > 0.0) != self.inside


Phase = Callable[[Situation], Go | Grip | None]
"""Computes the next motion or grip; None if it is already done."""


def place_of(now: Situation, place: str | Vec3) -> Pose:
    """Pose in the world of a named frame, or of a point with the axes of the world."""
    return now.pose(place) if isinstance(place, str) else Pose(place)


def carrier_of(scene: SceneSpec, frame: str) -> str:
    """What a frame moves with: an object, a link as ``chest.lid``, or a frame of a robot."""
    while frame in scene.sites:
        frame = scene.sites[frame].frame
    grasp = grasp_of(scene, frame)
    if grasp is None:
        return frame
    owner = frame.partition(".")[0]
    return owner if grasp.link is None else f"{owner}.{grasp.link}"


def grasp_of(scene: SceneSpec, frame: str) -> Grasp | None:
    """The grasp point of a name; None if it is another frame."""
    owner, _, name = frame.partition(".")
    obj = scene.objects.get(owner)
    return obj.grasps.get(name) if obj else None
