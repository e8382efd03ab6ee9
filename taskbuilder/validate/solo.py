"""Attempts of a single robot at a task, derived from the names in the success condition.

It takes an object and brings it somewhere, or takes an articulated object by a grasp point and
moves it along a joint to either end.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.description.node import walk
from taskbuilder.env.parallel import EnvState, TaskEnv
from taskbuilder.expert.baselines import Baseline, BaselineKind
from taskbuilder.expert.script.joints import displaced
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout.play import resume
from taskbuilder.rollout.players import HoldStill
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.expert import ExpertStage, Repeat, Together, listed, orders_of
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.order import Order
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.task import Task
from taskbuilder.validate.playing import DropAll, UntilDecided, is_decided
from taskbuilder.validate.rest_of_success import RestReferee
from taskbuilder.world.world import World

LIFT_M = 0.2
"""Height in metres to which an object is lifted if it is only taken."""

CLEARANCE_M = 0.02
"""Height in metres above a body at which an object is released."""

WAYPOINTS = 6
"""Number of straight motions in which a grasp point is moved along a joint."""

LEAST_WAY = 0.05
"""Minimum distance from the start to an end of a joint for an attempt, in rad or m."""

ENDLESS = math.pi
"""Distance that a joint without limits is moved, in rad or m."""

_PLACES = ("body", "surface", "site", "frame", "container")


@dataclass(frozen=True)
class Solo:
    """An attempt of a single robot.

    Attributes:
        robot: The robot.
        grasp: The grasp point, such as ``stick.left_end``.
        place: The frame that it brings the object to; "" to lift it only.
        joint: The joint that it moves instead, such as ``chest.hinge``; "" for none.
        by: Distance of the joint, in rad or m.
    """

    robot: str
    grasp: str
    place: str = ""
    joint: str = ""
    by: float = 0.0

    def __str__(self) -> str:
        if self.joint:
            return f"{self.grasp} along {self.joint} by {self.by:+.2f}"
        return f"{self.grasp} to {self.place}" if self.place else f"{self.grasp} up"

    @property
    def baseline(self) -> Baseline:
        """The key of this attempt among the probes."""
        return Baseline(BaselineKind.ALONE, robot=self.robot, attempt=self)

    @property
    def thing(self) -> str:
        """The object."""
        return self.grasp.partition(".")[0]


def named(task: Task) -> tuple[str, ...]:
    """The names in the success condition: objects, parts, sites and frames of robots."""
    references = [
        name
        for node in walk((task.description.success,))
        for kind, name in node.references()
        if kind in _PLACES
    ]
    return tuple(dict.fromkeys(references))


def fetched(task: Task, scene: SceneSpec) -> tuple[str, ...]:
    """The movable objects in the success condition."""
    owners = dict.fromkeys(name.partition(".")[0] for name in named(task))
    return tuple(name for name in owners if name in scene.objects and not scene.objects[name].fixed)


def solos(task: Task, scene: SceneSpec) -> list[Solo]:
    """All attempts.

    Each robot takes each object by each grasp point and brings it to each place, or up. It also
    moves each articulated object by each grasp point along each joint in the success condition.
    """
    places = named(task)
    brought = [
        Solo(robot, f"{thing}.{grasp}", place)
        for robot in scene.robots
        for thing in fetched(task, scene)
        for grasp in scene.objects[thing].grasps
        for place in (*places, "")
        if place.partition(".")[0] not in (thing, robot)
    ]
    moved = [
        Solo(robot, f"{thing}.{grasp}", joint=f"{thing}.{joint.name}", by=by)
        for robot in scene.robots
        for thing, joint in _joints(task)
        for grasp in scene.objects[thing].grasps
        for by in _ways(joint, scene.objects[thing])
    ]
    return brought + moved


def _joints(task: Task) -> Iterator[tuple[str, UrdfJoint]]:
    """The joints in the success condition, each with its object."""
    names = [
        name
        for node in walk((task.description.success,))
        for kind, name in node.references()
        if kind == "joint"
    ]
    for name in dict.fromkeys(names):
        thing, _, joint = name.partition(".")
        asset = task.file.assets.get(thing)
        if isinstance(asset, Urdf):
            yield thing, asset.joint(joint)


def _ways(joint: UrdfJoint, spec: ObjectSpec) -> Iterator[float]:
    """Distances of a joint from its ends at the start, if it is not already there."""
    said = spec.joint(joint.name, turns=joint.type != "prismatic")
    start = said.begin or 0.0
    lower, upper = said.range or (joint.lower, joint.upper)
    for end, endless in ((upper, ENDLESS), (lower, -ENDLESS)):
        way = endless if end is None else end - start
        if abs(way) > LEAST_WAY:
            yield way


def play_solo(expert: Expert, seed: int, solo: Solo, judge: RestReferee | None = None) -> Rollout:
    """Play an attempt twice: once holding on at the end, once letting go.

    Returns one of the two episodes that succeeds, if there is one. Episodes end once their success
    is decided.

    Args:
        expert: The expert of the task's environment.
        seed: Seed of the episode.
        solo: The attempt.
        judge: A second referee of both episodes.
    """
    env = expert.env
    env.reset(seed=seed)
    stages = _stages(env, solo)
    saved: list[tuple[EnvState, Any]] = []
    tried = expert.play(
        seed,
        stages=stages,
        finish=False,
        until_decided=True,
        after_stage=lambda number: (
            saved.append((env.save_state(), judge.memory if judge else None))
            if number == len(stages)
            else None
        ),
        watch=judge,
    )
    if not saved or is_decided(env):
        return tried
    holding = resume(env, UntilDecided(HoldStill()), tried, watch=judge)
    if holding.success:
        return holding
    state, memory = saved[0]
    env.load_state(state)
    if judge:
        judge.memory = memory
    return resume(env, UntilDecided(DropAll()), tried, watch=judge)


def _stages(env: TaskEnv, solo: Solo) -> tuple[ExpertStage, ...]:
    world = env.episode.world
    take = {solo.robot: Order(grasp=solo.grasp)}
    if solo.joint:
        return take, *({solo.robot: order} for order in _along_joint(world, solo))
    if not solo.place:
        return take, {solo.robot: Order(retreat=LIFT_M)}
    above = _clearance(world, solo) if _solid(world, solo.place) else 0.0
    return take, {solo.robot: Order(bring=solo.thing, to=solo.place, above=above)}


def _along_joint(world: World, solo: Solo) -> Iterator[Order]:
    """Orders that move a tool along the path of a grasp point on a joint."""
    urdf = world.task.assets[solo.thing]
    if not isinstance(urdf, Urdf):
        raise TypeError(f"{solo.thing} has no joints")
    joint = urdf.joint(solo.joint.partition(".")[2])
    child, grasp = world.pose(f"{solo.thing}.{joint.child}"), world.pose(solo.grasp)
    link = world.objects[solo.thing].spec.grasps[solo.grasp.partition(".")[2]].link
    rides = link is not None and joint in urdf.moving_joints_above(link)
    for number in range(1, WAYPOINTS + 1):
        # A grasp point that rides on the link has come along by then, each time as far.
        moved = displaced(joint, child, solo.by * (1 if rides else number) / WAYPOINTS)
        offset = grasp.inverse().apply(moved.apply(grasp.position))
        yield Order(reach=solo.grasp, offset=offset, straight=True, touching=(solo.thing,))


def _solid(world: World, place: str) -> bool:
    return place.partition(".")[0] in world.objects


def _clearance(world: World, solo: Solo) -> float:
    """Height above a body's frame at which an object is just above the body."""
    owner = solo.place.partition(".")[0]
    top = world.box(owner).seen_from(world.pose(owner)).high[2]
    low = world.box(solo.thing).seen_from(world.pose(solo.thing)).low[2]
    rise = world.position(solo.thing)[2] - low
    return top + rise + CLEARANCE_M - world.position(solo.place)[2]


