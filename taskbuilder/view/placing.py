"""What can be moved by hand on the page, and what a task file says of where it is then.

The file says where a thing is in some frame, or in which region it is placed. So a new pose in the
world becomes a new position and orientation in that frame, or a new centre of the region.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from taskbuilder.cameras import CameraView
from taskbuilder.geometry import Pose, Vec3, rotate, subtract, to_rpy_deg
from taskbuilder.kinematics.inverse import IkResult, solve
from taskbuilder.schema.placing import Placed
from taskbuilder.schema.rewrite import Value, written
from taskbuilder.schema.source import Path_
from taskbuilder.sim.contacts import gaps
from taskbuilder.world.cameras import camera_view
from taskbuilder.world.world import World

Sort = Literal["object", "site", "region", "base", "tool", "camera"]

LOOK_M = 0.2
"""Distances to other bodies are measured up to this one, in metres."""

UNTURNED_DEG = 0.05
"""What turns by less keeps the orientation that the file gives it."""

MOST_WORDS = 3
"""So many of the nearest bodies are named."""


@dataclass(frozen=True)
class Movable:
    """A thing that can be moved.

    Attributes:
        sort: What it is. The tool of a robot stands for the start configuration of its arm.
        name: The object, site, robot or camera; of a region, what is placed in it.
    """

    sort: Sort
    name: str

    def __str__(self) -> str:
        labels = {"base": f"{self.name} (base)", "tool": f"{self.name} (tool at the start)"}
        return labels.get(self.sort, f"{self.name} ({self.sort})")


def movables(world: World) -> tuple[Movable, ...]:
    """What can be moved, in the order of the file; of a group of objects the whole, as a site."""
    grouped = {member for members in world.task.names.groups.values() for member in members}
    scene = world.scene
    found = [Movable("object", name) for name in scene.objects if name not in grouped]
    found += [Movable("site", name) for name in scene.sites if name not in grouped]
    placed: Mapping[str, Placed] = {**scene.objects, **scene.sites}
    found += [
        Movable("region", name)
        for name, thing in placed.items()
        if thing.place is not None and name not in grouped
    ]
    for name in scene.robots:
        found += [Movable("base", name), Movable("tool", name)]
    return (*found, *(Movable("camera", name) for name in scene.cameras))


@dataclass(frozen=True)
class ValueChange:
    """A value of the file that is to be another one.

    Attributes:
        path: Where it is in the file.
        before: The value as it is written now, or "".
        value: The new value.
    """

    path: Path_
    before: str
    value: Value

    def __str__(self) -> str:
        key = str(self.path[-1])
        return f"{key.rpartition('.')[2]}: {written(self.value)}"


class Placing:
    """Moves one thing in a world in its initial state, and says what its file would have to say.

    Args:
        world: The world; `move` changes it.
        variation: Number of the variation of its scene.
        thing: The thing.

    Attributes:
        pose: Where it is now, in the world; a camera looks along z.
        values: What the file has to say, by where it says it; empty if nothing has moved.
        solution: The arm's joints, if the tool of a robot has moved.
    """

    def __init__(self, world: World, variation: int, thing: Movable) -> None:
        self.thing = thing
        self._world, self._variation = world, variation
        self._before = self.pose = self._now()
        self.values: Mapping[Path_, Value] = {}
        self.solution: IkResult | None = None

    def move(self, pose: Pose) -> None:
        """Move it.

        Args:
            pose: Where to, in the world.
        """
        self.pose = pose
        getattr(self, f"_move_{self.thing.sort}")(pose)
        turned = _angle_deg(self._before, pose) > UNTURNED_DEG
        moved = math.dist(self._before.position, pose.position) > 1e-6
        values = self._values(turned=turned) if moved or turned else {}
        self.values = {
            written_path(self._world, self._variation, path): value
            for path, value in values.items()
        }

    def put_back(self) -> None:
        """Put it back where it was."""
        self.move(self._before)
        if self.solution is not None:
            robot = self._world.robots[self.thing.name]
            robot.pose_arm(robot.home)
            self.solution = None

    def view(self, width: int) -> CameraView | None:
        """What a camera sees from where it is now; None for other things.

        Args:
            width: Width of the picture in pixels.
        """
        if self.thing.sort != "camera":
            return None
        spec = self._world.scene.cameras[self.thing.name]
        size = (width, round(width * spec.size[1] / spec.size[0]))
        eye, aim = self._camera_points()
        changed = spec.model_copy(update={"position": eye, "look_at": aim})
        cameras, look = {self.thing.name: changed}, self._world.look
        return camera_view(cameras, self.thing.name, self._world.pose, look, size)

    def near(self) -> tuple[tuple[str, float], ...]:
        """The nearest bodies, each with its distance in metres; negative for an overlap."""
        if self.thing.sort in ("site", "camera"):
            return ()
        bodies = {name: thing.body for name, thing in self._world.objects.items()}
        bodies |= {name: robot.body for name, robot in self._world.robots.items()}
        own = bodies.pop(self.thing.name)
        near = {name: gaps(own, body, LOOK_M) for name, body in bodies.items()}
        found = ((name, min(each.distance for each in at)) for name, at in near.items() if at)
        return tuple(sorted(found, key=lambda pair: pair[1])[:MOST_WORDS])

    def changes(self) -> tuple[ValueChange, ...]:
        """What in the file is to be written otherwise."""
        return changes_of(self._world, self.values)

    # --- where things are

    def _now(self) -> Pose:
        name, world = self.thing.name, self._world
        if self.thing.sort == "base":
            return world.robots[name].body.pose()
        if self.thing.sort == "tool":
            return world.robots[name].tcp
        if self.thing.sort == "camera":
            return world.camera(name).pose
        return world.pose(name)

    def _move_object(self, pose: Pose) -> None:
        self._world.objects[self.thing.name].body.place(pose)

    def _move_site(self, pose: Pose) -> None:
        site = self._world.sites[self.thing.name]
        site.pose = self._frame(site.spec.frame).inverse() @ pose
        if site.marker is not None:
            site.marker.place(pose)

    def _move_base(self, pose: Pose) -> None:
        self._world.robots[self.thing.name].body.place(pose)

    def _move_tool(self, pose: Pose) -> None:
        robot = self._world.robots[self.thing.name]
        target = robot.body.pose().inverse() @ pose
        rng = np.random.default_rng(0)
        self.solution = solve(robot.chain, target, start=robot.arm_state()[0], rng=rng)
        robot.pose_arm(self.solution.joints)

    def _move_camera(self, pose: Pose) -> None:
        """Nothing in the world is there to be moved."""

    def _frame(self, name: str | None) -> Pose:
        return Pose() if name in (None, "world") else self._world.pose(str(name))

    # --- what the file says

    def _values(self, *, turned: bool) -> Mapping[Path_, Value]:
        name, scene = self.thing.name, self._world.scene
        if self.thing.sort == "camera":
            eye, aim = self._camera_points()
            at: Path_ = ("scene", "cameras", name)
            return {(*at, "position"): eye, (*at, "look_at"): aim}
        if self.thing.sort == "base":
            base = ("scene", "robots", name, "base")
            return _pose_values(base, self.pose, turned=turned)
        if self.thing.sort == "tool":
            return self._home_values(turned=turned)
        things: Mapping[str, Placed] = scene.objects
        if self.thing.sort == "site":
            things = scene.sites
        return self._placed_values(things[name], turned=turned)

    def _placed_values(self, spec: Placed, *, turned: bool) -> Mapping[Path_, Value]:
        at: Path_ = ("scene", f"{self.thing.sort}s", self.thing.name)
        place = spec.place
        if place is None:
            frame = self._frame(spec.frame)
            # What has settled after it was placed stands a little otherwise than it is written.
            pose = frame.inverse() @ self._moved(frame @ spec.pose)
            return _pose_values(at, pose, turned=turned)
        back = self._frame(place.frame).inverse()
        shift = subtract(self.pose.position, self._before.position)
        shift = rotate(back.quaternion, shift)
        center = tuple(each + by for each, by in zip(place.center, shift, strict=False))
        values: dict[Path_, Value] = {(*at, "place", "center"): center}
        if turned and (yaw := _yaw_deg(self._before, self.pose)) is not None:
            values[(*at, "place", "yaw_deg")] = tuple(each + yaw for each in place.yaw_deg)
        return values

    def _home_values(self, *, turned: bool) -> Mapping[Path_, Value]:
        name = self.thing.name
        home = self._world.scene.robots[name].home
        at: Path_ = ("scene", "robots", name, "home")
        if home is not None and home.tcp is not None:
            return _pose_values((*at, "tcp"), self.pose, turned=turned)
        if home is not None and self.solution is not None:
            return {(*at, "joints_deg"): self.joints_deg()}
        return {at: {"tcp": dict(_pose_entries(self.pose, turned=True))}}

    def joints_deg(self) -> tuple[float, ...]:
        """The arm's joints as a file writes them: degrees, or metres where a joint slides."""
        robot = self._world.robots[self.thing.name]
        joints = robot.arm_state()[0] if self.solution is None else self.solution.joints
        return tuple(
            value if joint.type == "prismatic" else math.degrees(value)
            for joint, value in zip(robot.model.arm, joints, strict=True)
        )

    def _camera_points(self) -> tuple[Vec3, Vec3]:
        """Where a camera is and what it looks at, in the world or in its mount."""
        spec = self._world.scene.cameras[self.thing.name]
        mount = self._frame(spec.mount)
        back = mount.inverse()

        def moved(point: Vec3) -> Vec3:
            return back.apply(self._moved(Pose(mount.apply(point))).position)

        return moved(spec.eye), moved(spec.aim)

    def _moved(self, pose: Pose) -> Pose:
        """A pose in the world that moves with the thing."""
        return self.pose @ self._before.inverse() @ pose


