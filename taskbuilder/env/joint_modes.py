"""Arm modes in joint space."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from taskbuilder.env.arm_modes import ArmMode, Targets
from taskbuilder.env.naming import joint_names


@dataclass(frozen=True)
class JointDeltaMode(ArmMode):
    """Moves each commanded joint by a step: rad, at most `max_turn_deg`; m, at most `max_step`."""

    space = "joint"

    @property
    def longest(self) -> tuple[float, ...]:
        """Maximum motion of each joint per control step, in rad or m."""
        spec = self.arm.spec
        return tuple(
            min(most, math.radians(spec.max_turn_deg) if turns else spec.max_step)
            for most, turns in zip(self.arm.longest, self.arm.ik.turns, strict=True)
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number, without that of the robot."""
        return joint_names(len(self.arm.longest), "_delta")

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number, in physical units."""
        return tuple((-step, step) for step in self.longest)

    def after(self, joints: Sequence[float], values: Sequence[float], /) -> Sequence[float]:
        """The commanded joint positions after an action."""
        ik = self.arm.ik
        return [
            min(max(joint + value, low), high)
            for joint, value, low, high in zip(joints, values, ik.lower, ik.upper, strict=True)
        ]

    def leading_to(self, joints: Sequence[float], start: Sequence[float], /) -> Sequence[float]:
        """The numbers that command the arm to given joint positions."""
        return [goal - at for goal, at in zip(joints, start, strict=True)]


@dataclass(frozen=True)
class JointPositionMode(ArmMode):
    """Moves the joints towards positions within their limits, at most at their speed limits."""

    space = "joint"

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number, without that of the robot."""
        return joint_names(len(self.arm.longest))

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number, in physical units."""
        ik = self.arm.ik
        return tuple(
            (low, high) if math.isfinite(high - low) else (-math.pi, math.pi)
            for low, high in zip(ik.lower, ik.upper, strict=True)
        )

    def after(self, joints: Sequence[float], values: Sequence[float], /) -> Sequence[float]:
        """The commanded joint positions after an action."""
        return self.arm.approach(joints, values)

    def leading_to(self, joints: Sequence[float], _start: Sequence[float], /) -> Sequence[float]:
        """The numbers that command the arm to given joint positions."""
        return joints


@dataclass(frozen=True)
class JointVelocityMode(ArmMode):
    """Moves the joints at velocities, rad/s or m/s."""

    space = "joint"

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number, without that of the robot."""
        return joint_names(len(self.arm.longest), "_velocity")

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number, in physical units."""
        return tuple((-most / self.arm.dt, most / self.arm.dt) for most in self.arm.longest)

    def command(self, values: Sequence[float]) -> Targets:
        """Command the joints by the numbers of an action."""
        self.arm.robot.arm.velocity(values)
        return None

    def after(self, joints: Sequence[float], values: Sequence[float], /) -> Sequence[float]:
        """The joint positions to which an action would lead."""
        return [at + value * self.arm.dt for at, value in zip(joints, values, strict=True)]

    def leading_to(self, joints: Sequence[float], start: Sequence[float], /) -> Sequence[float]:
        """The numbers that command the arm to given joint positions."""
        return [(goal - at) / self.arm.dt for goal, at in zip(joints, start, strict=True)]


@dataclass(frozen=True)
class JointTorqueMode(ArmMode):
    """Applies torques (Nm) or forces (N) to the joints, without gravity compensation."""

    space = "torque"

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number, without that of the robot."""
        return joint_names(len(self.arm.longest), "_torque")

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number, in physical units."""
        return tuple((-effort, effort) for effort in self.arm.robot.arm.forces)

    def command(self, values: Sequence[float]) -> Targets:
        """Command the joints by the numbers of an action."""
        self.arm.robot.arm.torque(values)
        return None

    def after(self, joints: Sequence[float], _values: Sequence[float], /) -> Sequence[float]:
        """Not supported: the arm counts as standing still."""
        return joints

    def leading_to(self, joints: Sequence[float], _start: Sequence[float], /) -> Sequence[float]:
        """Not supported: the torques would depend on the load and contacts of the arm."""
        return [0.0] * len(joints)