# --- initial positions


def first_grasps(stages: Sequence[ExpertStage]) -> dict[str, str]:
    """The robot that first takes each object, by grasp point.

    There are several if several robots take an object in the same stage.
    """
    found: dict[str, str] = {}
    taken: set[str] = set()
    for stage in _each(stages):
        if isinstance(stage, Together):
            continue
        now = {
            order.grasp: robot
            for robot, order in orders_of(stage)
            if isinstance(order, Order)
            and order.grasp
            and order.grasp.partition(".")[0] not in taken
        }
        found |= now
        taken |= {grasp.partition(".")[0] for grasp in now}
    return found


def sharers(stages: Sequence[ExpertStage]) -> dict[str, set[str]]:
    """For each object, the robots that handle it besides the one that takes it.

    They take it in the same stage, carry it together with others, or push it.
    """
    found: dict[str, set[str]] = {}
    holds: dict[str, str] = {}
    for stage in _each(stages):
        if isinstance(stage, Together):
            for robot in stage.together:
                if robot in holds:
                    found.setdefault(holds[robot], set()).update(stage.together)
            continue
        taken = {}
        for robot, told in stage.items():
            for order in listed(told):
                if order.grasp:
                    taken[robot] = order.grasp.partition(".")[0]
        for robot, order in ((r, order) for r, told in stage.items() for order in listed(told)):
            for thing in (*order.touching, *([order.push] if order.push else [])):
                found.setdefault(thing.partition(".")[0], set()).add(robot)
            if order.release:
                holds.pop(robot, None)
        for thing in taken.values():
            takers = {robot for robot, other in taken.items() if other == thing}
            if len(takers) > 1:
                found.setdefault(thing, set()).update(takers)
        holds |= taken
    return found


def _each(
    stages: Sequence[ExpertStage],
) -> Iterator[dict[str, Order | tuple[Order, ...]] | Together]:
    for stage in stages:
        if isinstance(stage, Repeat):
            yield from _each(stage.stages)
        elif isinstance(stage, dict | Together):
            yield stage
