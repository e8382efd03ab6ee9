"""What the names of a task stand for, drawn over its pictures: frames, grasp points, regions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from taskbuilder.cameras import CameraView
from taskbuilder.errors import UnknownNameError
from taskbuilder.geometry import Box, Pose, Vec3
from taskbuilder.kinematics.chain import Chain
from taskbuilder.schema.bodies import Grasp
from taskbuilder.schema.placing import Place
from taskbuilder.visual.ink import Lens, Marks, Patch, Points, Rgb, Stroke, Tag, drawn_over
from taskbuilder.visual.outlines import outlines
from taskbuilder.visual.still import Still
from taskbuilder.wording import suggestion
from taskbuilder.world.reach import reach_map
from taskbuilder.world.world import World

AXES: tuple[Rgb, Rgb, Rgb] = ((220, 50, 47), (46, 160, 67), (37, 99, 235))
ROBOTS: tuple[Rgb, ...] = (
    (37, 99, 235),
    (234, 118, 32),
    (13, 148, 136),
    (147, 51, 234),
    (219, 39, 119),
    (101, 133, 14),
)
GRASP: Rgb = (190, 24, 93)
SITE: Rgb = (4, 120, 87)
REGION: Rgb = (124, 58, 237)
CAMERA: Rgb = (71, 85, 105)

_AXIS_M, _SHORT_AXIS_M = 0.10, 0.06
_OPENING_M, _FINGER_M, _STEM_M = 0.07, 0.045, 0.05  # of the gripper that shows a grasp point
_ABOVE_M = 0.002  # areas lie this far above their surface
_HIGHER_M = 0.03  # the reach is that at a small object's middle
_REACH_M = 1.2  # where there is no surface, the reach is looked for so far around the bases
_HEIGHTS = (0.0, 0.2, 0.4)  # of the reach of an arm alone, as shares of the room around it
_ALIKE = 6  # members of a group that are named one by one, at most


def check_words(words: Sequence[str]) -> tuple[str, ...]:
    """The things to be drawn, each once.

    Raises:
        UnknownNameError: A word is none of `SHOWN`.
    """
    for word in words:
        if word not in SHOWN:
            help_ = suggestion(word, SHOWN, what="it can show")
            raise UnknownNameError(f'there is no --show "{word}"; {help_}')
    return tuple(dict.fromkeys(words))


class Annotator:
    """Draws over the stills of a world as it stands.

    Args:
        world: Where the pictures are taken.
        words: What to draw, of `SHOWN`.
    """

    def __init__(self, world: World, words: Sequence[str]) -> None:
        self._world = world
        self._words = tuple(words)
        self._known: dict[str, Marks] = {}

    def annotated(self, still: Still, size: tuple[int, int] | None = None) -> Still:
        """A still with everything drawn over its picture.

        Args:
            still: A picture of this world.
            size: Width and height with which it was taken; by default the camera's own.
        """
        view = self._world.camera(still.camera, size)
        image = still.image
        lens = Lens(view.extrinsics, image.intrinsics, image.depth)
        marks = sum((self._marks(word, still.camera) for word in self._words), Marks())
        return replace(still, image=replace(image, rgb=drawn_over(image.rgb, lens, marks)))

    def _marks(self, word: str, camera: str) -> Marks:
        if word in _FOR_EACH_CAMERA:
            return SHOWN[word](self._world, camera)
        if word not in self._known:  # the reach takes its time
            self._known[word] = SHOWN[word](self._world, camera)
        return self._known[word]


def _frames(world: World, camera: str) -> Marks:
    """The axes of every tool, base and object; x is red, y green, z blue."""
    own = world.scene.cameras[camera].mount
    marks = Marks()
    for name in world.robots:
        marks += axes(world.pose(f"{name}.base"), f"{name}.base", _AXIS_M)
        if own != f"{name}.tcp":  # it would fill the picture
            marks += axes(world.pose(f"{name}.tcp"), f"{name}.tcp", _AXIS_M)
    for name in _each(world, world.objects):
        marks += axes(world.pose(name), name, _SHORT_AXIS_M)
    return marks


def axes(pose: Pose, name: str, length: float) -> Marks:
    """The axes of a frame, with its name: x is red, y green, z blue."""
    ends = (pose.apply(_along(index, length)) for index in range(3))
    strokes = tuple(
        Stroke(np.array([pose.position, end]), color, 2.0)
        for end, color in zip(ends, AXES, strict=True)
    )
    return Marks(strokes=strokes, tags=(Tag(name, np.array(pose.position), AXES[2]),))


def _grasps(world: World, camera: str) -> Marks:
    """Every grasp point, as a small gripper that takes hold there."""
    del camera
    marks = Marks()
    for name in _each(world, world.objects):
        for point, grasp in world.objects[name].spec.grasps.items():
            full = f"{name}.{point}"
            frame = world.pose(full)
            strokes = tuple(Stroke(line, GRASP, 2.0) for line in _gripper(frame, grasp))
            marks += Marks(strokes=strokes, tags=(Tag(full, np.array(frame.position), GRASP),))
    return marks


def _gripper(frame: Pose, grasp: Grasp) -> tuple[Points, Points]:
    """The outline of a gripper at a grasp point: the fingers with the palm, and the stem."""
    at = np.array(frame.position)
    approach = _approach(frame, grasp.approach)
    across = np.array(frame.axis("xyz".index(grasp.across)))
    across = across - (across @ approach) * approach
    if np.linalg.norm(across) < 1e-6:  # the fingers cannot close along the approach
        return np.array([at, at]), np.array([at - _STEM_M * approach, at])
    across /= np.linalg.norm(across)
    tip, palm = at + 0.3 * _FINGER_M * approach, at - 0.7 * _FINGER_M * approach
    half = 0.5 * _OPENING_M * across
    fingers = np.array([tip - half, palm - half, palm + half, tip + half])
    return fingers, np.array([palm, palm - _STEM_M * approach])


def _approach(frame: Pose, written: str) -> Points:
    if written == "down":
        return np.array([0.0, 0.0, -1.0])
    sign = 1.0 if written[0] == "+" else -1.0
    return sign * np.array(frame.axis("xyz".index(written[1])))


def _sites(world: World, camera: str) -> Marks:
    """Every site: a ring and a cross, and the edges of its marker if that is a box."""
    del camera
    marks = Marks()
    for name in _each(world, world.sites):
        pose, spec = world.pose(name), world.sites[name].spec
        sphere = spec.marker.sphere if spec.marker else None
        ring = _circle(pose, (sphere or 0.012) + 0.01)
        strokes = (Stroke(ring, SITE, 1.6, closed=True), *_cross(pose))
        if spec.marker is not None and spec.marker.box is not None:
            half = tuple(0.5 * edge for edge in spec.marker.box)
            strokes = _edges(pose, Box((0.0, 0.0, 0.0), (half[0], half[1], half[2])), SITE)
        marks += Marks(strokes=strokes, tags=(Tag(name, np.array(pose.position), SITE),))
    return marks


def _cross(pose: Pose) -> tuple[Stroke, ...]:
    ends = ([pose.apply(_along(i, end)) for end in (-0.03, 0.03)] for i in range(3))
    return tuple(Stroke(np.array(line), SITE, 1.2) for line in ends)


def _regions(world: World, camera: str) -> Marks:
    """Every region in which things are placed at random."""
    del camera
    marks = Marks()
    things = {**world.scene.objects, **world.scene.sites}
    groups = world.task.names.groups
    for name in _each(world, things):
        if (place := things[name].place) is not None:
            owner = next((group for group, members in groups.items() if name in members), name)
            marks += _region(world, owner, place)
    return marks


def _region(world: World, name: str, place: Place) -> Marks:
    frame = world.pose(place.frame) if place.frame != "world" else Pose()
    flat = Pose.from_rpy_deg((place.center[0], place.center[1], 0.0), (0.0, 0.0, 0.0))
    half = tuple(0.5 * side for side in place.size)
    tag = f"{name}: region"
    if place.surface is None:
        pose = frame @ Pose((place.center[0], place.center[1], place.center[2]))
        strokes = _edges(pose, Box((0.0, 0.0, 0.0), (half[0], half[1], half[2])), REGION)
        corner = pose.apply((half[0], half[1], half[2]))
        return Marks(strokes=strokes, tags=(Tag(tag, np.array(corner), REGION),))
    top = world.box(place.surface).seen_from(world.pose(place.surface)).high[2]
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    pose = frame @ flat
    ring = np.array([pose.apply((x * half[0], y * half[1], 0.0)) for x, y in corners])
    ring[:, 2] = top + _ABOVE_M
    return Marks(
        (Patch((ring,), REGION, 0.22),) if min(half) > 0 else (),
        (Stroke(ring, REGION, 1.6, closed=True),),
        (Tag(tag, ring[2], REGION),),
    )


def _cameras(world: World, camera: str) -> Marks:
    """Every other camera, as the pyramid that it looks into."""
    marks = Marks()
    for name in world.scene.cameras:
        if name != camera:
            marks += _pyramid(world.camera(name), name)
    return marks


def _pyramid(view: CameraView, name: str) -> Marks:
    depth = 0.10
    high = depth * math.tan(math.radians(view.fov_deg) / 2)
    high = min(high, 0.08)
    wide = high * view.width / view.height
    corners = ((-wide, -high), (wide, -high), (wide, high), (-wide, high))
    far = np.array([view.pose.apply((x, y, depth)) for x, y in corners])
    eye = np.array(view.eye)
    roof = np.array([view.pose.apply((x, -high, depth)) for x in (-0.5 * wide, 0.5 * wide)])
    peak = np.array(view.pose.apply((0.0, -1.45 * high, depth)))
    strokes = [Stroke(far, CAMERA, 1.2, closed=True)]
    strokes += [Stroke(np.array([eye, corner]), CAMERA, 1.2) for corner in far]
    strokes.append(Stroke(np.array([roof[0], peak, roof[1]]), CAMERA, 1.2))  # which way is up
    return Marks(strokes=tuple(strokes), tags=(Tag(name, eye, CAMERA),))


def _reach(world: World, camera: str) -> Marks:
    """What each arm reaches with its tool pointing down, a little above the working surface."""
    del camera
    low, high = _working_plane(world)
    marks = Marks()
    for number, (name, robot) in enumerate(world.robots.items()):
        color = ROBOTS[number % len(ROBOTS)]
        base = world.pose(f"{name}.base")
        at = (low[0], low[1], low[2] + _HIGHER_M)
        found = reach_map(robot.chain, base, robot.home, at, (high[0], high[1]))
        rings = tuple(ring - np.array([0, 0, _HIGHER_M - _ABOVE_M]) for ring in outlines(found))
        if not rings:
            continue
        strokes = tuple(Stroke(ring, color, 1.6, closed=True) for ring in rings)
        marks += Marks(
            (Patch(rings, color, 0.2),), strokes, (_reach_tag(name, rings, base, color),)
        )
    return marks


def _reach_tag(name: str, rings: Sequence[Points], base: Pose, color: Rgb) -> Tag:
    """The name, where the outline comes nearest to the robot: there, robots differ."""
    outline = max(rings, key=len)
    away = np.linalg.norm(outline[:, :2] - np.array(base.position[:2]), axis=1)
    return Tag(f"{name} reaches", outline[int(np.argmin(away))], color)


def arm_reach(chain: Chain, home: Sequence[float], room_m: float) -> Marks:
    """What an arm at the origin reaches with its tool pointing down, at three heights.

    Args:
        chain: The arm.
        home: Joint positions to begin at, in rad or m.
        room_m: How far around the base to look, in metres.
    """
    marks = Marks()
    for share, color in zip(_HEIGHTS, ROBOTS, strict=False):
        height = share * room_m
        low, high = (-room_m, -room_m, height), (room_m, room_m)
        found = reach_map(chain, Pose(), home, low, high, spacing=room_m / 11)
        if not (rings := outlines(found)):
            continue
        outline = max(rings, key=len)
        tag = Tag(f"{height:.2f} m high", outline[int(np.argmin(outline[:, 1]))], color)
        strokes = tuple(Stroke(ring, color, 1.6, closed=True) for ring in rings)
        marks += Marks((Patch(rings, color, 0.16),), strokes, (tag,))
    return marks


def _working_plane(world: World) -> tuple[Vec3, Vec3]:
    """The level rectangle on which things are put; its height is that of both corners."""
    names = [
        place.surface
        for thing in (*world.scene.objects.values(), *world.scene.sites.values())
        if (place := thing.place) is not None and place.surface is not None
    ]
    fixed = [name for name, thing in world.objects.items() if thing.spec.fixed]
    boxes = [world.box(name).seen_from(world.pose(name)) for name in (*names, *fixed)]
    if boxes:
        widest = max(boxes, key=lambda box: box.half[0] * box.half[1])
        return (widest.low[0], widest.low[1], widest.high[2]), widest.high
    bases = [world.pose(f"{name}.base").position for name in world.robots]
    low = [min(base[i] for base in bases) - _REACH_M for i in (0, 1)]
    high = [max(base[i] for base in bases) + _REACH_M for i in (0, 1)]
    return (low[0], low[1], 0.0), (high[0], high[1], 0.0)


def _each(world: World, names: Iterable[str]) -> Iterator[str]:
    """Names, without the members of large groups but for the first of each."""
    groups = world.task.names.groups
    large = [members for members in groups.values() if len(members) > _ALIKE]
    left_out = {name for members in large for name in members[1:]}
    yield from (name for name in names if name not in left_out)


def _along(index: int, length: float) -> Vec3:
    x, y, z = (length if number == index else 0.0 for number in range(3))
    return x, y, z


def _circle(pose: Pose, radius: float) -> Points:
    angles = np.linspace(0.0, 2.0 * math.pi, 33)[:-1].tolist()
    points = [(radius * math.cos(a), radius * math.sin(a), 0.0) for a in angles]
    return np.array([pose.apply(point) for point in points])


def _edges(pose: Pose, box: Box, color: Rgb) -> tuple[Stroke, ...]:
    """The twelve edges of a box."""
    x, y, z = box.half
    corners = ((-x, -y), (x, -y), (x, y), (-x, y))
    floor = np.array([pose.apply((a, b, -z)) for a, b in corners])
    roof = np.array([pose.apply((a, b, z)) for a, b in corners])
    posts = (Stroke(np.array(ends), color) for ends in zip(floor, roof, strict=True))
    return Stroke(floor, color, closed=True), Stroke(roof, color, closed=True), *posts


SHOWN: Mapping[str, Callable[[World, str], Marks]] = {
    "frames": _frames,
    "grasps": _grasps,
    "sites": _sites,
    "regions": _regions,
    "cameras": _cameras,
    "reach": _reach,
}
"""What can be drawn over pictures, and how: word -> what it draws of a world for a camera."""

_FOR_EACH_CAMERA = ("frames", "cameras")
