"""A policy that plays a demonstration in another episode, moved with the things it concerns."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from taskbuilder.arrays import Arrays
from taskbuilder.env.action_encoder import ActionEncoder, Actions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.expert.planning.reach import Reach, between
from taskbuilder.geometry import Pose, norm, subtract, turn_between
from taskbuilder.multiplying.anchors import WORLD, Anchor, anchors_of, holds_of
from taskbuilder.multiplying.demonstration import ReplayedDemonstration
from taskbuilder.rollout.record import ScriptLog

NEAREST = 3
"""The source is drawn from so many demonstrations, those whose things were nearest."""

METRES_PER_RADIAN = 0.1
"""What a radian of an object's turn counts, where sources are compared."""

ARRIVED_M, ARRIVED_RAD = 0.004, math.radians(2.0)
"""At an anchor, a tool that is commanded as near as this to its pose goes on to the next."""

BETWEEN_M, BETWEEN_RAD = 0.04, math.radians(20.0)
"""The same between two anchors, where the path need not be that of the demonstration."""

MOST_WAITS = 12
"""Control steps after which the robots go on although a tool has not arrived."""


class Multiplier:
    """Plays, in each episode, the demonstration whose things lay nearest to those of the episode.

    All robots go on together: to the next control step of the demonstration when every tool has
    arrived at the pose of this one.

    Args:
        demonstrations: The demonstrations.
        env: The environment.

    Raises:
        UsageError: There is no demonstration of the variation of the environment.
    """

    def __init__(self, demonstrations: Sequence[ReplayedDemonstration], env: TaskEnv) -> None:
        sources = [each for each in demonstrations if each.variation == env.episode.variation]
        if not sources:
            raise UsageError(f"no demonstration is of variation {env.episode.variation}")
        self._concerns = {each.name: concerns_of(each) for each in sources}
        self._sources = sources

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Choose the source, and begin with its first control step."""
        self._env, self._encoder = env, ActionEncoder(env)
        rng = np.random.default_rng([seed, 4])  # apart from the generators of the episode
        nearest = sorted(self._sources, key=self._difference)[:NEAREST]
        self._source = nearest[int(rng.integers(len(nearest)))]
        self._clock, self._waits = 0, 0
        self._reached = [0]
        self._paths = {robot: _Path(self._source, robot, env) for robot in self._source.robots}

    def act(self, observations: Mapping[str, Any]) -> Actions:
        """Actions towards the poses of the next control step of the source."""
        ended = self._clock >= self._source.steps
        step = min(self._clock + 1, self._source.steps)
        joints, openings, arrived = {}, {}, True
        for robot, path in self._paths.items():
            joints[robot], there = path.follow(step)
            arrived = arrived and there
            opening = self._source.openings[robot][step]
            if opening != self._source.openings[robot][step - 1] and not self._waits and not ended:
                openings[robot] = opening
        if arrived or self._waits >= MOST_WAITS:
            self._clock, self._waits = step, 0
        else:
            self._waits += 1
        self._reached.append(self._clock)
        return self._encoder.actions(joints, openings)

    def log(self) -> ScriptLog | None:
        """The ends of the expert's stages, moved in time as the demonstration was."""
        ends = self._source.stage_ends
        if not ends:
            return None
        done = [int(np.searchsorted(self._reached, end)) for end in ends if end <= self._clock]
        return ScriptLog(tuple(done))

    def notes(self) -> tuple[Mapping[str, Any], Arrays]:
        """Which demonstration the episode came from."""
        return {"source": self._source.name}, {}

    def _difference(self, source: ReplayedDemonstration) -> float:
        """How far the things of this episode lie from those of a demonstration, in metres."""
        world, concerns = self._env.episode.world, self._concerns[source.name]
        return sum(_apart(world.pose(name), source.frames[name][0]) for name in concerns)


