"""Arm modes: what the numbers of an action mean for the arm, and how they move it.

A mode turns a vector of physical units (metres, radians, newton metres) into commands to a
robot's motors. It holds no memory of its own: the last commanded joints are those of the motors,
which snapshots keep.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

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
from taskbuilder.sim.kinematics import solve
from taskbuilder.sim.stepper import ArmStepper
from taskbuilder.spec.scene import ActionSpec
from taskbuilder.world.robot import Robot
from taskbuilder.world.world import World

LAG_STEPS = 2.0
"""How many steps the commanded tool may be ahead of the measured one."""

Targets = Sequence[float] | None
"""Joint positions to arrive at with the control step, or None where motors were told otherwise."""


@dataclass(frozen=True)
class Arm:
    """What every arm mode works on.

    Attributes:
        world: The world it is in; keeps what was read of the tool's pose already.
        robot: The robot.
        spec: What its action means.
        dt: Length of a control step, s.
        stepper: The arm's inverse kinematics.
        longest: How far each joint can move in a control step, rad or m.
        home: Orientation of the tool at home, in the base frame.
        base_from_world: The world's frame as seen from the base, which never moves.
    """

    world: World
    robot: Robot
    spec: ActionSpec
    dt: float
    stepper: ArmStepper
    longest: tuple[float, ...]
    home: Quat
    base_from_world: Pose

    @classmethod
    def of(cls, world: World, robot: Robot, spec: ActionSpec, dt: float) -> Arm:
        """Prepare a robot's arm."""
        stepper = ArmStepper.of(robot.chain)
        longest = tuple((joint.velocity or math.pi) * dt for joint in robot.model.arm)
        home = stepper.forward(robot.home).quaternion
        base_from_world = robot.body.pose().inverse()
        return cls(world, robot, spec, dt, stepper, longest, home, base_from_world)

    @cached_property
    def tcp_name(self) -> str:
        """The tool's frame, as the world names it."""
        return f"{self.robot.name}.tcp"

    @property
    def reach(self) -> float:
        """How far the tool can get from the base at most, m."""
        links = [norm(offset) for offset, _ in self.stepper.offsets]
        return sum(links) + norm(self.stepper.tool.position)

    def commanded(self) -> Sequence[float]:
        """The joints as last commanded, or as they are where no position was commanded."""
        command = self.robot.arm.command
        return command.values if command.mode == "position" else self.robot.arm_state()[0]

    def approach(self, joints: Sequence[float], goal: Sequence[float]) -> list[float]:
        """Joints on the straight line to a goal, as far as one control step allows."""
        gaps = [end - begin for begin, end in zip(joints, goal, strict=True)]
        share = max(abs(gap) / most for gap, most in zip(gaps, self.longest, strict=True))
        return [begin + gap / max(share, 1.0) for begin, gap in zip(joints, gaps, strict=True)]


class ArmMode(Protocol):
    """One way to command an arm."""

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Least and greatest value of each number, in physical units."""

    def command(self, values: Sequence[float]) -> Targets:
        """Carry out an action's numbers."""


@dataclass(frozen=True)
class TcpDelta:
    """Moves the commanded tool by a step, and turns it.

    Numbers: a translation (m), then by `turn` nothing, an angle about the tool's axis, or a
    rotation vector (rad). A translation longer than `max_step` is shortened to it, a rotation
    vector likewise. The tool keeps its tilt from home unless `turn` is full.
    """

    arm: Arm

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """See `ArmMode.bounds`."""
        step, turn = self.arm.spec.max_step, math.radians(self.arm.spec.max_turn_deg)
        turns = {"none": 0, "yaw": 1, "full": 3}[self.arm.spec.turn]
        return ((-step, step),) * 3 + ((-turn, turn),) * turns

    def command(self, values: Sequence[float]) -> Targets:
        """See `ArmMode.command`."""
        arm, spec = self.arm, self.arm.spec
        joints = arm.commanded()
        frames = arm.stepper.frames(joints)
        tool = frames.tool
        shift = _shortened((values[0], values[1], values[2]), spec.max_step)
        goal = add(tool.position, self._in_base(shift, tool))
        measured = arm.base_from_world.apply(arm.world.position(arm.tcp_name))
        ahead = subtract(goal, measured)
        if norm(ahead) > LAG_STEPS * spec.max_step:
            goal = add(measured, _shortened(ahead, LAG_STEPS * spec.max_step))
        target = Pose(goal, self._turned(tool, values[3:]))
        return arm.stepper.step(joints, target, arm.longest, frames)

    def _in_base(self, vector: Vec3, tool: Pose) -> Vec3:
        if self.arm.spec.frame == "base":
            return vector
        if self.arm.spec.frame == "tcp":
            return rotate(tool.quaternion, vector)
        return rotate(self.arm.base_from_world.quaternion, vector)

    def _turned(self, tool: Pose, turn: Sequence[float]) -> Quat:
        spec, home = self.arm.spec, self.arm.home
        if spec.turn == "none":
            return home
        if spec.turn == "yaw":
            return multiply(home, _about_z(_yaw(home, tool.quaternion) + turn[0]))
        vector = _shortened((turn[0], turn[1], turn[2]), math.radians(spec.max_turn_deg))
        return multiply(_rotation(self._in_base(vector, tool)), tool.quaternion)


