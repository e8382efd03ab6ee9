"""A robot of the world: an arm that is driven by joint targets, and its end effector."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from taskbuilder.geometry import Pose
from taskbuilder.kinematics.chain import Chain
from taskbuilder.schema.robots import RobotModel
from taskbuilder.sim.body import Body
from taskbuilder.sim.contacts import pose_joints
from taskbuilder.sim.motors import Motors
from taskbuilder.world.end_effector import EndEffector


@dataclass(frozen=True)
class Robot:
    """A robot, built.

    Attributes:
        name: Its name in the scene.
        model: What it is.
        body: Its body in the simulation.
        chain: Its arm's kinematics, base link to tcp.
        arm: Motors of the arm's joints, base to wrist.
        gripper: Its end effector.
        home: Joint positions that episodes start from, in rad or m.
    """

    name: str
    model: RobotModel
    body: Body
    chain: Chain
    arm: Motors
    gripper: EndEffector
    home: tuple[float, ...]

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

    @property
    def dof(self) -> int:
        """How many joints the arm has."""
        return len(self.arm.indices)

    def arm_frames(self) -> tuple[Pose, ...]:
        """Poses of the links that the arm's joints move, base to wrist, in the world."""
        return tuple(self.body.link_pose(index) for index in self.arm.indices)

    @property
    def tip_links(self) -> tuple[str, ...]:
        """The links of the fingertips, or of the tool, that touch what it works on."""
        return tuple(self.body.link_name(link) for tip in self.gripper.tips for link in tip)

    def arm_state(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Positions and velocities of the arm's joints, in rad or m and a second."""
        return self.body.joint_states(self.arm.indices)

    def speeds(self) -> tuple[float, ...]:
        """Velocities of all joints, the arm's and then the gripper's, in rad/s or m/s."""
        return self.body.joint_speeds(self._moving)

    @cached_property
    def _moving(self) -> tuple[int, ...]:
        return self.arm.indices + self.gripper.joints

    def opening(self) -> float:
        """How far the gripper is open, from 0 (closed) to 1."""
        return self.gripper.opening()

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
        self.gripper.move(opening)

    def pose_arm(self, positions: Sequence[float]) -> None:
        """Put the arm's joints at positions (rad or m) for a look at distances, past all motors."""
        pose_joints(self.body, self.arm.indices, positions)

    def go_home(self) -> None:
        """Put the arm home, at rest, with the gripper open, and hold it there."""
        self.body.reset_joints(self.arm.indices, self.home)
        self.gripper.go_home()
        self.move_arm(self.home)


@cache
def _shares(steps: int) -> NDArray[np.float64]:
    """(steps - 1, 1) how much of the way is done after each step but the last."""
    return np.arange(1, steps)[:, None] / steps