def concerns_of(source: ReplayedDemonstration) -> tuple[str, ...]:
    """The objects and sites that the tools of a demonstration move relative to."""
    anchors = (anchor for robot in source.robots for anchor in anchors_of(source, robot))
    return tuple(dict.fromkeys(each.frame for each in anchors if each.frame != WORLD))


class _Path:
    """The path of a robot's tool: that of a demonstration, moved with its anchors."""

    def __init__(self, source: ReplayedDemonstration, robot: str, env: TaskEnv) -> None:
        self._source, self._robot, self._env = source, robot, env
        self._anchors = anchors_of(source, robot)
        self._holds = holds_of(source, robot)
        self._shifts: dict[Anchor, Pose] = {}
        self._reach = Reach.of(env.episode.world, robot)

    def follow(self, step: int) -> tuple[tuple[float, ...], bool]:
        """The joints that lead to the pose of a control step, and whether they get there."""
        modes = self._env.episode.actions[self._robot]
        start = tuple(modes.commanded_after(self._env.episode.waiting(self._robot)))
        place = self._place(step)
        goal, tool = self._reach.commandable(self._pose(step, *place)), self._reach.tool(start)
        spec = modes.arm.spec
        far = norm(subtract(goal.position, tool.position)) / spec.max_step
        turned = turn_between(tool.quaternion, goal.quaternion) / math.radians(spec.max_turn_deg)
        target = between(tool, goal, 1.0 / max(far, turned, 1.0))
        arm = self._reach.arm
        joints = arm.ik.step(start, arm.base_from_world @ target, self._reach.mode.longest)
        return joints, _is_at(self._reach.tool(joints), goal, at_anchor=place[0] is place[1])

    def _pose(self, step: int, before: Anchor, after: Anchor, share: float) -> Pose:
        """The pose of the tool at a control step of the demonstration, between two anchors."""
        tool = self._source.tools[self._robot][step]
        # Robots that carry an object together must agree on its path, not on those of their tools.
        load = self._load(step)
        moved = self._source.frames[load][step] if load else tool
        here, there = self._shift(before, step) @ moved, self._shift(after, step) @ moved
        place = between(here, there, share * share * (3.0 - 2.0 * share))
        return place @ moved.inverse() @ tool

    def _load(self, step: int) -> str:
        """The object that the robot holds at a control step of the demonstration, or ""."""
        return next((hold.load for hold in self._holds if hold.begin <= step <= hold.end), "")

    def _place(self, step: int) -> tuple[Anchor, Anchor, float]:
        """The anchors around a control step, and how far it is from one to the other, 0 to 1."""
        before = self._anchors[0]
        for anchor in self._anchors:
            if step < anchor.begin:
                return before, anchor, (step - before.end) / (anchor.begin - before.end)
            before = anchor
            if step <= anchor.end:
                break
        return before, before, 0.0

    def _shift(self, anchor: Anchor, step: int) -> Pose:
        """How the frame of an anchor lies here, seen from how it lay in the demonstration."""
        if anchor.frame == WORLD:
            return Pose()
        if anchor in self._shifts:
            return self._shifts[anchor]
        there = self._source.frames[anchor.frame][min(step, self._source.steps)]
        shift = self._env.episode.world.pose(anchor.frame) @ there.inverse()
        if anchor.fixed is not None and step >= anchor.fixed:
            self._shifts[anchor] = shift
        return shift


def _apart(one: Pose, other: Pose) -> float:
    turn = turn_between(one.quaternion, other.quaternion)
    return norm(subtract(one.position, other.position)) + METRES_PER_RADIAN * turn


def _is_at(tool: Pose, goal: Pose, *, at_anchor: bool) -> bool:
    near, turned = (ARRIVED_M, ARRIVED_RAD) if at_anchor else (BETWEEN_M, BETWEEN_RAD)
    gap = norm(subtract(tool.position, goal.position))
    return gap <= near and turn_between(tool.quaternion, goal.quaternion) <= turned
