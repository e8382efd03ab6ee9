"""The world: what conditions, observations and rewards read, and what actions drive."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

from taskbuilder.errors import Finding, UnknownNameError
from taskbuilder.geometry import Box, Pose, Vec3, add, cross, dot, norm, scale, subtract
from taskbuilder.sim import faults
from taskbuilder.sim.body import BASE, Body
from taskbuilder.sim.cameras import CameraView
from taskbuilder.sim.client import Client
from taskbuilder.sim.contacts import Contact, contacts
from taskbuilder.sim.snapshots import Snapshot, restore, save
from taskbuilder.spec.explain import suggestion
from taskbuilder.spec.scene import SceneSpec
from taskbuilder.spec.task import Distribution, TaskSpec
from taskbuilder.world.placement import place_all
from taskbuilder.world.randomness import EpisodeRandomness, randomize
from taskbuilder.world.robot import Robot
from taskbuilder.world.things import Site, Thing

GRASP_FORCE_N = 0.5
"""What each finger must press with to hold something: well above the noise of a touch."""

_OPPOSING = -0.7  # cosine of the angle between the forces of two fingers; -1 is straight against


@dataclass(frozen=True)
class WorldState:
    """A moment of a world, for going back to within the same world."""

    snapshot: Snapshot
    time: float
    sites: Mapping[str, Pose]


class World:
    """Robots, objects and sites of a scene, by name, over one physics client.

    Values are read from the physics once and kept until the world moves on, so that everything
    that looks at a control step sees the same world. It is the `WorldView` of descriptions.

    Attributes:
        spec: The task file's content.
        scene: The scene that was built: the plain one or a variation.
        client: The physics.
        robots: The agents, in file order.
        objects: The bodies that are not robots.
        sites: The named frames without a body.
        floor: The floor's body, if the scene has one.
        warnings: What the engine said while it loaded assets.
        time: Seconds since the episode began.
    """

    def __init__(
        self,
        spec: TaskSpec,
        scene: SceneSpec,
        client: Client,
        robots: Mapping[str, Robot],
        objects: Mapping[str, Thing],
        sites: Mapping[str, Site],
        floor: Body | None,
        warnings: tuple[Finding, ...] = (),
    ) -> None:
        self.spec = spec
        self.scene = scene
        self.client = client
        self.robots = robots
        self.objects = objects
        self.sites = sites
        self.floor = floor
        self.warnings = warnings
        self.time = 0.0
        self._poses: dict[str, Pose] = {}
        self._contacts: dict[tuple[int, int], tuple[Contact, ...]] = {}
        self._built: WorldState | None = None

    # --- time

    def keep_as_built(self) -> WorldState:
        """Take the present state for the one that every episode starts from."""
        self._built = self.save()
        return self._built

    def reset(self, seed: int, *, randomized: bool = False) -> None:
        """Begin an episode: everything home, placed anew, and settled for one control step.

        Args:
            seed: Decides placement and randomisation, each by a generator of its own.
            randomized: Draw the quantities that the task file lists under ``randomize``.

        Raises:
            PlacementError: The objects do not fit.
            ExplosionError: The physics diverged.
        """
        randomness = EpisodeRandomness(seed)
        self.restore(self._built or self.keep_as_built())
        drawn: Mapping[str, Distribution] = self.spec.randomize
        if drawn:
            randomize(self, drawn if randomized else {}, randomness.variation())
        place_all(self, randomness.placement())
        self.client.collide()
        self.step()
        self.time = 0.0

    def step(self, arm_targets: Mapping[str, Sequence[float]] | None = None) -> None:
        """Let one control step pass.

        Args:
            arm_targets: Joint positions (rad or m) by robot, where its arm's targets arrive with
                the last physics step of this control step: the way there is a straight line from
                those commanded last. Other arms, and the grippers, go on with what they were told.

        Raises:
            ExplosionError: The physics diverged; build the world anew.
        """
        timing = self.spec.timing
        ramps = [
            self.robots[name].ramp(target, timing.substeps)
            for name, target in (arm_targets or {}).items()
        ]
        ramps += [robot.push() for robot in self.robots.values() if robot.pushes]
        self.client.step(timing.substeps, partial(_advance, ramps) if ramps else None)
        self.time += 1.0 / timing.control_hz
        self.refresh()
        self._check()

    def refresh(self) -> None:
        """Forget what was read of the physics."""
        self._poses.clear()
        self._contacts.clear()

    def save(self) -> WorldState:
        """The world at this moment, motors' targets included."""
        motors = [group for robot in self.robots.values() for group in (robot.arm, robot.gripper)]
        sites = {name: site.pose for name, site in self.sites.items()}
        return WorldState(save(self.client, motors), self.time, sites)

    def restore(self, state: WorldState) -> None:
        """Go back to a moment of this world, to the bit."""
        restore(state.snapshot)
        self.time = state.time
        for name, pose in state.sites.items():
            self.sites[name].pose = pose
        self.refresh()

    def close(self) -> None:
        """Free the physics."""
        self.client.close()

    def _check(self) -> None:
        for name, thing in self.objects.items():
            faults.check_pose(name, self.pose(name))
            if thing.body.joints:
                _, speeds = thing.body.joint_states(range(len(thing.body.joints)))
                faults.check_joints(name, speeds)
        for name, robot in self.robots.items():
            _, speeds = robot.arm_state()
            faults.check_joints(name, speeds)

    # --- names

    @cached_property
    def robot_names(self) -> tuple[str, ...]:
        """The agents, in file order."""
        return tuple(self.robots)

    @cached_property
    def object_names(self) -> tuple[str, ...]:
        """The objects, in file order."""
        return tuple(self.objects)

    def is_solid(self, name: str) -> bool:
        """Whether a name stands for a body rather than for a site."""
        return name not in self.sites

    # --- where things are

    def pose(self, frame: str) -> Pose:
        """The pose of a named frame in the world.

        Raises:
            UnknownNameError: The scene has no such frame.
        """
        known = self._poses.get(frame)
        if known is None:
            known = self._poses[frame] = self._read_pose(frame)
        return known

    def position(self, frame: str) -> Vec3:
        """The position of a named frame in the world, in metres."""
        return self.pose(frame).position

    def velocity(self, frame: str) -> tuple[Vec3, Vec3]:
        """Linear (m/s) and angular (rad/s) velocity of a body, part or tcp in the world."""
        owner, _, inner = frame.partition(".")
        if owner in self.robots:
            robot = self.robots[owner]
            link = BASE if inner == "base" else robot.body.links[robot.model.spec.tcp.link]
            state = robot.body.link_state(link)
        elif owner in self.objects:
            thing = self.objects[owner]
            own_link = inner and thing.spec.parts is None and inner not in thing.spec.grasps
            state = thing.body.link_state(thing.body.links[inner] if own_link else BASE)
        else:
            site = self._site(frame)
            return self.velocity(site.rides_on) if site.rides_on else ((0.0,) * 3, (0.0,) * 3)
        arm = subtract(self.position(frame), state.pose.position)
        linear, angular = state.velocity
        return add(linear, cross(angular, arm)), angular

    def box(self, body: str) -> Box:
        """Bounding box of an object, a part or a site's marker, in its own frame."""
        owner, _, part = body.partition(".")
        if owner in self.objects:
            thing = self.objects[owner]
            return thing.boxes[part] if part else thing.body.bounds()
        box = self._site(body).box
        if box is None:
            raise UnknownNameError(f'the site "{body}" has no marker, hence no volume')
        return box

    def joint(self, name: str) -> float:
        """Position of an articulated object's joint, in rad or m."""
        owner, _, joint = name.partition(".")
        body = self.objects[owner].body
        positions, _ = body.joint_states((body.joints[joint].index,))
        return positions[0]

    def _read_pose(self, frame: str) -> Pose:
        owner, _, inner = frame.partition(".")
        if owner in self.objects:
            thing = self.objects[owner]
            if not inner:
                return thing.body.pose()
            if inner in thing.spec.grasps:
                return self.pose(owner) @ Pose(thing.spec.grasps[inner].at)
            return thing.part_pose(inner)
        if owner in self.robots:
            robot = self.robots[owner]
            return robot.tcp if inner == "tcp" else robot.body.pose()
        site = self._site(frame)
        return self.pose(site.rides_on) @ site.pose if site.rides_on else site.pose

    def _site(self, name: str) -> Site:
        if name not in self.sites:
            known = (*self.objects, *self.sites, *(f"{robot}.tcp" for robot in self.robots))
            help_ = suggestion(name, known, what="it has")
            raise UnknownNameError(f'the world has no frame "{name}"; {help_}')
        return self.sites[name]

    # --- what touches what

    def held(self, body: str, robot: str) -> bool:
        """Whether fingers of a robot press on an object or part from opposite sides."""
        pushes = [push for push in self._pushes(body, robot) if norm(push.force) > GRASP_FORCE_N]
        return any(_opposed(one, other) for i, one in enumerate(pushes) for other in pushes[:i])

    def grip_forces(self, body: str, robot: str) -> tuple[float, ...]:
        """Force in newtons with which each finger of a robot presses on an object or part."""
        return tuple(norm(push.force) for push in self._pushes(body, robot))

    def fingers_touch(self, body: str, robot: str) -> bool:
        """Whether any finger of a robot touches an object or part."""
        fingers = {link for finger in self.robots[robot].fingers for link in finger}
        return any(contact.link_a in fingers for contact in self._touches(robot, body))

    def touching(self, first: str, second: str) -> bool:
        """Whether two things touch: objects, parts, or robots."""
        return bool(self._touches(first, second))

    def support(self, body: str, below: str) -> float:
        """Upward force in newtons with which one object or part carries another."""
        return sum(c.normal_on_b[2] * c.force for c in self._touches(body, below))

    def _pushes(self, body: str, robot: str) -> list[_Push]:
        """What each finger of a robot does to an object or part."""
        touches = self._touches(robot, body)
        pushes = []
        for finger in self.robots[robot].fingers if touches else ():
            own = [contact for contact in touches if contact.link_a in finger]
            force = _total([scale(contact.normal_on_b, -contact.force) for contact in own])
            middle = _total([scale(contact.position_on_b, 1.0 / len(own)) for contact in own])
            pushes.append(_Push(force, middle))
        return pushes

    def _touches(self, first: str, second: str) -> tuple[Contact, ...]:
        """Contacts of two named things, with the first as body a."""
        one, one_link = self._body(first)
        other, other_link = self._body(second)
        key = (one.id, other.id)
        if key not in self._contacts:
            self._contacts[key] = contacts(self.client, one, other)
        return tuple(
            contact
            for contact in self._contacts[key]
            if one_link in (None, contact.link_a) and other_link in (None, contact.link_b)
        )

    def _body(self, name: str) -> tuple[Body, int | None]:
        """The body of a name and, for a part or link, its index."""
        owner, _, part = name.partition(".")
        if owner in self.robots:
            return self.robots[owner].body, None
        if owner not in self.objects:
            help_ = suggestion(owner, (*self.objects, *self.robots), what="it has")
            raise UnknownNameError(f'the world has no body "{owner}"; {help_}')
        body = self.objects[owner].body
        return body, body.links[part] if part else None

    # --- cameras

    def camera(self, name: str, size: tuple[int, int] | None = None) -> CameraView:
        """What a named camera sees now: fixed, or riding on its mount.

        Raises:
            UnknownNameError: The scene has no such camera.
        """
        cameras = self.scene.cameras
        if name not in cameras:
            help_ = suggestion(name, cameras, what="there are")
            raise UnknownNameError(f'no camera "{name}"; {help_}')
        spec = cameras[name]
        mount = self.pose(spec.mount) if spec.mount else Pose()
        width, height = size or spec.size
        eye, aim = mount.apply(spec.eye), mount.apply(spec.aim)
        up = mount.axis(0) if spec.mount else (0.0, 0.0, 1.0)
        sight = subtract(aim, eye)
        if abs(dot(sight, up)) > 0.999 * norm(sight):  # straight down: the picture's top is +y
            up = mount.axis(1)
        return CameraView(eye, aim, up, spec.fov_deg, width, height)

    def move_markers(self) -> None:
        """Bring the markers of riding sites to where their sites are; only pictures need it."""
        for name, site in self.sites.items():
            if site.marker is not None and site.rides_on:
                site.marker.place(self.pose(name))


@dataclass(frozen=True, slots=True)
class _Push:
    """Force of a finger on a body (N), and where it acts, in the world."""

    force: Vec3
    at: Vec3


def _advance(ramps: Sequence[Iterator[None]]) -> None:
    for ramp in ramps:
        next(ramp)


def _opposed(one: _Push, other: _Push) -> bool:
    """Whether two fingers press against, and towards, each other: with their inner sides."""
    across = subtract(other.at, one.at)
    against = dot(one.force, other.force) < _OPPOSING * norm(one.force) * norm(other.force)
    return against and dot(one.force, across) > 0.0


def _total(vectors: Sequence[Vec3]) -> Vec3:
    total: Vec3 = (0.0, 0.0, 0.0)
    for vector in vectors:
        total = add(total, vector)
    return total
