"""What one robot could do alone, as success names it.

It takes an object and brings it somewhere; or it takes an articulated object by a grasp point and
moves it along a joint, to either end.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.description.node import walk
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.script.dry_run import dry_run
from taskbuilder.expert.script.foresight import displaced
from taskbuilder.expert.script.player import Expert
from taskbuilder.expert.ways import Kind, Way
from taskbuilder.rollout.play import resume
from taskbuilder.rollout.players import HoldStill
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.expert import ExpertStage, Order, Repeat, Together
from taskbuilder.schema.robots import joint_values
from taskbuilder.schema.scene import ObjectSpec, SceneSpec
from taskbuilder.task import Task
from taskbuilder.validate.playing import DropAll
from taskbuilder.validate.reach import reaches
from taskbuilder.world.world import World

LIFT_M = 0.2
"""How far something is lifted where it is only to be taken."""

CLEARANCE_M = 0.02
"""How far above a body something is brought that is to be let go there."""

WAYPOINTS = 6
"""In how many straight motions a grasp point is moved along a joint."""

LEAST_WAY = 0.05
"""How far from the start the end of a joint is to be worth a try, in rad or m."""

ENDLESS = math.pi
"""How far a joint is turned, or slid, that has no end."""

_PLACES = ("body", "surface", "site", "frame", "container")


@dataclass(frozen=True)
class Solo:
    """Something that one robot tries alone.

    Attributes:
        robot: Who.
        grasp: Grasp point that it takes, as ``stick.left_end``.
        place: Frame that it brings the object to; "" to lift it only.
        joint: Joint that it moves instead, as ``chest.hinge``; "" for none.
        by: How far, in rad or m.
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
    def way(self) -> Way:
        """The way of playing that tries it."""
        return Way(Kind.ALONE, robot=self.robot, attempt=self)

    @property
    def thing(self) -> str:
        """The object."""
        return self.grasp.partition(".")[0]


def named(task: Task) -> tuple[str, ...]:
    """What the success condition names: objects, parts, sites and frames of robots."""
    references = [
        name
        for node in walk((task.description.success,))
        for kind, name in node.references()
        if kind in _PLACES
    ]
    return tuple(dict.fromkeys(references))


def fetched(task: Task, scene: SceneSpec) -> tuple[str, ...]:
    """The movable objects that the success condition names."""
    owners = dict.fromkeys(name.partition(".")[0] for name in named(task))
    return tuple(name for name in owners if name in scene.objects and not scene.objects[name].fixed)


def solos(task: Task, scene: SceneSpec) -> list[Solo]:
    """Everything to try.

    Each robot takes each object by each grasp and brings it to each place, and up; and it moves
    each articulated object by each grasp along each joint that success names.
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
    """The joints that the success condition names, each with its object."""
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
    """How far a joint is from each of its ends at the start, where it is away from it."""
    (start,) = joint_values([joint], [spec.joints.get(joint.name, 0.0)])
    for end, endless in ((joint.upper, ENDLESS), (joint.lower, -ENDLESS)):
        way = endless if end is None else end - start
        if abs(way) > LEAST_WAY:
            yield way


def play_solo(expert: Expert, seed: int, solo: Solo) -> Rollout:
    """Try it: take, bring and hold on; then the same, but let go at the end.

    The better of the two counts.
    """
    env = expert.env
    env.reset(seed=seed)
    stages = _stages(env, solo)
    saved = []
    tried = expert.play(
        seed,
        stages=stages,
        finish=False,
        after_stage=lambda number: (
            saved.append(env.save_state()) if number == len(stages) else None
        ),
    )
    if not saved or tried.success:
        return tried
    holding = resume(env, HoldStill(), tried)
    if holding.exploded:
        return holding
    env.load_state(saved[0])
    letting_go = resume(env, DropAll(), tried)
    return max(holding, letting_go, key=lambda play: (play.success, play.team_return))


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
    """Orders that move a tool with a grasp point along a joint."""
    urdf = world.task.assets[solo.thing]
    if not isinstance(urdf, Urdf):
        raise TypeError(f"{solo.thing} has no joints")
    joint = urdf.joint(solo.joint.partition(".")[2])
    child, grasp = world.pose(f"{solo.thing}.{joint.child}"), world.pose(solo.grasp)
    for number in range(1, WAYPOINTS + 1):
        moved = displaced(joint, child, solo.by * number / WAYPOINTS)
        offset = grasp.inverse().apply(moved.apply(grasp.position))
        yield Order(reach=solo.grasp, offset=offset, straight=True, touching=(solo.thing,))


def _solid(world: World, place: str) -> bool:
    return place.partition(".")[0] in world.objects


def _clearance(world: World, solo: Solo) -> float:
    """How far above a body's frame an object must be brought to be just above the body."""
    owner = solo.place.partition(".")[0]
    top = world.box(owner).seen_from(world.pose(owner)).high[2]
    low = world.box(solo.thing).seen_from(world.pose(solo.thing)).low[2]
    rise = world.position(solo.thing)[2] - low
    return top + rise + CLEARANCE_M - world.position(solo.place)[2]


# --- where things start


def first_grasps(stages: Sequence[ExpertStage]) -> dict[str, str]:
    """For each grasp point by which an object is first taken: the robot that takes it.

    Several where several robots take an object in the same stage.
    """
    found: dict[str, str] = {}
    taken: set[str] = set()
    for stage in _each(stages):
        if isinstance(stage, Together):
            continue
        now = {
            order.grasp: robot
            for robot, order in stage.items()
            if order.grasp and order.grasp.partition(".")[0] not in taken
        }
        found |= now
        taken |= {grasp.partition(".")[0] for grasp in now}
    return found


def sharers(stages: Sequence[ExpertStage]) -> dict[str, set[str]]:
    """For each object, the robots that have a part in it beside the one that takes it.

    They take it in the same stage as others or carry it together with them; or they push it.
    """
    found: dict[str, set[str]] = {}
    holds: dict[str, str] = {}
    for stage in _each(stages):
        if isinstance(stage, Together):
            for robot in stage.together:
                if robot in holds:
                    found.setdefault(holds[robot], set()).update(stage.together)
            continue
        taken = {r: o.grasp.partition(".")[0] for r, o in stage.items() if o.grasp}
        for robot, order in stage.items():
            for thing in order.touching:
                found.setdefault(thing.partition(".")[0], set()).add(robot)
            if order.release:
                holds.pop(robot, None)
        for thing in taken.values():
            takers = {robot for robot, other in taken.items() if other == thing}
            if len(takers) > 1:
                found.setdefault(thing, set()).update(takers)
        holds |= taken
    return found


def _each(stages: Sequence[ExpertStage]) -> Iterator[dict[str, Order] | Together]:
    for stage in stages:
        if isinstance(stage, Repeat):
            yield from _each(stage.stages)
        elif isinstance(stage, dict | Together):
            yield stage


def within_reach(world: World, robot: str, grasp: str) -> bool:
    """Whether a robot could take an object by a grasp point where it is now."""
    asked = list(dry_run(world, [{robot: Order(grasp=grasp)}]))
    arm = world.robots[robot]
    return bool(asked) and all(any(reaches(arm, pose) for pose in one.choices) for one in asked)
