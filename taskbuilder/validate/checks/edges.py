"""Whether what is placed on a surface stays on it: regions that reach over an edge, and falls."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from taskbuilder.assets.model import Urdf
from taskbuilder.geometry import ORIGIN, Pose, Vec3, conjugate, dot, norm, rotate, to_rpy_deg
from taskbuilder.schema.placing import Place
from taskbuilder.sim.contacts import closest_distance
from taskbuilder.world.inertias import misplaced_centers
from taskbuilder.world.placement import is_solid
from taskbuilder.world.world import World

OVER_M = 0.001
"""What a region may reach over an edge: sums of decimals are not exact."""

LEVEL_M = 0.02
"""How much lower or higher something beside a surface may be that bears what is placed there."""

DROP_M = 0.005
TILT_DEG = 2.0
"""From which on an object has fallen, or tips; after a reset all of the library are below 1.1 mm
and 0.3°."""

MARGIN_M = 0.01
"""Distance from the edges at which a region ends that is suggested."""

_STEP_M = 0.001
_TOUCHING_M = 0.002
_SETTLE_S, _STILL = 3.0, 0.02  # m/s and rad/s: what is slower lies still


@dataclass(frozen=True)
class Overhang:
    """A region that reaches over an edge.

    Attributes:
        by: How far the region reaches beyond the surface, in metres.
        surface: The surface.
        within: Centre and size of the part of the region that is on the surface; None if there is
            none, or if it lies askew on the surface.
    """

    by: float
    surface: str
    within: tuple[tuple[float, float], tuple[float, float]] | None

    def __str__(self) -> str:
        text = f"the region reaches {self.by * 100:.1f} cm over the edge of {self.surface}"
        if self.within is None:
            return f"{text}; move its center, or make it smaller"
        center, size = (f"[{x:g}, {y:g}]" for x, y in self.within)
        return f"{text}; on it, the largest is center: {center}, size: {size}"


def overhang(world: World, name: str, place: Place) -> Overhang | None:
    """How far the region of a placed thing reaches over an edge of its surface now.

    The surface is taken for its bounding box, so what is found certainly has nothing below it.
    Corners of the region at which something else stands as high beside the surface do not count.
    """
    if place.surface is None:
        return None
    frame = world.pose(place.frame) if place.frame != "world" else Pose()
    surface, box = world.pose(place.surface), world.box(place.surface)
    into = surface.inverse() @ frame
    top = box.seen_from(surface).high[2]
    # The frame of a thing may be beside its middle, which its yaw takes around.
    loose = _middle(world, name, place)
    most = 0.0
    for point in _corners(place):
        x, y, _ = into.apply(point)
        out = [max(box.low[i] - value, value - box.high[i], 0.0) for i, value in enumerate((x, y))]
        if not _borne(world, name, place.surface, frame.apply(point), top):
            most = max(most, math.hypot(*out) - loose)
    if most <= OVER_M:
        return None
    ends = [into.inverse().apply(corner) for corner in (box.low, box.high)]
    straight = abs(dot(into.axis(0), (1.0, 0.0, 0.0))) > 1.0 - 1e-9
    return Overhang(most, place.surface, _shared(place, ends) if straight else None)


@dataclass(frozen=True)
class Upset:
    """An object that does not stand as it was placed.

    Attributes:
        surface: What it was placed on.
        tilt_deg: By how much it is tilted there; None if it is no longer on it.
    """

    surface: str
    tilt_deg: float | None

    def __str__(self) -> str:
        if self.tilt_deg is None:
            return f"fell from {self.surface}"
        return f"tilted by {self.tilt_deg:.0f}° on {self.surface}"


def upset(world: World, name: str, place: Place) -> Upset | None:
    """How an object that was placed on a surface fell or tilted; None if it stands."""
    if place.surface is None or name not in world.objects or world.objects[name].spec.fixed:
        return None
    at, box = world.pose(name), world.box(name)
    bears = world.box(place.surface).seen_from(world.pose(place.surface))
    owner = world.objects.get(place.surface.partition(".")[0])
    # In a tray, it stands below the highest point of the tray, and touches it.
    hollow = owner is not None and not is_solid(owner)
    top = bears.low[2] if hollow else bears.high[2]
    up: Vec3 = (0.0, 0.0, 1.0)
    wanted = Pose.from_rpy_deg(ORIGIN, place.rpy_deg)
    cosine = dot(rotate(conjugate(at.quaternion), up), wanted.inverse().apply(up))
    tilt = math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
    # Corners of a tilted box are below what is in it, so its middle and its contact count.
    middle = at.apply(box.center)[2]
    sunk = hollow or top - box.seen_from(at).low[2] > DROP_M
    if middle < top or (sunk and not _touches(world, name, place.surface)):
        return Upset(place.surface, None)
    return Upset(place.surface, tilt) if tilt > TILT_DEG else None


def _touches(world: World, name: str, surface: str) -> bool:
    owner = world.objects.get(surface.partition(".")[0])
    body = world.objects[name].body
    return owner is not None and closest_distance(body, owner.body, _TOUCHING_M) is not None


def standing(world: World, name: str, place: Place) -> str:
    """How an object that tilts on its surface is to be placed so that it lies still, in words.

    The world is stepped, so its episode is over.

    Args:
        world: The world, after a reset.
        name: The object, which is tilted.
        place: Where it was placed.
    """
    asset, spec = world.task.assets.get(name), world.scene.objects[name]
    if isinstance(asset, Urdf) and not (spec.density or spec.inertia):
        for link, off in misplaced_centers(asset):
            return (
                f"the centre of mass that the URDF gives {link} is {off * 1000:.0f} mm from that "
                "of its shape; unless it is really there, write inertia: shape for the object"
            )
    for _ in range(math.ceil(_SETTLE_S * world.spec.timing.control_hz)):
        world.step()
    moves = world.objects[name].body.velocity()
    found = upset(world, name, place)
    if found is None or found.tilt_deg is None or max(map(norm, moves)) > _STILL:
        return (
            "its shape does not bear it in that orientation; write another rpy_deg under place, "
            "such as that which taskbuilder objects check says"
        )
    frame = world.pose(place.frame) if place.frame != "world" else Pose()
    roll, pitch, _ = to_rpy_deg((frame.inverse() @ world.pose(name)).quaternion)
    rpy = f"[{round(roll, 1) + 0.0:g}, {round(pitch, 1) + 0.0:g}, {place.rpy_deg[2]:g}]"
    return f"it comes to lie with rpy_deg: {rpy}, so write that under place"


def _corners(place: Place) -> Iterator[Vec3]:
    (x, y), (width, depth) = place.center[:2], place.size[:2]
    for across in (-0.5, 0.5):
        for along in (-0.5, 0.5):
            yield x + across * width, y + along * depth, 0.0


def _middle(world: World, name: str, place: Place) -> float:
    """Distance of the middle of a thing from its frame, seen from above."""
    if name not in world.objects:
        return 0.0
    box = world.box(name).seen_from(Pose.from_rpy_deg(ORIGIN, place.rpy_deg))
    return math.hypot(box.center[0], box.center[1])


def _borne(world: World, name: str, surface: str, point: Vec3, top: float) -> bool:
    """Whether something beside a surface is as high as it at a point of the world."""
    owner = surface.partition(".")[0]
    others = [other for other in world.objects if other not in (name, owner)]
    boxes = world.objects[owner].boxes if owner in world.objects else {}
    others += [part for key in boxes if (part := f"{owner}.{key}") != surface]
    for other in others:
        seen = world.box(other).seen_from(world.pose(other))
        over = all(seen.low[i] <= point[i] <= seen.high[i] for i in (0, 1))
        if over and abs(seen.high[2] - top) <= LEVEL_M:
            return True
    return False


def _shared(
    place: Place, ends: list[Vec3]
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Centre and size of the part of a region that is on a rectangle, in whole millimetres."""
    spans = []
    for i in (0, 1):
        low = max(place.center[i] - place.size[i] / 2, min(e[i] for e in ends) + MARGIN_M)
        high = min(place.center[i] + place.size[i] / 2, max(e[i] for e in ends) - MARGIN_M)
        low = math.ceil(low / _STEP_M - 1e-6) * _STEP_M
        high = math.floor(high / _STEP_M + 1e-6) * _STEP_M
        if low > high:
            return None
        spans.append((low, high))
    (x, width), (y, depth) = ((round((a + b) / 2, 4), round(b - a, 4)) for a, b in spans)
    return (x, y), (width, depth)
