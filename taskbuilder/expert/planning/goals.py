"""The end of a motion: joint positions with which tools reach their goals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice, product

import numpy as np

from taskbuilder.expert.planning.errors import PlanningError
from taskbuilder.expert.planning.reach import Reach
from taskbuilder.expert.planning.spaces import Off, Space, Waypoint
from taskbuilder.expert.planning.subspaces import ArmJoints, Carried, Jointed, Subspace
from taskbuilder.geometry import Pose
from taskbuilder.kinematics.inverse import beginnings_of, solve

BRANCHES = 16
"""Start points of the search for further joint solutions."""

MOST_ENDS = 12
"""Maximum number of combinations of joint solutions that are tried, the nearest first."""

REDUNDANT = 4
"""Factor of both numbers for a robot with a moving base, which may stand in many places."""

SAME = 0.05
"""Joints that differ by less than this (rad or m) are the same solution."""


def goal_of(space: Space, start: Waypoint, rng: np.random.Generator) -> Waypoint:
    """The point at the end of a space, reached along the straight path or in any other way.

    Raises:
        PlanningError: A tool cannot reach it.
    """
    point = start
    for point in space.line(start, space.end):  # noqa: B007  # the last one is wanted
        pass
    if not point.off.late:
        return point
    joints = dict(point.posture.joints)
    for part in space.parts:
        if isinstance(part, Carried):
            for name, aim in part.aims(part.end).items():
                joints[name] = _solve(part.arms[name], aim, start.posture.joints[name], rng)
    return Waypoint(space.end, space.posture(joints))


def ends(
    parts: Sequence[Subspace], goals: Mapping[str, Pose], rng: np.random.Generator
) -> Iterator[Space]:
    """Spaces for the different joint solutions at the goals, the nearest first.

    Args:
        parts: The moving parts; the ends of jointed parts with a goal are not determined yet.
        goals: Goals of the tools of jointed parts whose end is open, in the world.
        rng: Generator of start points of inverse kinematics.

    Raises:
        PlanningError: A tool cannot reach its goal.
    """
    near: list[Subspace] = []
    for part in parts:
        if isinstance(part, Jointed) and part.reach.name in goals:
            goal = goals[part.reach.name]
            end = _solve(part.reach, goal, part.begin, rng)
            near.append(Jointed(part.reach, part.begin, end))
        else:
            near.append(part)
    yield Space(near)
    if not goals:
        return
    choices = [
        _branches(part, goals[part.reach.name], rng)
        if isinstance(part, Jointed) and part.reach.name in goals
        else [part]
        for part in near
    ]
    spaces = [Space(choice) for choice in product(*choices)]
    spaces.sort(key=lambda space: space.length([space.begin, space.end]))
    nearest = Space(near).end
    most = max(_factor(part) for part in near) * MOST_ENDS
    yield from islice((space for space in spaces if space.end != nearest), most)


def _factor(part: Subspace) -> int:
    return REDUNDANT if isinstance(part, Jointed) and part.reach.arm.robot.chain.base else 1


def _branches(part: Jointed, goal: Pose, rng: np.random.Generator) -> list[Subspace]:
    """An arm with each of the joint solutions for its goal."""
    solutions: list[ArmJoints] = [part.end]
    chain, arm = part.reach.arm.robot.chain, part.reach.arm
    for _ in range(_factor(part) * BRANCHES):
        (beginning,) = beginnings_of(chain, rng, 1).tolist()
        result = solve(chain, arm.base_from_world @ goal, start=beginning, rng=rng, attempts=1)
        if result.ok:
            joints = _wound(part.reach, result.joints, part.begin)
            if all(_distance(joints, other) > SAME for other in solutions):
                solutions.append(joints)
    return [Jointed(part.reach, part.begin, joints) for joints in solutions]


def _wound(reach: Reach, joints: Sequence[float], near: Sequence[float]) -> ArmJoints:
    """The same configuration with each revolute joint on the nearest full turn within limits."""
    ik = reach.arm.ik
    turn = 2.0 * math.pi
    wound = []
    for joint, to, turns, low, high in zip(joints, near, ik.turns, ik.lower, ik.upper, strict=True):
        best = joint + turn * round((to - joint) / turn) if turns else joint
        wound.append(best if low <= best <= high else joint)
    return tuple(wound)


def _distance(one: Sequence[float], other: Sequence[float]) -> float:
    return max(abs(a - b) for a, b in zip(one, other, strict=True))


def _solve(reach: Reach, aim: Pose, start: Sequence[float], rng: np.random.Generator) -> ArmJoints:
    """Joint positions that bring a tool to a pose in the world.

    Raises:
        PlanningError: There is no solution.
    """
    target = reach.arm.base_from_world @ aim
    solution = solve(reach.arm.robot.chain, target, start=start, rng=rng)
    off = Off(reach.name, solution.position_error_m, solution.angle_error)
    if off.late:
        x, y, z = aim.position
        raise PlanningError(
            reach.name,
            "out of reach",
            f"{reach.name} cannot bring its tool to ({x:.3f}, {y:.3f}, {z:.3f}): the nearest pose "
            f"found is off by {off}",
        )
    return solution.joints
