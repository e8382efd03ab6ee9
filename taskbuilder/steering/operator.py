"""A person who steers a robot: from keys and a dragged tool to the next pose of the tool."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from taskbuilder.expert.planning.reach import between, part_of_turn
from taskbuilder.geometry import (
    Pose,
    Quat,
    Vec3,
    add,
    multiply,
    norm,
    rotate,
    scale,
    subtract,
    turn_between,
)
from taskbuilder.schema.agents import ActionSpec

STEP = 0.5
"""What a key moves in a control step, as a share of what the action mode allows."""

FINE_STEP = 0.1
"""The same for a key that is pressed with Shift."""

ARRIVED_M, ARRIVED_RAD = 1e-3, math.radians(0.5)
"""A tool that is as near as this to where it was dragged has arrived."""


@dataclass(frozen=True)
class Jog:
    """What a key does.

    Attributes:
        words: What it does, in words.
        shift: Direction in which the tool moves, as its person sees it: forwards, left and up.
        turn: Axis about which the tool turns, among its own.
        grips: Whether it opens or closes the gripper.
    """

    words: str
    shift: Vec3 = (0.0, 0.0, 0.0)
    turn: Vec3 = (0.0, 0.0, 0.0)
    grips: bool = False


GRIP = "G"

KEYS: Mapping[str, Jog] = {
    "I": Jog("forwards", (1.0, 0.0, 0.0)),
    "K": Jog("backwards", (-1.0, 0.0, 0.0)),
    "J": Jog("left", (0.0, 1.0, 0.0)),
    "L": Jog("right", (0.0, -1.0, 0.0)),
    "U": Jog("up", (0.0, 0.0, 1.0)),
    "O": Jog("down", (0.0, 0.0, -1.0)),
    "Z": Jog("turn left", turn=(0.0, 0.0, -1.0)),
    "X": Jog("turn right", turn=(0.0, 0.0, 1.0)),
    "C": Jog("tilt left", turn=(-1.0, 0.0, 0.0)),
    "V": Jog("tilt right", turn=(1.0, 0.0, 0.0)),
    "B": Jog("tilt forwards", turn=(0.0, -1.0, 0.0)),
    "N": Jog("tilt backwards", turn=(0.0, 1.0, 0.0)),
    GRIP: Jog("open or close the gripper", grips=True),
}
"""The keys, and what each does."""


_STICKS = "sticks"
"""Where what sticks do is kept among the keys."""


class _Press(NamedTuple):
    jog: Jog
    heading: float
    size: float


class ToolCommand(NamedTuple):
    """What a person commands for a control step.

    Attributes:
        tool: Where the tool goes, in the world.
        grips: Whether the gripper opens or closes.
    """

    tool: Pose
    grips: bool


class Operator:
    """A person who steers a robot.

    A key that was pressed counts in the next control step, once, however often it repeats. So a
    tap is one step, and a key that is held down moves the tool on and on.

    Args:
        name: Name of the person, as data sets have it.

    Attributes:
        name: The same.
        lags_s: From each first press or drag of a control step to its command, in seconds.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.lags_s: list[float] = []
        self._pressed: dict[str, _Press] = {}
        self._aim: Pose | None = None
        self._since: float | None = None

    def press(self, key: str, *, heading: float = 0.0, fine: bool = False) -> None:
        """A key was pressed, or repeats.

        Args:
            key: One of `KEYS`; others are ignored.
            heading: Direction in which the person looks, about the vertical from x, in rad.
            fine: Whether it moves by a small step.
        """
        if key in KEYS:
            self._pressed[key] = _Press(KEYS[key], heading, FINE_STEP if fine else STEP)
            self._note_time()

    def push(self, shift: Vec3, turn: Vec3, *, heading: float = 0.0) -> None:
        """Sticks point somewhere; this counts in the next control step, once.

        Args:
            shift: Where the tool moves, as its person sees it: forwards, left and up, each as a
                share, -1 to 1, of what the action mode allows in a control step.
            turn: How it turns about its own axes, each -1 to 1 in the same way.
            heading: Direction in which the person looks, about the vertical from x, in rad.
        """
        self._pressed[_STICKS] = _Press(Jog("sticks", shift, turn), heading, 1.0)
        self._note_time()

    def drag(self, tool: Pose) -> None:
        """The tool was dragged to a pose in the world, which it goes to until a key is pressed."""
        self._aim = tool
        self._note_time()

    def command(self, tool: Pose, spec: ActionSpec) -> ToolCommand:
        """What this person commands for the next control step; keys have been heard then.

        Args:
            tool: Where the tool was last commanded to be, in the world.
            spec: The action mode of the robot.
        """
        pressed, self._pressed = list(self._pressed.values()), {}
        if self._since is not None:
            self.lags_s.append(time.monotonic() - self._since)
            self._since = None
        grips = any(press.jog.grips for press in pressed)
        moves = [press for press in pressed if not press.jog.grips]
        if moves:
            self._aim = None
            return ToolCommand(_jogged(tool, moves, spec), grips)
        if self._aim is None:
            return ToolCommand(tool, grips)
        goal = _towards(tool, self._aim, spec)
        if _is_at(goal, self._aim):
            self._aim = None
        return ToolCommand(goal, grips)

    def _note_time(self) -> None:
        if self._since is None:
            self._since = time.monotonic()


def _jogged(tool: Pose, presses: list[_Press], spec: ActionSpec) -> Pose:
    shift: Vec3 = (0.0, 0.0, 0.0)
    turn: Vec3 = (0.0, 0.0, 0.0)
    for press in presses:
        shift = add(shift, scale(_seen_from(press.heading, press.jog.shift), press.size))
        turn = add(turn, scale(press.jog.turn, press.size))
    angle = math.radians(spec.max_turn_deg) * min(norm(turn), 1.0)
    step = scale(shift, spec.max_step / max(norm(shift), 1.0))
    return Pose(add(tool.position, step), multiply(tool.quaternion, _about(turn, angle)))


def _seen_from(heading: float, direction: Vec3) -> Vec3:
    """A direction in the world, given as a person sees it who looks along a heading."""
    return rotate(_about((0.0, 0.0, 1.0), heading), direction)


def _about(axis: Vec3, angle: float) -> Quat:
    length = norm(axis)
    if length < 1e-9:
        return (0.0, 0.0, 0.0, 1.0)
    x, y, z = scale(axis, math.sin(angle / 2.0) / length)
    return (x, y, z, math.cos(angle / 2.0))


def _towards(tool: Pose, aim: Pose, spec: ActionSpec) -> Pose:
    """The pose on the way to another that the action mode allows for a control step."""
    distance = norm(subtract(aim.position, tool.position))
    turn = turn_between(tool.quaternion, aim.quaternion)
    along = min(1.0, spec.max_step / max(distance, 1e-9))
    about = min(1.0, math.radians(spec.max_turn_deg) / max(turn, 1e-9))
    position = between(tool, aim, along).position
    return Pose(position, part_of_turn(tool.quaternion, aim.quaternion, about))


def _is_at(tool: Pose, aim: Pose) -> bool:
    near = norm(subtract(aim.position, tool.position)) < ARRIVED_M
    return near and turn_between(tool.quaternion, aim.quaternion) < ARRIVED_RAD
