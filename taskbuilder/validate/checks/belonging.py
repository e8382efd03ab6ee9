"""Whether what one robot is to fetch starts out of the other robots' reach; of the reach family.

Inverse kinematics names the candidates. Each of them is then tried in some of its episodes: the
robot takes the object in the simulation, so that one under a lid or behind a wall counts as out of
reach. That a planner finds no way takes long, as it then searches to its end.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from taskbuilder.schema.order import Order
from taskbuilder.task import Task
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.locate import finding_in_file
from taskbuilder.validate.reaching import within_reach
from taskbuilder.validate.report import Check, Result
from taskbuilder.validate.solo import fetched, first_grasps, sharers

TRIED = 6
"""The most episodes in which a robot tries to take an object, of those in which it is in reach."""

Pair = tuple[str, str]
"""A robot, and a grasp point of an object that another robot is to fetch."""


def must_cooperate(task: Task) -> bool:
    """Whether a task must need several robots."""
    return task.file.spec.cooperation == "required" and len(task.agents) > 1


def check_belonging(context: Context) -> Iterator[Result]:
    """Warn of objects that a robot could take from the start though another one should."""
    if not (must_cooperate(context.task) and context.has_expert):
        return
    starts = context.some_starts()
    near: dict[Pair, list[Start]] = {}
    answers = context.ask(find_near, starts, "reach, of others")
    for start, pairs in zip(starts, answers, strict=True):
        for pair in pairs:
            near.setdefault(pair, []).append(start)
    tries = sorted(
        (start, pair)
        for pair, where in near.items()
        for start in where[:: math.ceil(len(where) / TRIED)]
    )
    took = context.ask(takes, [start for start, _ in tries], "reach, taking", about=tries)
    found: dict[Pair, list[Start]] = {}
    for (start, pair), taken in zip(tries, took, strict=True):
        if taken:
            found.setdefault(pair, []).append(start)
    findings = []
    for (robot, grasp), where in found.items():
        tried = sum(pair == (robot, grasp) for _, pair in tries)
        message = (
            f"{robot} could take {grasp} at the start of {len(where)} of {tried} episodes "
            f"({where[0]}), which another robot is to take; put it out of reach"
        )
        path = ("scene", "objects", grasp.partition(".")[0])
        findings.append(finding_in_file(context.task, "TB545", message, *path, severity="warning"))
    count = max(map(len, found.values()), default=0)
    name = "objects start out of the others' reach"
    yield Check("TB545", name, True, count, None, "episodes"), findings


# --- in each process


def find_near(cache: EnvCache, start: Start) -> list[Pair]:
    """Robots and grasp points of objects that another robot is to fetch, and that they reach."""
    task, env = cache.task, cache.env(start.variation)
    env.reset(seed=start.seed)
    world = env.episode.world
    things = fetched(task, world.scene)
    stages = task.file.spec.expert
    shared = sharers(stages)
    return [
        (robot, grasp)
        for grasp, taker in first_grasps(stages).items()
        if (thing := grasp.partition(".")[0]) in things
        for robot in task.agents
        if robot not in {taker} | shared.get(thing, set()) and within_reach(world, robot, grasp)
    ]


def takes(cache: EnvCache, job: tuple[Start, Pair]) -> bool:
    """Whether a robot alone takes an object in the simulation."""
    start, (robot, grasp) = job
    done: list[int] = []
    stages = ({robot: Order(grasp=grasp)},)
    expert = cache.expert(start.variation)
    expert.play(start.seed, stages=stages, finish=False, after_stage=done.append)
    return bool(done)
