"""What one robot could do alone: take an object and bring it somewhere, as success names them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from taskbuilder.description.node import walk
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.player import Expert
from taskbuilder.expert.rehearsal import rehearse
from taskbuilder.rollout.play import resume
from taskbuilder.rollout.players import HoldStill
from taskbuilder.rollout.record import Rollout
from taskbuilder.spec.expert import ExpertStage, Order, Repeat
from taskbuilder.spec.scene import SceneSpec
from taskbuilder.task import Task
from taskbuilder.validate.playing import DropAll
from taskbuilder.validate.reach import reaches
from taskbuilder.world.world import World

LIFT_M = 0.2
"""How far something is lifted where it is only to be taken."""

CLEARANCE_M = 0.02
"""How far above a body something is brought that is to be let go there."""

_PLACES = ("body", "surface", "site", "frame", "container")


@dataclass(frozen=True)
class Solo:
    """Something that one robot tries alone.

    Attributes:
        robot: Who.
        grasp: Grasp point that it takes, as ``stick.left_end``.
        place: Frame that it brings the object to; "" to lift it only.
    """

    robot: str
    grasp: str
    place: str = ""

    @property
    def name(self) -> str:
        """What is tried, in words."""
        where = f"to {self.place}" if self.place else "up"
        return f"{self.robot} alone, {self.grasp} {where}"

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
    """Everything to try: each robot, each grasp of each object, each place, and up."""
    places = named(task)
    return [
        Solo(robot, f"{thing}.{grasp}", place)
        for robot in scene.robots
        for thing in fetched(task, scene)
        for grasp in scene.objects[thing].grasps
        for place in (*places, "")
        if place.partition(".")[0] not in (thing, robot)
    ]


def play_solo(expert: Expert, seed: int, solo: Solo) -> Rollout:
    """Try it: take, bring and hold on; then the same, but let go at the end.

    The better of the two counts.
    """
    env = expert.env
    env.reset(seed=seed)
    saved = []
    tried = expert.play(
        seed,
        stages=_stages(env, solo),
        finish=False,
        after_stage=lambda number: saved.append(env.save_state()) if number == 2 else None,
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
    if not solo.place:
        return take, {solo.robot: Order(retreat=LIFT_M)}
    above = _clearance(world, solo) if _solid(world, solo.place) else 0.0
    return take, {solo.robot: Order(bring=solo.thing, to=solo.place, above=above)}


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
        now = {
            order.grasp: robot
            for robot, order in stage.items()
            if order.grasp and order.grasp.partition(".")[0] not in taken
        }
        found |= now
        taken |= {grasp.partition(".")[0] for grasp in now}
    return found


def _each(stages: Sequence[ExpertStage]) -> Iterator[dict[str, Order]]:
    for stage in stages:
        if isinstance(stage, Repeat):
            yield from _each(stage.stages)
        elif isinstance(stage, dict):
            yield stage


def within_reach(world: World, robot: str, grasp: str) -> bool:
    """Whether a robot could take an object by a grasp point where it is now."""
    asked = list(rehearse(world, [{robot: Order(grasp=grasp)}]))
    arm = world.robots[robot]
    return bool(asked) and all(any(reaches(arm, pose) for pose in one.choices) for one in asked)
