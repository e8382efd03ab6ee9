"""The poses that the expert's stages require, and whether robots can take them up.

They come from the expert's dry run, which has no physics. Objects that move on the way are where
they are foreseen to be, so collisions are only looked for with what stands still: fixed objects
without the links that their joints move.
"""

from __future__ import annotations

import math
from contextlib import closing
from dataclasses import dataclass
from typing import Literal

import numpy as np

from taskbuilder.expert.planning.clearance import DEEPEST_M
from taskbuilder.expert.planning.collision_world import CollisionWorld
from taskbuilder.expert.script.dry_run import Asked, dry_run
from taskbuilder.geometry import Pose
from taskbuilder.kinematics.inverse import solve
from taskbuilder.sim.contacts import gaps
from taskbuilder.validate.reaching import NEAR_M, NEAR_TURN, margin_of, reaches
from taskbuilder.world.world import World

Verdict = Literal["in reach", "out of reach", "in collision"]

LOOK_M = 0.2
"""Distances between robots and fixed objects are measured up to this one, in metres."""

UNCHANGED_M = 0.002
"""A link whose distance has changed by less is one by which the arm stands there."""

ATTEMPTS = 4
"""Joint positions that are tried, until one is free of collisions."""


@dataclass(frozen=True)
class StagePose:
    """A pose that a stage of the expert requires of a robot's tool.

    Attributes:
        stage: Number of the stage, from 1.
        robot: The robot.
        order: The order, such as ``grasp stick.left_end``.
        pose: World pose of its tcp.
        verdict: Whether the robot can take it up.
        reach_mm: How much farther out the pose could be, at most 500; negative if it must be
            nearer, and minus infinity if nearer is not enough.
        clearance_mm: Distance of the arm from fixed objects, at most 200; None out of reach.
        obstacle: The fixed object that is nearest, or "".
    """

    stage: int
    robot: str
    order: str
    pose: Pose
    verdict: Verdict
    reach_mm: float
    clearance_mm: float | None
    obstacle: str

    @property
    def margin_mm(self) -> float:
        """The smaller one of both margins."""
        if self.clearance_mm is None:
            return self.reach_mm
        return min(self.reach_mm, self.clearance_mm)


def stage_poses(world: World) -> tuple[StagePose, ...]:
    """All poses that the expert's stages require.

    Args:
        world: The world after a reset; it is not changed.
    """
    if not world.spec.expert:
        return ()
    with closing(CollisionWorld(world)) as copy:
        copy.copy(world)
        judge = _Judge(copy)
        return tuple(judge.judged(asked) for asked in dry_run(world))


class _Judge:
    """Judges poses in a copy of a world."""

    def __init__(self, copy: CollisionWorld) -> None:
        self._copy, self._world = copy, copy.world
        self._standing = {robot: self._gaps(robot) for robot in self._world.robots}

    def judged(self, asked: Asked) -> StagePose:
        """The first of several alternative poses that is in reach, or else the first."""
        robot = self._world.robots[asked.robot]
        good = next((pose for pose in asked.choices if reaches(robot, pose)), None)
        pose = good or asked.choices[0]
        reach_mm = 1000.0 * margin_of(robot, pose, ok=good is not None)
        clearance, obstacle = self._clearance(asked.robot, pose) if good else (None, "")
        verdict: Verdict = "out of reach"
        if clearance is not None:
            verdict = "in collision" if clearance < -DEEPEST_M else "in reach"
        clearance_mm = None if clearance is None else 1000.0 * clearance
        return StagePose(
            asked.stage, asked.robot, asked.order, pose, verdict, reach_mm, clearance_mm, obstacle
        )

    def _clearance(self, name: str, pose: Pose) -> tuple[float, str]:
        """How far an arm stays from fixed objects at a pose, and from which; at best of some."""
        robot, best = self._world.robots[name], (-math.inf, "")
        for attempt in range(ATTEMPTS):
            solution = solve(
                robot.chain,
                robot.body.pose().inverse() @ pose,
                start=robot.home,
                rng=np.random.default_rng(attempt),
                position_tolerance_m=NEAR_M,
                angle_tolerance=NEAR_TURN,
            )
            self._copy.pose_arm(name, solution.joints)
            near = [
                (distance, obstacle)
                for (link, obstacle), distance in self._gaps(name).items()
                if abs(distance - self._standing[name].get((link, obstacle), LOOK_M)) > UNCHANGED_M
            ]
            best = max(best, min(near, default=(LOOK_M, "")))
            if best[0] >= -DEEPEST_M:
                break
        self._copy.pose_arm(name, robot.home)
        return best

    def _gaps(self, robot: str) -> dict[tuple[str, str], float]:
        """The distance in metres of each link of an arm from each fixed object that is near."""
        body = self._world.robots[robot].body
        nearest: dict[tuple[str, str], float] = {}
        for name, obj in self._world.objects.items():
            if not obj.spec.fixed:
                continue
            for gap in gaps(body, obj.body, LOOK_M):
                if gap.link_b not in obj.moving_links:
                    pair = gap.link_a, name
                    nearest[pair] = min(gap.distance, nearest.get(pair, LOOK_M))
        return nearest
