"""Placement: putting things where their regions say, without overlap.

Things that stand at a position given in another's frame go where the other goes. Each placed
thing, with all that goes with it, is tried up to `TRIES` times.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from taskbuilder.errors import Finding, PlacementError
from taskbuilder.geometry import ORIGIN, Box, Pose, Quat, bounding_box, from_rpy_deg, multiply
from taskbuilder.schema.load import TaskFile
from taskbuilder.schema.placing import Place
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.sim.body import Body
from taskbuilder.sim.contacts import closest_distance
from taskbuilder.world.joint_starts import draw_joints
from taskbuilder.world.robot import Robot
from taskbuilder.world.scene_objects import SceneObject, Site

TRIES = 100
SINK = 0.002
"""Metres that a thing may reach into its surface: Bullet's hulls of meshes are 1 mm too large."""

LIFT = 0.0005
"""Metres above its surface at which a thing is put, to settle from."""

HOLLOW = 0.005
"""Metres above a surface from which on a thing is let down to it; below, it settles."""

STEPS_DOWN = 50
"""Most steps in which it is let down."""

ALOFT = 20.0
"""Metres above each other at which groups are built that are placed in every episode.

Where they touch nothing, a reset has no contacts to restore.
"""

MANY = 50
"""Members of groups from which on a reset settles for `MANY_SETTLE_S` only, to stay fast."""

MANY_SETTLE_S = 1 / 60
"""Enough to come down on a surface; a hundred things take 2 ms for every physics step."""


class PlacementWorld(Protocol):
    """What placement needs of a `World`."""

    @property
    def task(self) -> TaskFile:
        """The task file, where findings are located."""

    @property
    def scene(self) -> SceneSpec:
        """The scene that was built."""

    @property
    def robots(self) -> Mapping[str, Robot]:
        """The agents."""

    @property
    def objects(self) -> Mapping[str, SceneObject]:
        """The bodies that are not robots."""

    @property
    def sites(self) -> Mapping[str, Site]:
        """The named frames without a body."""

    def pose(self, frame: str) -> Pose:
        """The pose of a named frame in the world."""

    def box(self, body: str) -> Box:
        """Bounding box of an object, a part or a site's marker, in its own frame."""

    @property
    def plan(self) -> PlacementPlan:
        """What is placed."""

    @property
    def piled(self) -> Mapping[str, Pose]:
        """Poses of the members of piles, in the frames of their arrangements."""

    def refresh(self) -> None:
        """Clear the cached values."""


def placement_order(scene: SceneSpec) -> tuple[str, ...]:
    """Objects and sites, each after the frame or surface that its position is given in."""
    things = {**scene.objects, **scene.sites}
    order: dict[str, None] = {}

    def visit(name: str) -> None:
        if name in order or name not in things:
            return
        for parent in parents_of(scene, name):
            visit(parent)
        order[name] = None

    for name in things:
        visit(name)
    return tuple(order)


@dataclass(frozen=True)
class PlacementPlan:
    """What is placed in a scene, which is the same in every episode.

    Attributes:
        still: The objects that are where they were built.
        parties: Each placed thing, followed by what stands at positions in its frame.
    """

    still: tuple[str, ...]
    parties: tuple[tuple[str, ...], ...]

    @classmethod
    def of(cls, scene: SceneSpec) -> PlacementPlan:
        """The plan of a scene."""
        moved = _moved(scene)
        return cls(tuple(name for name in scene.objects if name not in moved), _parties(scene))


def place_all(world: PlacementWorld, rng: np.random.Generator) -> None:
    """Draw the joints that start at random, and put every placed thing where its region says.

    Args:
        world: Just restored to how it was built.
        rng: The episode's generator for placement.

    Raises:
        PlacementError: A thing found no free place.
    """
    plan = world.plan
    for thing in world.objects.values():
        draw_joints(thing, rng)
    for name in plan.still:
        if name in world.piled:
            put(world, name)
    settled = list(plan.still)
    for party in plan.parties:
        _place_party(world, party, settled, rng)
        settled += [name for name in party if name in world.objects]


def put(world: PlacementWorld, name: str) -> None:
    """Put a thing with a written position there, in the frame it is given in."""
    thing = world.objects.get(name)
    spec = thing.spec if thing else world.sites[name].spec
    parent = world.pose(spec.frame) if spec.frame != "world" else Pose()
    _move(world, name, parent @ world.piled.get(name, spec.pose))


