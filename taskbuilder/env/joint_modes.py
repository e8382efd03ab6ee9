"""Arm modes whose numbers are about the joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from taskbuilder.env.arm_modes import Arm, Targets


@dataclass(frozen=True)
class JointDeltaMode:
    """Moves each commanded joint by a step: rad, at most `max_turn_deg`; m, at most `max_step`."""

    arm: Arm

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """See `ArmMode.bounds`."""
        spec = self.arm.spec
        steps = [
            min(most, math.radians(spec.max_turn_deg) if turns else spec.max_step)
            for most, turns in zip(self.arm.longest, self.arm.ik.turns, strict=True)
        ]
        return tuple((-step, step) for step in steps)

    def command(self, values: Sequence[float]) -> Targets:
        """See `ArmMode.command`."""
        ik = self.arm.ik
        return [
            min(max(joint + value, low), high)
            for joint, value, low, high in zip(
                self.arm.robot.commanded(), values, ik.lower, ik.upper, strict=True
            )
        ]

    def leading_to(self, joints: Sequence[float]) -> Sequence[float]:
        """See `ArmMode.leading_to`."""
        return [goal - at for goal, at in zip(joints, self.arm.robot.commanded(), strict=True)]


@dataclass(frozen=True)
class JointPositionMode:
    """Moves the joints towards positions within their limits, at most at their speed limits."""

    arm: Arm

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """See `ArmMode.bounds`; a joint without limits turns once either way."""
        ik = self.arm.ik
        return tuple(
            (low, high) if math.isfinite(high - low) else (-math.pi, math.pi)
            for low, high in zip(ik.lower, ik.upper, strict=True)
        )

    def command(self, values: Sequence[float]) -> Targets:
        """See `ArmMode.command`."""
        return self.arm.approach(self.arm.robot.commanded(), values)

    def leading_to(self, joints: Sequence[float]) -> Sequence[float]:
        """See `ArmMode.leading_to`."""
        return joints


@dataclass(frozen=True)
class JointVelocityMode:
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

    def leading_to(self, joints: Sequence[float]) -> Sequence[float]:
        """See `ArmMode.leading_to`."""
        return [
            (goal - at) / self.arm.dt
            for goal, at in zip(joints, self.arm.robot.commanded(), strict=True)
        ]


@dataclass(frozen=True)
class JointTorqueMode:
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

    def leading_to(self, joints: Sequence[float]) -> Sequence[float]:
        """No torques: which would lead there depends on what the arm carries and touches."""
        return [0.0] * len(joints)
