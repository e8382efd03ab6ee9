"""A demonstration as it is cut and moved: tools, grippers and things at every control step."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from taskbuilder.data.dataset import RecordedEpisode
from taskbuilder.description.description import Description
from taskbuilder.description.node import Condition, walk
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.planning.reach import Reach
from taskbuilder.geometry import Pose, turn_between
from taskbuilder.rollout.play import play
from taskbuilder.rollout.players import RecordedActions
from taskbuilder.world.world import World

GRIPPING_S = 0.6
"""How long a gripper may take to close or open, in seconds."""

MOVED_M, MOVED_RAD = 5e-4, math.radians(0.5)
"""What moves less stands still."""


@dataclass(frozen=True)
class Milestone:
    """A stage of the description that a demonstration reached.

    Attributes:
        step: Control steps before it.
        frames: The objects and sites that its condition names.
    """

    step: int
    frames: tuple[str, ...]


@dataclass(frozen=True)
class ReplayedDemonstration:
    """An episode that was played again, to see where everything is.

    All lists have an entry for the state after the reset, and one for each control step.

    Attributes:
        name: Name of the episode.
        variation: Number of its variation.
        tools: Commanded pose in the world of each robot's tool.
        openings: Commanded opening of each robot's gripper, from 0 to 1.
        held: The object, or link of an articulated one, that each robot holds; or "".
        frames: Pose in the world of each object, link of an articulated object, and site.
        milestones: The stages of the description, in order.
        stage_ends: Control step at the end of each stage of the expert; empty if none is labelled.
    """

    name: str
    variation: int
    tools: Mapping[str, Sequence[Pose]]
    openings: Mapping[str, Sequence[float]]
    held: Mapping[str, Sequence[str]]
    frames: Mapping[str, Sequence[Pose]]
    milestones: tuple[Milestone, ...]
    stage_ends: tuple[int, ...]

    @property
    def steps(self) -> int:
        """Its length in control steps."""
        return len(next(iter(self.tools.values()))) - 1

    @property
    def robots(self) -> tuple[str, ...]:
        """The robots."""
        return tuple(self.tools)


def demonstration_of(env: TaskEnv, episode: RecordedEpisode) -> ReplayedDemonstration:
    """Play an episode of a data set again; pauses of people are left out.

    Args:
        env: The environment of its variation.
        episode: The episode.
    """
    watch = _PoseRecorder()
    rollout = play(env, RecordedActions(episode.actions), episode.seed, watch=watch)
    description = env.task.description
    demonstration = ReplayedDemonstration(
        name=episode.name,
        variation=episode.variation,
        tools=watch.tools,
        openings=watch.openings,
        held=watch.held,
        frames=watch.frames,
        milestones=tuple(_milestones(description, rollout.reached, watch.frames)),
        stage_ends=tuple(_stage_ends(episode, len(env.task.file.spec.expert))),
    )
    if not episode.operators:
        return demonstration
    gripping = math.ceil(GRIPPING_S * env.task.file.spec.timing.control_hz)
    return without_pauses(demonstration, gripping)


def without_pauses(demonstration: ReplayedDemonstration, gripping: int) -> ReplayedDemonstration:
    """A demonstration without the control steps in which nothing moves.

    Args:
        demonstration: The demonstration.
        gripping: Control steps that are kept after a gripper was told to move.
    """
    kept, told = [0], -gripping
    for step in range(1, demonstration.steps + 1):
        openings = demonstration.openings.values()
        if any(each[step] != each[step - 1] for each in openings):
            told = step
        things = (*demonstration.tools.values(), *demonstration.frames.values())
        moves = any(_moved(each[kept[-1]], each[step]) for each in things)
        if moves or step - told < gripping or step == demonstration.steps:
            kept.append(step)

    def cut(values: Mapping[str, Sequence[Any]]) -> dict[str, list[Any]]:
        return {name: [each[step] for step in kept] for name, each in values.items()}

    return replace(
        demonstration,
        tools=cut(demonstration.tools),
        openings=cut(demonstration.openings),
        held=cut(demonstration.held),
        frames=cut(demonstration.frames),
        milestones=tuple(
            replace(each, step=bisect_left(kept, each.step)) for each in demonstration.milestones
        ),
        stage_ends=tuple(bisect_left(kept, end) for end in demonstration.stage_ends),
    )


def _moved(before: Pose, after: Pose) -> bool:
    turn = turn_between(before.quaternion, after.quaternion)
    return math.dist(before.position, after.position) > MOVED_M or turn > MOVED_RAD


class _PoseRecorder:
    """Notes where everything is, after the reset and after each control step."""

    def __init__(self) -> None:
        self.tools: dict[str, list[Pose]] = {}
        self.openings: dict[str, list[float]] = {}
        self.held: dict[str, list[str]] = {}
        self.frames: dict[str, list[Pose]] = {}
        self._reaches: dict[str, Reach] = {}
        self._graspable: tuple[str, ...] = ()

    def __call__(self, env: TaskEnv) -> None:
        world = env.episode.world
        if not self._graspable:
            self._graspable = (*world.movable, *_links(world))
        for name, robot in world.robots.items():
            if name not in self._reaches:
                self._reaches[name] = Reach.of(world, name)
            tool = self._reaches[name].tool(tuple(robot.commanded()))
            load = next((each for each in self._graspable if world.held(each, name)), "")
            self.tools.setdefault(name, []).append(tool)
            self.openings.setdefault(name, []).append(robot.gripper.told())
            self.held.setdefault(name, []).append(load)
        for name in (*world.objects, *world.scene.sites, *_links(world)):
            self.frames.setdefault(name, []).append(world.pose(name))


def _links(world: World) -> Iterator[str]:
    """The links of articulated objects, such as ``chest.lid``."""
    for name, obj in world.objects.items():
        yield from (f"{name}.{link}" for link in obj.boxes if obj.joints)


def _milestones(
    description: type[Description], reached: Mapping[str, int], frames: Mapping[str, object]
) -> Iterator[Milestone]:
    for name, step in reached.items():
        named = dict.fromkeys(_owners(description.stages[name]))
        yield Milestone(step, tuple(owner for owner in named if owner in frames))


def _owners(condition: Condition) -> Iterator[str]:
    """The objects, sites and robots that a condition is about."""
    for node in walk((condition,)):
        for _, frame in node.references():
            yield frame.partition(".")[0]


def _stage_ends(episode: RecordedEpisode, stages: int) -> Iterator[int]:
    """The ends of the expert's stages, as far as they were done."""
    for part in episode.subtasks:
        if part["done"] and part["stage"] <= stages:
            yield part["to_step"]