def put_aloft(world: PlacementWorld, group: str) -> None:
    """Put the frame of a group, which is placed in every episode, where nothing is."""
    number = tuple(world.task.names.groups).index(group)
    _move(world, group, Pose((0.0, 0.0, ALOFT * (number + 1))))


def parents_of(scene: SceneSpec, name: str) -> Iterator[str]:
    """What the position of a thing is given in: its frame and its surface, without parts."""
    spec = scene.objects[name] if name in scene.objects else scene.sites[name]
    references = [spec.frame]
    if spec.place is not None:
        references = [spec.place.frame, spec.place.surface or "world"]
    yield from (reference.partition(".")[0] for reference in references)


def _moved(scene: SceneSpec) -> set[str]:
    """Everything that is placed, or goes with something placed."""
    moved: set[str] = set()
    for name in placement_order(scene):
        spec = scene.objects[name] if name in scene.objects else scene.sites[name]
        if spec.place is not None or moved & set(parents_of(scene, name)):
            moved.add(name)
    return moved


def _parties(scene: SceneSpec) -> tuple[tuple[str, ...], ...]:
    """Each placed thing, followed by what stands at positions in its frame."""
    parties: dict[str, list[str]] = {}
    leader: dict[str, str] = {}
    for name in placement_order(scene):
        spec = scene.objects[name] if name in scene.objects else scene.sites[name]
        if spec.place is not None:
            leader[name] = name
            parties[name] = [name]
        else:
            above = [leader[parent] for parent in parents_of(scene, name) if parent in leader]
            if above:
                leader[name] = above[0]
                parties[above[0]].append(name)
    return tuple(tuple(party) for party in parties.values())


def _place_party(
    world: PlacementWorld, party: tuple[str, ...], settled: list[str], rng: np.random.Generator
) -> None:
    first, *followers = party
    spec = world.scene.objects.get(first) or world.scene.sites[first]
    place = spec.place
    if place is None:
        raise ValueError(f"{first} leads a party but is not placed")
    others = _others(world, settled)
    in_the_way: Counter[str] = Counter()
    for _ in range(TRIES):
        _move(world, first, _sample(world, first, place, rng))
        for name in followers:
            put(world, name)
        obstacle = _obstacle(world, party, others, place)
        if obstacle is None:
            return
        in_the_way[obstacle] += 1
    kind = "objects" if first in world.objects else "sites"
    location = world.task.source.locate(("scene", kind, first, "place"), key=True)
    raise PlacementError([_does_not_fit(first, in_the_way).at(location)])


def _does_not_fit(name: str, in_the_way: Counter[str]) -> Finding:
    (worst, count), *_ = in_the_way.most_common()
    share = "all" if count == TRIES else f"{count}"
    message = (
        f"{TRIES} placements tried, {share} overlap {worst}; enlarge place.size or move its center"
    )
    return Finding("TB305", message, name)


def _sample(world: PlacementWorld, name: str, place: Place, rng: np.random.Generator) -> Pose:
    """A pose drawn from a region, in the world."""
    low = [c - s / 2 for c, s in zip(place.center, place.size, strict=True)]
    high = [c + s / 2 for c, s in zip(place.center, place.size, strict=True)]
    point = rng.uniform(low, high).tolist()
    yaw = float(rng.uniform(*place.yaw_deg))
    turn = multiply(from_rpy_deg((0.0, 0.0, yaw)), from_rpy_deg(place.rpy_deg))
    frame = world.pose(place.frame) if place.frame != "world" else Pose()
    if place.surface is None:
        return frame @ Pose((point[0], point[1], point[2]), turn)
    pose = frame @ Pose((point[0], point[1], 0.0), turn)
    x, y, _ = pose.position
    top = world.box(place.surface).seen_from(world.pose(place.surface)).high[2]
    above = Pose((x, y, top + _lift(world, name, pose.quaternion)), pose.quaternion)
    if any(place.rpy_deg):
        return _lowered(world, name, above, place)
    return _let_down(world, name, above, place.surface)


def _lowered(world: PlacementWorld, name: str, pose: Pose, place: Place) -> Pose:
    """A pose above a surface, lowered to it: corners of a tilted box are below what is in it."""
    owner = world.objects.get((place.surface or "").partition(".")[0])
    if name not in world.objects or owner is None:
        return pose
    body, (x, y, z) = world.objects[name].body, pose.position
    body.place(pose)
    gap = closest_distance(body, owner.body, max(world.box(name).half))
    return Pose((x, y, z - max(0.0, (gap or LIFT) - LIFT)), pose.quaternion)


