"""Where the named frames of a world are and how they move, read once a control step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from taskbuilder.errors import UnknownNameError
from taskbuilder.geometry import ORIGIN, Box, Pose, Vec3, add, cross, subtract
from taskbuilder.sim.body import BASE, LinkState
from taskbuilder.wording import suggestion
from taskbuilder.world.robot import Robot
from taskbuilder.world.scene_objects import SceneObject, Site


class SceneFrames:
    """Poses, velocities and boxes by name.

    A pose is read off the physics when it is first asked for, and kept until `refresh`.
    """

    def __init__(
        self,
        robots: Mapping[str, Robot],
        objects: Mapping[str, SceneObject],
        sites: Mapping[str, Site],
    ) -> None:
        self._robots = robots
        self._objects = objects
        self._sites = sites
        self._poses: dict[str, Pose] = {}

    def refresh(self) -> None:
        """Forget what was read."""
        self._poses.clear()

    def pose(self, frame: str) -> Pose:
        """The pose of a named frame in the world.

        Raises:
            UnknownNameError: There is no such frame.
        """
        known = self._poses.get(frame)
        if known is None:
            known = self._poses[frame] = self._read_pose(frame)
        return known

    def velocity(self, frame: str) -> tuple[Vec3, Vec3]:
        """Linear (m/s) and angular (rad/s) velocity of a named frame, in world axes.

        Raises:
            UnknownNameError: There is no such frame.
        """
        at = self.pose(frame).position
        carrier = frame
        while carrier in self._sites:
            rides_on = self._sites[carrier].rides_on
            if rides_on is None:
                return ORIGIN, ORIGIN
            carrier = rides_on
        state = self._carrier_state(carrier)
        linear, angular = state.velocity
        return add(linear, cross(angular, subtract(at, state.pose.position))), angular

    def box(self, name: str) -> Box:
        """Bounding box of an object, a part or a site's marker, in its own frame.

        Raises:
            UnknownNameError: There is nothing of that name that has a volume.
        """
        owner, _, part = name.partition(".")
        thing = self._objects.get(owner)
        if thing is not None:
            if not part:
                return thing.body.bounds()
            if part not in thing.boxes:
                raise _unknown("part", name, (f"{owner}.{known}" for known in thing.boxes))
            return thing.boxes[part]
        box = self._site(name).box
        if box is None:
            raise UnknownNameError(f'the site "{name}" has no marker, hence no volume')
        return box

    def joint(self, name: str) -> float:
        """Position of an articulated object's joint, in rad or m.

        Raises:
            UnknownNameError: There is no such joint.
        """
        owner, _, joint = name.partition(".")
        joints = self._objects[owner].body.joints if owner in self._objects else {}
        if joint not in joints:
            raise _unknown("joint", name, (f"{owner}.{known}" for known in joints))
        positions, _ = self._objects[owner].body.joint_states((joints[joint].index,))
        return positions[0]

    def _read_pose(self, frame: str) -> Pose:
        owner, _, inner = frame.partition(".")
        if owner in self._objects:
            thing = self._objects[owner]
            if not inner:
                return thing.body.pose()
            if inner in thing.frames:
                fixed = thing.frames[inner]
                carrier = (
                    self.pose(owner) if fixed.link == BASE else thing.body.link_pose(fixed.link)
                )
                return carrier @ fixed.pose
            if inner in thing.body.links:
                return thing.body.link_pose(thing.body.links[inner])
        elif owner in self._robots and inner in ("tcp", "base"):
            robot = self._robots[owner]
            return robot.tcp if inner == "tcp" else robot.body.pose()
        site = self._site(frame)
        return self.pose(site.rides_on) @ site.pose if site.rides_on else site.pose

    def _carrier_state(self, frame: str) -> LinkState:
        """Pose and velocity of the link that a frame is fixed to."""
        owner, _, inner = frame.partition(".")
        if owner in self._robots:
            robot = self._robots[owner]
            return robot.body.link_state(robot.tcp_link if inner == "tcp" else BASE)
        thing = self._objects[owner]
        if inner in thing.frames:
            return thing.body.link_state(thing.frames[inner].link)
        return thing.body.link_state(thing.body.links[inner] if inner else BASE)

    def _site(self, name: str) -> Site:
        if name not in self._sites:
            inner = (f"{o.name}.{frame}" for o in self._objects.values() for frame in o.frames)
            tcps = (f"{robot}.tcp" for robot in self._robots)
            raise _unknown("frame", name, (*self._objects, *self._sites, *tcps, *inner))
        return self._sites[name]


def _unknown(what: str, name: str, known: Iterable[str]) -> UnknownNameError:
    return UnknownNameError(
        f'the world has no {what} "{name}"; {suggestion(name, tuple(known), what="it has")}'
    )
