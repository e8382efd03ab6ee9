"""A scripted controller: straight lines of the tcp, a few centimetres a control step."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from taskbuilder.description.description import Outcome, Referee
from taskbuilder.geometry import (
    Pose,
    Quat,
    Vec3,
    add,
    conjugate,
    cross,
    from_axes,
    multiply,
    norm,
    normalized,
    scale,
    subtract,
    turn_between,
)
from taskbuilder.kinematics.inverse import solve
from taskbuilder.task import Task
from taskbuilder.world.world import World

MAX_STEP_M = 0.05
MAX_TURN = math.radians(15)


class Script:
    """Plays one episode: each method lets control steps pass and has each of them judged.

    Attributes:
        outcomes: What the referee said, after reset and after every control step.
    """

    def __init__(self, task: Task, world: World, seed: int) -> None:
        self.world = world
        self.referee = Referee(task.description, world.robot_names)
        world.watch_forces(self.referee.force_pairs)
        world.reset(seed)
        self.outcomes = [self.referee.start(world)]
        self.commanded = {name: world.pose(f"{name}.tcp") for name in world.robot_names}

    @property
    def steps(self) -> int:
        """Control steps so far."""
        return len(self.outcomes) - 1

    def grasp_pose(self, name: str, grasp: str) -> Pose:
        """Where a robot's tcp is when it takes a thing by a grasp point from above.

        Of the two ways round, the one nearer to how the tool is turned now.
        """
        owner, _, point = grasp.partition(".")
        spec = self.world.objects[owner].spec.grasps[point]
        assert spec.approach == "down"
        across = self.world.pose(owner).axis("xyz".index(spec.across))
        heading = math.atan2(across[1], across[0])
        turns = [tool_down(heading), tool_down(heading + math.pi)]
        now = self.commanded[name].quaternion
        return Pose(
            self.world.position(grasp), min(turns, key=lambda turn: turn_between(now, turn))
        )

    def go(self, goals: Mapping[str, Pose]) -> None:
        """Bring tcps to poses in the world, all at once, each at its greatest speed."""
        while True:
            moving = {name: goal for name, goal in goals.items() if self.commanded[name] != goal}
            if not moving:
                return
            self.step({n: _towards(self.commanded[n], g) for n, g in moving.items()})

    def grip(self, *names: str, opening: float, steps: int) -> None:
        """Open or close grippers and give them some control steps for it."""
        for name in names:
            self.world.robots[name].move_gripper(opening)
        self.wait(steps)

    def step(self, poses: Mapping[str, Pose]) -> Outcome:
        """One control step, at the end of which tcps are told to be at poses near by."""
        targets = {}
        for name, pose in poses.items():
            robot = self.world.robots[name]
            target = robot.body.pose().inverse() @ pose
            start = robot.arm.command.values
            found = solve(robot.chain, target, start=start, rng=np.random.default_rng(0))
            assert found.ok, f"{name} cannot reach {pose}"
            targets[name] = found.joints
            self.commanded[name] = pose
        self.world.step(targets)
        self.outcomes.append(self.referee.judge(self.world))
        return self.outcomes[-1]

    def wait(self, steps: int) -> None:
        """Let control steps pass."""
        for _ in range(steps):
            self.step({})

    def carrying(self, name: str, thing: str, goal: Pose) -> Pose:
        """Where a robot's tcp must be for a thing that it holds to be at a pose."""
        return goal @ self.world.pose(thing).inverse() @ self.world.pose(f"{name}.tcp")


def tool_down(heading: float) -> Quat:
    """A tool that points down and closes along a horizontal direction (rad from world x)."""
    closing, approach = (math.cos(heading), math.sin(heading), 0.0), (0.0, 0.0, -1.0)
    return from_axes(cross(closing, approach), closing, approach)


def _towards(start: Pose, goal: Pose) -> Pose:
    way = subtract(goal.position, start.position)
    turn = turn_between(start.quaternion, goal.quaternion)
    share = max(norm(way) / MAX_STEP_M, turn / MAX_TURN)
    if share <= 1.0:
        return goal
    return Pose(
        add(start.position, scale(way, 1.0 / share)),
        _part_of_turn(start.quaternion, goal.quaternion, 1.0 / share),
    )


def _part_of_turn(start: Quat, goal: Quat, share: float) -> Quat:
    x, y, z, w = multiply(goal, conjugate(start))
    if w < 0.0:
        x, y, z, w = -x, -y, -z, -w
    sine = math.hypot(x, y, z)
    if sine < 1e-9:
        return goal
    half = share * math.atan2(sine, w)
    axis: Vec3 = (x / sine, y / sine, z / sine)
    part = (*scale(axis, math.sin(half)), math.cos(half))
    return normalized(multiply(part, start))