def _let_down(world: PlacementWorld, name: str, pose: Pose, surface: str) -> Pose:
    """A pose above the highest point of a surface, let down where the surface is hollow there.

    So a thing in a tray is not dropped from the height of its handles. It goes down by the
    distance to whatever is nearest, again and again, and thus through nothing.
    """
    owner = world.objects.get(surface.partition(".")[0])
    if name not in world.objects or owner is None or is_solid(owner):
        return pose
    body, (x, y, z) = world.objects[name].body, pose.position
    bounds = owner.body.bounds()
    deepest = 2.0 * math.hypot(*bounds.half)
    lowest = z - deepest
    for step in range(STEPS_DOWN):
        body.place(Pose((x, y, z), pose.quaternion))
        found = closest_distance(body, owner.body, deepest)
        gap = deepest if found is None else found
        if gap <= (2.0 * LIFT if step else HOLLOW):
            return Pose((x, y, z), pose.quaternion)
        if z <= lowest:
            break
        z = max(z - (gap - LIFT), lowest)
    return pose  # nothing is below it


def is_solid(thing: SceneObject) -> bool:
    """Whether things stand on an object as high as it is: on a box, and not on a mesh of a tray.

    Objects of parts count as solid, too: parts have names, by which they are surfaces.
    """
    shape = thing.spec.shape
    return shape is None or (shape.mesh is None and shape.urdf is None)


def _lift(world: PlacementWorld, name: str, turn: Quat) -> float:
    """How far above a surface the frame of a thing is that stands on it."""
    if name in world.objects:
        return LIFT - world.box(name).seen_from(Pose(ORIGIN, turn)).low[2]
    members = world.task.names.groups.get(name)
    if members is None:
        return 0.0
    first = members[0]
    if first in world.piled:
        return LIFT
    own = world.scene.objects[first].pose.quaternion
    return LIFT - world.box(first).seen_from(Pose(ORIGIN, multiply(turn, own))).low[2]


def _move(world: PlacementWorld, name: str, pose: Pose) -> None:
    if name in world.objects:
        world.objects[name].body.place(pose)
    else:
        _move_site(world.sites[name], pose)
    world.refresh()


def _move_site(site: Site, world_pose: Pose) -> None:
    if site.rides_on:
        return  # its pose is given in what it rides on, and stays
    site.pose = world_pose
    if site.marker is not None:
        site.marker.place(world_pose)


@dataclass(frozen=True)
class _Other:
    """Something that stands where it is while a party is placed."""

    name: str
    body: Body
    box: Box
    is_robot: bool


def _others(world: PlacementWorld, settled: list[str]) -> list[_Other]:
    bodies = [(name, world.objects[name].body, False) for name in settled]
    bodies += [(name, robot.body, True) for name, robot in world.robots.items()]
    return [_Other(name, body, body.occupied(), is_robot) for name, body, is_robot in bodies]


def _obstacle(
    world: PlacementWorld, party: tuple[str, ...], others: list[_Other], place: Place
) -> str | None:
    """The first thing that a party overlaps or comes too near, or None."""
    bodies = [world.objects[name] for name in party if name in world.objects]
    if not bodies:
        return None
    boxes = [thing.body.occupied() for thing in bodies]
    around = bounding_box([corner for box in boxes for corner in (box.low, box.high)])
    near = [other for other in others if _may_meet(around, other.box, place.clearance)]
    holders = {(name or "").partition(".")[0] for name in (place.surface, place.frame)}
    for thing, box in zip(bodies, boxes, strict=True):
        for other in near:
            holds = other.name in {*holders, thing.spec.frame.partition(".")[0]}
            gap = -SINK if holds and not other.is_robot else place.clearance
            if _may_meet(box, other.box, place.clearance) and _too_near(thing, other.body, gap):
                return other.name
    return None


def _may_meet(one: Box, other: Box, gap: float) -> bool:
    """Whether two boxes may be nearer to each other than a gap in metres."""
    return all(
        abs(one.center[i] - other.center[i]) <= one.half[i] + other.half[i] + gap for i in range(3)
    )


def _too_near(thing: SceneObject, other: Body, gap: float) -> bool:
    distance = closest_distance(thing.body, other, within=max(gap, 0.0))
    return distance is not None and distance < gap


def settling_steps(task: TaskFile) -> int:
    """Physics steps of a reset: a control step, or less where there are very many things."""
    timing = task.spec.timing
    if sum(map(len, task.names.groups.values())) < MANY:
        return timing.substeps
    return min(timing.substeps, math.ceil(MANY_SETTLE_S * timing.physics_hz))
