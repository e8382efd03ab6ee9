"""A robot of the world: an arm that is driven by joint targets, and a gripper that opens."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from taskbuilder.geometry import Pose
from taskbuilder.schema.robots import RobotModel
from taskbuilder.sim.body import Body
from taskbuilder.sim.kinematics import Chain
from taskbuilder.sim.motors import Motors


@dataclass(frozen=True)
class Robot:
    """A robot, built.

    Attributes:
        name: Its name in the scene.
        model: What it is.
        body: Its body in the simulation.
        chain: Its arm's kinematics, base link to tcp.
        arm: Motors of the arm's joints, base to wrist.
        gripper: Motors of the gripper's joints.
        home: Joint positions that episodes start from, in rad or m.
        fingers: Link indices of each finger.
    """

    name: str
    model: RobotModel
    body: Body
    chain: Chain
    arm: Motors
    gripper: Motors
    home: tuple[float, ...]
    fingers: tuple[tuple[int, ...], ...]

    @property
    def tcp(self) -> Pose:
        """The tool centre point in the world: z the direction of approach, y that of closing."""
        return self.body.link_pose(self.tcp_link) @ self._tcp_offset

    @cached_property
    def tcp_link(self) -> int:
        """Index of the link that the tool centre point is fixed to."""
        return self.body.links[self.model.spec.tcp.link]

    @cached_property
    def _tcp_offset(self) -> Pose:
        return self.model.spec.tcp.pose

    def arm_state(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Positions and velocities of the arm's joints, in rad or m and a second."""
        return self.body.joint_states(self.arm.indices)

    def speeds(self) -> tuple[float, ...]:
        """Velocities of all joints, the arm's and then the gripper's, in rad/s or m/s."""
        return self.body.joint_speeds(self._moving)

    @cached_property
    def _moving(self) -> tuple[int, ...]:
        return self.arm.indices + self.gripper.indices

    def opening(self) -> float:
        """How far the gripper is open, from 0 (closed) to 1, averaged over its joints."""
        positions, _ = self.body.joint_states(self.gripper.indices)
        ends = self.model.spec.gripper.joints.values()
        shares = [
            (position - end.closed) / (end.open - end.closed)
            for position, end in zip(positions, ends, strict=True)
        ]
        return sum(shares) / len(shares)

    def commanded(self) -> tuple[float, ...]:
        """The arm's joints as last commanded, or as they are where no position was commanded."""
        command = self.arm.command
        return command.values if command.mode == "position" else self.arm_state()[0]

    def move_arm(self, positions: Sequence[float]) -> None:
        """Drive the arm's joints to positions, in rad or m."""
        self.arm.position(positions)

    def ramp(self, positions: Sequence[float], steps: int) -> Iterator[None]:
        """Drive the arm's joints to positions evenly over some physics steps, one a `next`.

        A target that jumps once a control step makes the arm jerk and overshoot.
        """
        told = self.arm.command
        while told.mode == "position" and told.values == tuple(positions):
            yield  # motors go on with what they were told
        start = np.array(self.commanded())
        way = np.array(positions) - start
        for waypoint in (start + _shares(steps) * way).tolist():
            self.arm.pass_by(waypoint)
            yield
        self.arm.position(positions)
        yield

    @property
    def pushes(self) -> bool:
        """Whether the arm was told torques, which the physics forgets after each of its steps."""
        return self.arm.command.mode == "torque"

    def push(self) -> Iterator[None]:
        """Apply the arm's torques anew, once a `next`."""
        while True:
            self.arm.repeat()
            yield

    def move_gripper(self, opening: float) -> None:
        """Drive the gripper to an opening from 0 (closed) to 1 (open)."""
        positions = self.gripper_positions(opening)
        if positions != self.gripper.command.values:  # motors go on with what they were told
            self.gripper.position(positions)

    def gripper_positions(self, opening: float) -> tuple[float, ...]:
        """Positions of the gripper's joints at an opening from 0 to 1."""
        return tuple(
            end.closed + opening * (end.open - end.closed)
            for end in self.model.spec.gripper.joints.values()
        )

    def go_home(self) -> None:
        """Put the arm home, at rest, with the gripper open, and hold it there."""
        self.body.reset_joints(self.arm.indices, self.home)
        self.body.reset_joints(self.gripper.indices, self.gripper_positions(1.0))
        self.move_arm(self.home)
        self.move_gripper(1.0)


@cache
def _shares(steps: int) -> NDArray[np.float64]:
    """(steps - 1, 1) how much of the way is done after each step but the last."""
    return np.arange(1, steps)[:, None] / steps