def changes_of(world: World, values: Mapping[Path_, Value]) -> tuple[ValueChange, ...]:
    """What in the task file of a world is to be written otherwise.

    Args:
        world: The world.
        values: The new values, by where they are in the file.
    """
    source = world.task.source
    befores = ((path, source.get(*path)) for path in values)
    return tuple(
        ValueChange(path, "" if before is None else written(before), values[path])
        for path, before in befores
    )


def written_path(world: World, variation: int, path: Path_) -> Path_:
    """Where a value stands in the file: in the variation, if it changes the value.

    Args:
        world: The world.
        variation: Number of the variation of its scene.
        path: Where the value stands in the task, such as ``("scene", "objects", "cube", "mass")``.
    """
    if variation:
        key = ".".join(map(str, path[2:]))
        place: Path_ = ("variations", variation - 1)
        changes: Any = world.task.source.get(*place)
        if isinstance(changes, Mapping) and key in changes:
            return (*place, key)
    return world.task.source.written(path)


def _pose_values(at: Path_, pose: Pose, *, turned: bool) -> Mapping[Path_, Value]:
    return {(*at, key): value for key, value in _pose_entries(pose, turned=turned).items()}


def _pose_entries(pose: Pose, *, turned: bool) -> Mapping[str, Value]:
    entries: dict[str, Value] = {"position": pose.position}
    if turned:
        entries["rpy_deg"] = tuple(round(angle, 2) for angle in to_rpy_deg(pose.quaternion))
    return entries


def _angle_deg(one: Pose, other: Pose) -> float:
    """Angle between two orientations."""
    *_, w = (one.inverse() @ other).quaternion
    return math.degrees(2.0 * math.acos(min(abs(w), 1.0)))


def _yaw_deg(one: Pose, other: Pose) -> float | None:
    """Angle about the vertical by which a pose was turned; None if it was tilted."""
    x, y, z, w = (other @ one.inverse()).quaternion
    if math.hypot(x, y) > 0.01:
        return None
    return round(math.degrees(2.0 * math.atan2(z, w)), 2)
