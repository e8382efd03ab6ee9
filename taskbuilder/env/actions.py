"""Actions: an agent's numbers, in the order arm then gripper, carried out on its robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.arm_modes import Arm, ArmMode, Targets
from taskbuilder.env.joint_modes import (
    JointDeltaMode,
    JointPositionMode,
    JointTorqueMode,
    JointVelocityMode,
)
from taskbuilder.env.tcp_modes import TcpDeltaMode, TcpPathMode, TcpPoseMode
from taskbuilder.schema.scene import ActionSpec
from taskbuilder.world.robot import Robot
from taskbuilder.world.world import World

ARM_MODES: Mapping[str, Callable[[Arm], ArmMode]] = {
    "tcp_delta": TcpDeltaMode,
    "tcp_pose": TcpPoseMode,
    "tcp_path": TcpPathMode,
    "joint_delta": JointDeltaMode,
    "joint_position": JointPositionMode,
    "joint_velocity": JointVelocityMode,
    "joint_torque": JointTorqueMode,
}
"""Arm modes by the name that task files give them."""

HYSTERESIS = 0.2
"""A binary gripper changes its mind only for a command beyond this, of at most 1."""


@dataclass(frozen=True)
class GripperMode:
    """Commands a gripper: binary, or by how far it is to be open."""

    robot: Robot
    kind: Literal["binary", "continuous"]

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest value: -1 (close) to 1 (open), or an opening in metres."""
        return (-1.0, 1.0) if self.kind == "binary" else (0.0, self.robot.model.spec.gripper.stroke)

    def opening_to(self, opening: float | None) -> float:
        """The number that opens the gripper to a share from 0 to 1, or leaves it for None."""
        if self.kind == "continuous":
            told = self._told() if opening is None else opening
            return told * self.robot.model.spec.gripper.stroke
        return 0.0 if opening is None else 1.0 if opening > 0.5 else -1.0

    def _told(self) -> float:
        """The opening that was commanded last."""
        end = next(iter(self.robot.model.spec.gripper.joints.values()))
        return (self.robot.gripper.command.values[0] - end.closed) / (end.open - end.closed)

    def command(self, value: float) -> None:
        """Carry out an action's last number."""
        if self.kind == "continuous":
            self.robot.move_gripper(value / self.robot.model.spec.gripper.stroke)
        elif value > HYSTERESIS:
            self.robot.move_gripper(1.0)
        elif value < -HYSTERESIS:
            self.robot.move_gripper(0.0)


class RobotActions:
    """The actions of one agent: bounds, and carrying one out.

    Attributes:
        arm: What the arm's numbers work on.
        low: (n,) least value of each number, in physical units.
        high: (n,) greatest value.
        size: How many numbers an action has: the arm's, then the gripper's one.
    """

    def __init__(self, world: World, robot: Robot, spec: ActionSpec, dt: float) -> None:
        self.arm = Arm.of(world, robot, spec, dt)
        self._mode: ArmMode = ARM_MODES[spec.arm](self.arm)
        self._gripper = GripperMode(robot, spec.gripper)
        self._bounds = (*self._mode.bounds, self._gripper.bounds)
        self._spans = tuple(((low + high) / 2.0, (high - low) / 2.0) for low, high in self._bounds)
        self.size = len(self._bounds)
        self.low: NDArray[np.float64] = np.array([low for low, _ in self._bounds])
        self.high: NDArray[np.float64] = np.array([high for _, high in self._bounds])

    def physical(self, normalized: Sequence[float]) -> list[float]:
        """Numbers from -1 to 1 in physical units, those beyond clipped."""
        return [
            middle + half * (1.0 if value > 1.0 else -1.0 if value < -1.0 else value)
            for value, (middle, half) in zip(normalized, self._spans, strict=True)
        ]

    def clipped(self, physical: Sequence[float]) -> list[float]:
        """Numbers in physical units, those beyond the bounds clipped."""
        return [
            min(max(value, low), high)
            for value, (low, high) in zip(physical, self._bounds, strict=True)
        ]

    def normalized(self, physical: Sequence[float]) -> list[float]:
        """Numbers in physical units as numbers from -1 to 1, those beyond the bounds clipped."""
        return [
            (value - middle) / half
            for value, (middle, half) in zip(self.clipped(physical), self._spans, strict=True)
        ]

    def leading_to(
        self, joints: Sequence[float] | None = None, opening: float | None = None
    ) -> list[float]:
        """The action, in physical units, that commands the arm to joints and opens the gripper.

        Args:
            joints: Positions within a control step's reach, rad or m; None to stay.
            opening: Of the gripper, from 0 (closed) to 1; None to leave it as it was told.
        """
        arm = self._mode.leading_to(self.arm.robot.commanded() if joints is None else joints)
        return self.clipped([*arm, self._gripper.opening_to(opening)])

    def command(self, values: Sequence[float]) -> Targets:
        """Carry out an action in physical units and within the bounds.

        Returns:
            Joint positions for the arm to arrive at with the control step, or None.
        """
        *arm, gripper = values
        self._gripper.command(gripper)
        return self._mode.command(arm)
