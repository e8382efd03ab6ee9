"""Actions of agents: the arm's numbers, then the gripper's if it has one, applied to its robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from inspect import isabstract
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.arm_modes import Arm, ArmMode, Space, Targets
from taskbuilder.env.foreign_modes import ForeignMode
from taskbuilder.env.joint_modes import (
    JointDeltaMode,
    JointPositionMode,
    JointTorqueMode,
    JointVelocityMode,
)
from taskbuilder.env.tcp_modes import TcpDeltaMode, TcpPathMode, TcpPoseMode
from taskbuilder.extensions import ACTION_MODES, ForeignPart
from taskbuilder.schema.agents import ActionSpec
from taskbuilder.world.robot import Robot
from taskbuilder.world.world import World

ARM_MODES: Mapping[str, type[ArmMode]] = {
    "tcp_delta": TcpDeltaMode,
    "tcp_pose": TcpPoseMode,
    "tcp_path": TcpPathMode,
    "joint_delta": JointDeltaMode,
    "joint_position": JointPositionMode,
    "joint_velocity": JointVelocityMode,
    "joint_torque": JointTorqueMode,
}
"""Arm modes by the name that task files give them."""


def arm_mode(name: str) -> type[ArmMode]:
    """The arm mode of a name; also one that another package adds.

    Raises:
        UnknownNameError: There is none.
        ExtensionError: It is of another package, and cannot be used.
    """
    part = ACTION_MODES.part(name, ARM_MODES)
    if part is None:
        return ARM_MODES[name]
    return load_mode(part)


def load_mode(part: ForeignPart) -> type[ArmMode]:
    """The arm mode that another package adds.

    Raises:
        ExtensionError: It cannot be used.
    """
    mode: type[ArmMode] = part.load(_no_mode)
    return mode


def make_mode(arm: Arm) -> ArmMode:
    """The mode by which actions command an arm.

    Raises:
        ExtensionError: It is of another package, and cannot be used.
    """
    part = ACTION_MODES.part(arm.spec.arm, ARM_MODES)
    mode = arm_mode(arm.spec.arm)
    return mode(arm) if part is None else ForeignMode.of(part, mode, arm)


def _no_mode(part: object) -> str | None:
    if not (isinstance(part, type) and issubclass(part, ArmMode)):
        return "is no subclass of taskbuilder.env.arm_modes.ArmMode"
    if isabstract(part):
        return f"lacks {', '.join(sorted(part.__abstractmethods__))}"
    if getattr(part, "space", None) not in get_args(Space):
        return f"has no space; set it to one of {', '.join(get_args(Space))}"
    return None


def can_be_planned(spec: ActionSpec) -> bool:
    """Whether a planned motion can be written as actions of this kind."""
    return arm_mode(spec.arm).space != "torque"


HYSTERESIS = 0.2
"""A binary gripper ignores commands up to this size, of at most 1."""


@dataclass(frozen=True)
class GripperMode:
    """Commands a gripper: open or close, or by an opening width."""

    robot: Robot
    kind: Literal["binary", "continuous"]

    @property
    def bounds(self) -> tuple[float, float]:
        """Lower and upper bound: -1 (close) to 1 (open), or an opening width in metres."""
        return (-1.0, 1.0) if self.kind == "binary" else (0.0, self.robot.model.stroke)

    def opening_to(self, opening: float | None, waiting: Sequence[float] = ()) -> float:
        """The number that opens the gripper to a fraction from 0 to 1.

        Args:
            opening: The fraction; None leaves the gripper unchanged.
            waiting: Numbers of actions that have yet to be carried out.
        """
        if self.kind == "binary":
            return 0.0 if opening is None else 1.0 if opening > 0.5 else -1.0
        if opening is None and waiting:
            return waiting[-1]
        return (self.robot.gripper.told() if opening is None else opening) * self.robot.model.stroke

    def command(self, value: float) -> None:
        """Command the gripper by the last number of an action."""
        if self.kind == "continuous":
            self.robot.move_gripper(value / self.robot.model.stroke)
        elif value > HYSTERESIS:
            self.robot.move_gripper(1.0)
        elif value < -HYSTERESIS:
            self.robot.move_gripper(0.0)


class RobotActions:
    """The actions of one agent: their bounds and their execution.

    Attributes:
        arm: The arm that is commanded.
        low: (n,) lower bound of each number, in physical units.
        high: (n,) upper bound.
        short_names: Name of each number, such as ``dx`` or ``gripper``.
        names: The same with the robot's name, such as ``left.dx``.
        size: Number of values in an action: the arm's, then one for the gripper if there is one.
        arm_size: Number of those of the arm.
    """

    def __init__(self, world: World, robot: Robot, spec: ActionSpec, dt: float) -> None:
        self.arm = Arm.of(world, robot, spec, dt)
        self._mode = make_mode(self.arm)
        self._gripper = GripperMode(robot, spec.gripper) if robot.model.takes_hold else None
        of_gripper = (self._gripper.bounds,) if self._gripper else ()
        self._bounds = (*self._mode.bounds, *of_gripper)
        self._spans = tuple(((low + high) / 2.0, (high - low) / 2.0) for low, high in self._bounds)
        self.size = len(self._bounds)
        self.short_names = (*self._mode.names, *(["gripper"] if self._gripper else ()))
        self.names = tuple(f"{robot.name}.{name}" for name in self.short_names)
        self.arm_size = self.size - len(of_gripper)
        self.low: NDArray[np.float64] = np.array([low for low, _ in self._bounds])
        self.high: NDArray[np.float64] = np.array([high for _, high in self._bounds])

    def physical(self, normalized: Sequence[float]) -> list[float]:
        """Convert numbers from -1 to 1 to physical units, clipped to the bounds."""
        return [
            middle + half * (1.0 if value > 1.0 else -1.0 if value < -1.0 else value)
            for value, (middle, half) in zip(normalized, self._spans, strict=True)
        ]

    def clipped(self, physical: Sequence[float]) -> list[float]:
        """Clip numbers in physical units to the bounds."""
        return [
            min(max(value, low), high)
            for value, (low, high) in zip(physical, self._bounds, strict=True)
        ]

    def normalized(self, physical: Sequence[float]) -> list[float]:
        """Convert numbers in physical units to -1 to 1, clipped to the bounds."""
        return [
            (value - middle) / half
            for value, (middle, half) in zip(self.clipped(physical), self._spans, strict=True)
        ]

    def leading_to(
        self,
        joints: Sequence[float] | None = None,
        opening: float | None = None,
        waiting: Sequence[Sequence[float]] = (),
    ) -> list[float]:
        """The action, in physical units, for given joint positions and a gripper opening.

        Args:
            joints: Positions within a control step's reach, rad or m; None to stay.
            opening: Of the gripper, from 0 (closed) to 1; None to leave it unchanged.
            waiting: Earlier actions, in physical units, that have yet to be carried out.
        """
        start = self.commanded_after(waiting)
        arm = self._mode.leading_to(start if joints is None else joints, start)
        commands = [values[-1] for values in waiting]
        gripper = [self._gripper.opening_to(opening, commands)] if self._gripper else []
        return self.clipped([*arm, *gripper])

    def commanded_after(self, waiting: Sequence[Sequence[float]]) -> Sequence[float]:
        """The joint positions, rad or m, that are commanded once earlier actions are carried out.

        Args:
            waiting: These actions, in physical units.
        """
        joints: Sequence[float] = self.arm.robot.commanded()
        for values in waiting:
            joints = self._mode.after(joints, values[: self.arm_size])
        return joints

    def joint_targets(self) -> tuple[float, ...]:
        """The last commands: joint positions (rad or m), and the gripper's opening from 0 to 1."""
        robot = self.arm.robot
        return (*robot.commanded(), robot.gripper.told())

    def command(self, values: Sequence[float]) -> Targets:
        """Apply an action in physical units and within the bounds.

        Returns:
            Joint positions of the arm for the end of the control step, or None.
        """
        if self._gripper:
            self._gripper.command(values[-1])
        return self._mode.command(values[: self.arm_size])
