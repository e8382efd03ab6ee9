"""Arm modes: the interpretations of the arm's part of an action.

A mode turns a vector in physical units (metres, radians, newton metres) into commands to a robot's
motors, and finds the vector that leads to given joint positions. It has no state of its own: the
last commanded joints are those of the motors, which snapshots save.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal

from taskbuilder.geometry import Pose, Quat, norm, total
from taskbuilder.kinematics.differential_ik import DifferentialIK
from taskbuilder.schema.agents import ActionSpec
from taskbuilder.world.robot import Robot
from taskbuilder.world.world import World

Targets = Sequence[float] | None
"""Joint positions for the end of the control step, or None if motors have other commands."""


Space = Literal["tool", "joint", "torque"]
"""What the numbers of an action command."""


@dataclass(frozen=True)
class Arm:
    """An arm, as arm modes use it.

    Attributes:
        world: The world, which caches the tool's pose.
        robot: The robot.
        spec: The action section of the task file.
        dt: Length of a control step, s.
        ik: The arm's inverse kinematics.
        longest: How far each joint can move in a control step, rad or m.
        home: Orientation of the tool at home, in the base frame.
        base_from_world: The world's frame as seen from the base, which never moves.
    """

    world: World
    robot: Robot
    spec: ActionSpec
    dt: float
    ik: DifferentialIK
    longest: tuple[float, ...]
    home: Quat
    base_from_world: Pose

    @classmethod
    def of(cls, world: World, robot: Robot, spec: ActionSpec, dt: float) -> Arm:
        """Make an `Arm` for a robot."""
        ik = DifferentialIK.of(robot.chain)
        longest = tuple((joint.velocity or math.pi) * dt for joint in robot.model.arm)
        home = ik.forward(robot.home).quaternion
        base_from_world = robot.body.pose().inverse()
        return cls(world, robot, spec, dt, ik, longest, home, base_from_world)

    @cached_property
    def tcp_name(self) -> str:
        """The tool's frame, as the world names it."""
        return f"{self.robot.name}.tcp"

    @property
    def reach(self) -> float:
        """Maximum distance of the tool from the base, m."""
        links = [norm(offset) for offset, _ in self.ik.offsets]
        travels = [
            max(abs(low), abs(high))
            for low, high, turns in zip(self.ik.lower, self.ik.upper, self.ik.turns, strict=True)
            if not turns
        ]
        return total(links) + norm(self.ik.tool.position) + total(travels)

    def approach(self, joints: Sequence[float], goal: Sequence[float]) -> list[float]:
        """Joints on the straight line to a goal, as far as one control step allows."""
        gaps = [end - begin for begin, end in zip(joints, goal, strict=True)]
        share = max(abs(gap) / most for gap, most in zip(gaps, self.longest, strict=True))
        return [begin + gap / max(share, 1.0) for begin, gap in zip(joints, gaps, strict=True)]


@dataclass(frozen=True)
class ArmMode(ABC):
    """One way to command an arm.

    Attributes:
        space: What the numbers command: the tool's motion, the joints' motion, or the joints'
            torques, for which no motion can be planned.
        arm: What they command.
    """

    space: ClassVar[Space]
    arm: Arm

    @property
    def longest(self) -> tuple[float, ...]:
        """Maximum motion of each joint per control step, in rad or m."""
        return self.arm.longest

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """Name of each number, without that of the robot."""

    @property
    @abstractmethod
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number, in physical units."""

    @abstractmethod
    def after(self, joints: Sequence[float], values: Sequence[float], /) -> Sequence[float]:
        """The commanded joint positions after an action.

        Args:
            joints: The ones before it, rad or m.
            values: The numbers of the action.
        """

    def command(self, values: Sequence[float]) -> Targets:
        """Command the motors by the numbers of an action.

        Returns:
            Joint positions for the end of the control step, or None if motors have other commands.
        """
        return self.after(self.arm.robot.commanded(), values)

    @abstractmethod
    def leading_to(self, joints: Sequence[float], start: Sequence[float], /) -> Sequence[float]:
        """The numbers that command the arm to given joint positions.

        Args:
            joints: Positions within one control step's reach of ``start``, rad or m.
            start: The commanded ones when the action is carried out.
        """
