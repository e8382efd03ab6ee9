"""The whole scene as channels: for agents with ``observe="scene"``, and for centralised critics.

Everything that a reset can move or turn is in both. A fixed object is left out where no reset moves
it, and where a site or a grasp point in the same list tells where it is.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from taskbuilder.schema.channels import GRIPPER_QUANTITIES
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.sites import SiteSpec
from taskbuilder.world.placement import parents_of, placement_order
from taskbuilder.world.world import World

APART_M = 0.01
"""Horizontal distance of two points from which on they tell how an object is turned."""


def surroundings(agent: str, world: World) -> tuple[str, ...]:
    """Channels of the whole scene for one agent: itself first, then the others in file order.

    The agent is named "self", as in task files, so that noise on a channel applies here too. Grasp
    points and sites are also given in the frame of the agent's tool.
    """
    robots = ("self", *(name for name in world.robots if name != agent))
    grasps = [
        f"{name}.{key}"
        for name, obj in world.objects.items()
        for key, grasp in obj.spec.grasps.items()
        if name in world.movable or grasp.link is not None
    ]
    points = (*grasps, *world.task.names.sites)
    return (
        *_of_robots({"self": agent} | {name: name for name in robots[1:]}, ("tcp",), world),
        *(f"{name}.pose" for name in world.movable),
        *_drawn_places(world, points),
        *(f"{point}.position in self.tcp" for point in points),
        *_moving_joints(world),
        *(f"{site}.position" for site in world.task.names.sites),
        "time_left",
    )


def everything(world: World) -> tuple[str, ...]:
    """All channels of numbers, for a centralised critic."""
    robots = {name: name for name in world.robots}
    sites = world.task.names.sites
    return (
        *_of_robots(robots, ("joints", "joint_velocities", "tcp"), world),
        *(f"{name}.{quantity}" for name in world.movable for quantity in ("pose", "velocity")),
        *_drawn_places(world, tuple(sites)),
        *_moving_joints(world),
        *(f"{site}.position" for site in sites),
        "time_left",
    )


def _of_robots(robots: Mapping[str, str], own: Sequence[str], world: World) -> Iterator[str]:
    """Channels of robots, and those of their grippers.

    Args:
        robots: What channels call each robot, and its name.
        own: Quantities that every robot has.
        world: The world.
    """
    handless = world.task.names.handless
    for called, name in robots.items():
        of_gripper = () if name in handless else GRIPPER_QUANTITIES
        yield from (f"{called}.{quantity}" for quantity in (*own, *of_gripper))


def _moving_joints(world: World) -> list[str]:
    return [
        f"{name}.{joint}"
        for name, obj in world.objects.items()
        for joint, info in obj.body.joints.items()
        if info.type != "fixed" and joint not in obj.mimics
    ]


# --- what is placed at random and then stands still


def _drawn_places(world: World, points: Sequence[str]) -> Iterator[str]:
    """Channels of fixed objects and sites that a reset moves or turns.

    The layout is the same in all variations of a task.

    Args:
        world: The world, as it was built.
        points: Grasp points and sites whose positions are observed besides.
    """
    drawn = Drawn.of(world.task.scenes)
    for party in world.plan.parties:
        leader, *_ = party
        if leader in world.task.names.sites and leader in drawn.turned:
            yield f"{leader}.orientation"
        fixed = [name for name in party if name in drawn.moved and _is_fixed(world, name)]
        if fixed and not _located(world, party, drawn, points):
            for name in fixed:
                yield f"{name}.{'pose' if name in drawn.turned else 'position'}"


@dataclass(frozen=True)
class Drawn:
    """Objects and sites that a reset puts elsewhere, in at least one variation of a task.

    Attributes:
        moved: Those whose position a reset draws.
        turned: Those whose orientation a reset draws.
    """

    moved: Collection[str]
    turned: Collection[str]

    @classmethod
    def of(cls, scenes: Sequence[SceneSpec]) -> Drawn:
        """What is drawn in the variations of a task."""
        moved: set[str] = set()
        turned: set[str] = set()
        for scene in scenes:
            for name in placement_order(scene):
                spec = scene.objects[name] if name in scene.objects else scene.sites[name]
                parents = set(parents_of(scene, name))
                if parents & (moved | turned) or (spec.place and any(spec.place.size)):
                    moved.add(name)
                if _frame_of(spec) in turned or _turns(spec):
                    turned.add(name)
        return cls(moved, turned)


def _turns(spec: ObjectSpec | SiteSpec) -> bool:
    return spec.place is not None and spec.place.yaw_deg[0] != spec.place.yaw_deg[1]


def _frame_of(spec: ObjectSpec | SiteSpec) -> str:
    """What the position of a thing is given in, without the part or link."""
    return (spec.place or spec).frame.partition(".")[0]


def _located(world: World, party: Sequence[str], drawn: Drawn, points: Sequence[str]) -> bool:
    """Whether points that move with a party tell where it is and how it is turned.

    One point does for a party that never turns. One that is turned about the vertical needs two
    points that are not above each other. Nothing does for one that is turned about another axis.
    """
    on_it = [
        world.position(point)
        for point in points
        if (owner := point.partition(".")[0]) in party and _stands(world, owner)
    ]
    if party[0] not in drawn.turned:
        return bool(on_it)
    if _frame_of(_spec(world, party[0])) != "world":
        return False
    return any(math.dist(a[:2], b[:2]) > APART_M for a in on_it for b in on_it)


def _stands(world: World, name: str) -> bool:
    """Whether a thing stays where a reset put it: a fixed object, or a site that rides on none."""
    if name in world.objects:
        return _is_fixed(world, name)
    riding = world.sites[name].rides_on if name in world.sites else None
    return name in world.sites and (riding is None or _stands(world, riding.partition(".")[0]))


def _is_fixed(world: World, name: str) -> bool:
    return name in world.objects and world.objects[name].spec.fixed


def _spec(world: World, name: str) -> ObjectSpec | SiteSpec:
    return world.objects[name].spec if name in world.objects else world.sites[name].spec
