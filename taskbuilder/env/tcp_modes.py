"""Arm modes in Cartesian space: a step of the tool, or a target pose."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from taskbuilder.env.arm_modes import ArmMode, Targets
from taskbuilder.env.naming import POSITION
from taskbuilder.geometry import (
    NO_TURN,
    Pose,
    Quat,
    Vec3,
    add,
    conjugate,
    multiply,
    norm,
    rotate,
    scale,
    subtract,
)
from taskbuilder.kinematics.inverse import solve

TURN_NUMBERS = {"none": 0, "yaw": 1, "full": 3}
"""How many numbers say how the tool turns."""

TURN_NAMES = {"none": (), "yaw": ("yaw",), "full": ("rx", "ry", "rz")}
"""What the numbers that say how the tool turns are called."""

LAG_STEPS = 2.0
"""Maximum lead of the commanded tool over the measured one, in steps."""


@dataclass(frozen=True)
class TcpDeltaMode(ArmMode):
    """Moves the commanded tool by a step, and turns it.

    Numbers: a translation (m), then by `turn` nothing, an angle about the tool's axis, or a
    rotation vector (rad). Translations are shortened to `max_step`, and rotation vectors to
    `max_turn_deg`. The tool keeps its tilt from home unless `turn` is full.
    """

    space = "tool"

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number, without that of the robot."""
        return tuple(f"d{name}" for name in (*POSITION, *TURN_NAMES[self.arm.spec.turn]))

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number, in physical units."""
        step, turn = self.arm.spec.max_step, math.radians(self.arm.spec.max_turn_deg)
        return ((-step, step),) * 3 + ((-turn, turn),) * TURN_NUMBERS[self.arm.spec.turn]

    def command(self, values: Sequence[float]) -> Targets:
        """Command the tool by the numbers of an action, not too far ahead of the measured one."""
        arm, joints = self.arm, self.arm.robot.commanded()
        target, most = self._target(joints, values), LAG_STEPS * arm.spec.max_step
        measured = arm.base_from_world.apply(arm.world.position(arm.tcp_name))
        ahead = subtract(target.position, measured)
        if norm(ahead) > most:
            target = Pose(add(measured, _shortened(ahead, most)), target.quaternion)
        return arm.ik.step(joints, target, arm.longest)

    def after(self, joints: Sequence[float], values: Sequence[float], /) -> Sequence[float]:
        """The commanded joint positions after an action of a tool that does not lag behind."""
        return self.arm.ik.step(joints, self._target(joints, values), self.arm.longest)

    def _target(self, joints: Sequence[float], values: Sequence[float]) -> Pose:
        tool = self.arm.ik.forward(joints)
        shift = _shortened((values[0], values[1], values[2]), self.arm.spec.max_step)
        goal = add(tool.position, self._in_base(shift, tool))
        return Pose(goal, self._turned(tool, values[3:]))

    def leading_to(self, joints: Sequence[float], start: Sequence[float], /) -> Sequence[float]:
        """The numbers that command the arm to given joint positions."""
        arm, spec = self.arm, self.arm.spec
        tool, goal = arm.ik.forward(start), arm.ik.forward(joints)
        shift = self._from_base(subtract(goal.position, tool.position), tool)
        if spec.turn == "none":
            return shift
        if spec.turn == "yaw":
            turn = _yaw(arm.home, goal.quaternion) - _yaw(arm.home, tool.quaternion)
            return (*shift, math.remainder(turn, 2.0 * math.pi))
        vector = _vector_of(multiply(goal.quaternion, conjugate(tool.quaternion)))
        return (*shift, *self._from_base(vector, tool))

    def _in_base(self, vector: Vec3, tool: Pose) -> Vec3:
        if self.arm.spec.frame == "base":
            return vector
        if self.arm.spec.frame == "tcp":
            return rotate(tool.quaternion, vector)
        return rotate(self.arm.base_from_world.quaternion, vector)

    def _from_base(self, vector: Vec3, tool: Pose) -> Vec3:
        if self.arm.spec.frame == "base":
            return vector
        if self.arm.spec.frame == "tcp":
            return rotate(conjugate(tool.quaternion), vector)
        return rotate(conjugate(self.arm.base_from_world.quaternion), vector)

    def _turned(self, tool: Pose, turn: Sequence[float]) -> Quat:
        spec, home = self.arm.spec, self.arm.home
        if spec.turn == "none":
            return home
        if spec.turn == "yaw":
            return multiply(home, _about_z(_yaw(home, tool.quaternion) + turn[0]))
        vector = _shortened((turn[0], turn[1], turn[2]), math.radians(spec.max_turn_deg))
        return multiply(_rotation(self._in_base(vector, tool)), tool.quaternion)


@dataclass(frozen=True)
class TcpPoseMode(ArmMode):
    """Moves the tool towards a pose, by at most a step of `tcp_delta` at a time.

    Numbers: a position (m) relative to the arm's home tool position, in `frame`; then by `turn`
    nothing, an angle about the tool's axis from home, or a rotation vector from home (rad).
    """

    space = "tool"

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number, without that of the robot."""
        return (*POSITION, *TURN_NAMES[self.arm.spec.turn])

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number, in physical units."""
        reach = self.arm.reach
        return ((-reach, reach),) * 3 + ((-math.pi, math.pi),) * TURN_NUMBERS[self.arm.spec.turn]

    def after(self, joints: Sequence[float], values: Sequence[float], /) -> Sequence[float]:
        """The commanded joint positions after an action."""
        arm, spec = self.arm, self.arm.spec
        tool = arm.ik.forward(joints)
        goal = self.goal(values)
        shift = _shortened(subtract(goal.position, tool.position), spec.max_step)
        turn = _vector_of(multiply(goal.quaternion, conjugate(tool.quaternion)))
        step = _rotation(_shortened(turn, math.radians(spec.max_turn_deg)))
        target = Pose(add(tool.position, shift), multiply(step, tool.quaternion))
        return arm.ik.step(joints, target, arm.longest)

    def leading_to(self, joints: Sequence[float], _start: Sequence[float], /) -> Sequence[float]:
        """The numbers that command the arm to given joint positions."""
        arm, spec = self.arm, self.arm.spec
        goal = arm.ik.forward(joints)
        offset = subtract(goal.position, arm.ik.forward(arm.robot.home).position)
        if spec.frame == "world":
            offset = rotate(conjugate(arm.base_from_world.quaternion), offset)
        elif spec.frame == "tcp":
            offset = rotate(conjugate(arm.home), offset)
        if spec.turn == "none":
            return offset
        if spec.turn == "yaw":
            return (*offset, math.remainder(_yaw(arm.home, goal.quaternion), 2.0 * math.pi))
        return (*offset, *_vector_of(multiply(conjugate(arm.home), goal.quaternion)))

    def goal(self, values: Sequence[float]) -> Pose:
        """The target pose in the base frame."""
        arm, spec = self.arm, self.arm.spec
        start = arm.ik.forward(arm.robot.home)
        offset: Vec3 = (values[0], values[1], values[2])
        if spec.frame == "world":
            offset = rotate(arm.base_from_world.quaternion, offset)
        elif spec.frame == "tcp":
            offset = rotate(arm.home, offset)
        turn = NO_TURN
        if spec.turn == "yaw":
            turn = _about_z(values[3])
        elif spec.turn == "full":
            turn = _rotation((values[3], values[4], values[5]))
        return Pose(add(start.position, offset), multiply(arm.home, turn))


@dataclass(frozen=True)
class TcpPathMode(ArmMode):
    """Moves to a pose in joint space, for scripts and for slow control.

    The numbers are those of `TcpPoseMode`. The inverse kinematics of the pose is solved with
    restarts, from the current joints, and the joints move there in a straight line at their speed
    limits. So poses can be reached that no straight motion of the tool leads to. Takes about a
    millisecond.
    """

    space = "tool"

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number, without that of the robot."""
        return TcpPoseMode(self.arm).names

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number, in physical units."""
        return TcpPoseMode(self.arm).bounds

    def after(self, joints: Sequence[float], values: Sequence[float], /) -> Sequence[float]:
        """The commanded joint positions after an action."""
        arm = self.arm
        rng = np.random.default_rng(0)  # the same path for the same command
        solution = solve(arm.robot.chain, TcpPoseMode(arm).goal(values), start=joints, rng=rng)
        return arm.approach(joints, solution.joints)

    def leading_to(self, joints: Sequence[float], start: Sequence[float], /) -> Sequence[float]:
        """The numbers that command the arm to given joint positions."""
        return TcpPoseMode(self.arm).leading_to(joints, start)


def _shortened(vector: Vec3, longest: float) -> Vec3:
    length = norm(vector)
    return vector if length <= longest else scale(vector, longest / length)


def _about_z(angle: float) -> Quat:
    return (0.0, 0.0, math.sin(angle / 2.0), math.cos(angle / 2.0))


def _yaw(home: Quat, now: Quat) -> float:
    """The rotation from home to now about the tool's own axis."""
    _, _, z, w = multiply(conjugate(home), now)
    return 2.0 * math.atan2(z, w)


def _rotation(vector: Vec3) -> Quat:
    angle = norm(vector)
    if angle < 1e-12:
        return NO_TURN
    x, y, z = scale(vector, math.sin(angle / 2.0) / angle)
    return (x, y, z, math.cos(angle / 2.0))


def _vector_of(turn: Quat) -> Vec3:
    x, y, z, w = turn if turn[3] >= 0.0 else (-turn[0], -turn[1], -turn[2], -turn[3])
    sine = math.sqrt(x * x + y * y + z * z)
    return scale((x, y, z), 2.0 * math.atan2(sine, w) / sine) if sine > 1e-12 else (0.0, 0.0, 0.0)