@dataclass(frozen=True)
class TcpPose:
    """Moves the tool towards a pose, by at most a step of `tcp_delta` at a time.

    Numbers: a position (m) relative to the arm's home tool position, in `frame`; then by `turn`
    nothing, an angle about the tool's axis from home, or a rotation vector from home (rad).
    """

    arm: Arm

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """See `ArmMode.bounds`."""
        reach = self.arm.reach
        turns = {"none": 0, "yaw": 1, "full": 3}[self.arm.spec.turn]
        return ((-reach, reach),) * 3 + ((-math.pi, math.pi),) * turns

    def command(self, values: Sequence[float]) -> Targets:
        """See `ArmMode.command`."""
        arm, spec = self.arm, self.arm.spec
        joints = arm.commanded()
        tool = arm.stepper.forward(joints)
        goal = self.goal(values)
        shift = _shortened(subtract(goal.position, tool.position), spec.max_step)
        turn = _vector_of(multiply(goal.quaternion, conjugate(tool.quaternion)))
        step = _rotation(_shortened(turn, math.radians(spec.max_turn_deg)))
        target = Pose(add(tool.position, shift), multiply(step, tool.quaternion))
        return arm.stepper.step(joints, target, arm.longest)

    def goal(self, values: Sequence[float]) -> Pose:
        """The pose that the numbers mean, in the base frame."""
        arm, spec = self.arm, self.arm.spec
        start = arm.stepper.forward(arm.robot.home)
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
class TcpPath:
    """Drives to a pose by way of the joints: for scripts, and for slow control.

    The numbers are those of `TcpPose`. The pose's inverse kinematics is solved in full, with
    restarts, from where the joints are; they go there in a straight line at their speed limits,
    so that poses are reached to which no straight motion of the tool leads. About a millisecond.
    """

    arm: Arm

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """See `ArmMode.bounds`."""
        return TcpPose(self.arm).bounds

    def command(self, values: Sequence[float]) -> Targets:
        """See `ArmMode.command`."""
        arm = self.arm
        joints = arm.commanded()
        rng = np.random.default_rng(0)  # the same path for the same command
        found = solve(arm.robot.chain, TcpPose(arm).goal(values), start=joints, rng=rng)
        return arm.approach(joints, found.joints)


@dataclass(frozen=True)
class JointDelta:
    """Moves each commanded joint by a step: rad, at most `max_turn_deg`; m, at most `max_step`."""

    arm: Arm

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """See `ArmMode.bounds`."""
        spec = self.arm.spec
        steps = [
            min(most, math.radians(spec.max_turn_deg) if turns else spec.max_step)
            for most, turns in zip(self.arm.longest, self.arm.stepper.turns, strict=True)
        ]
        return tuple((-step, step) for step in steps)

    def command(self, values: Sequence[float]) -> Targets:
        """See `ArmMode.command`."""
        stepper = self.arm.stepper
        return [
            min(max(joint + value, low), high)
            for joint, value, low, high in zip(
                self.arm.commanded(), values, stepper.lower, stepper.upper, strict=True
            )
        ]


@dataclass(frozen=True)
class JointPosition:
    """Moves the joints towards positions within their limits, at most at their speed limits."""

    arm: Arm

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """See `ArmMode.bounds`; a joint without limits turns once either way."""
        stepper = self.arm.stepper
        return tuple(
            (low, high) if math.isfinite(high - low) else (-math.pi, math.pi)
            for low, high in zip(stepper.lower, stepper.upper, strict=True)
        )

    def command(self, values: Sequence[float]) -> Targets:
        """See `ArmMode.command`."""
        return self.arm.approach(self.arm.commanded(), values)


@dataclass(frozen=True)
class JointVelocity:
    """Turns or slides the joints at velocities, rad/s or m/s."""

    arm: Arm

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """See `ArmMode.bounds`."""
        return tuple((-most / self.arm.dt, most / self.arm.dt) for most in self.arm.longest)

    def command(self, values: Sequence[float]) -> Targets:
        """See `ArmMode.command`."""
        self.arm.robot.arm.velocity(values)
        return None


@dataclass(frozen=True)
class JointTorque:
    """Applies torques (Nm) or forces (N) to the joints; nothing makes up for gravity."""

    arm: Arm

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """See `ArmMode.bounds`."""
        return tuple((-effort, effort) for effort in self.arm.robot.arm.forces)

    def command(self, values: Sequence[float]) -> Targets:
        """See `ArmMode.command`."""
        self.arm.robot.arm.torque(values)
        return None


ARM_MODES: Mapping[str, Callable[[Arm], ArmMode]] = {
    "tcp_delta": TcpDelta,
    "tcp_pose": TcpPose,
    "tcp_path": TcpPath,
    "joint_delta": JointDelta,
    "joint_position": JointPosition,
    "joint_velocity": JointVelocity,
    "joint_torque": JointTorque,
}
"""Arm modes by the name that task files give them."""


def _shortened(vector: Vec3, longest: float) -> Vec3:
    length = norm(vector)
    return vector if length <= longest else scale(vector, longest / length)


def _about_z(angle: float) -> Quat:
    return (0.0, 0.0, math.sin(angle / 2.0), math.cos(angle / 2.0))


def _yaw(home: Quat, now: Quat) -> float:
    """The part of the turn from home to now that is about the tool's own axis."""
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
