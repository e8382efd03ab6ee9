"""The world: what conditions, observations and rewards read, and what actions drive."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

from taskbuilder.cameras import CameraView
from taskbuilder.errors import Finding
from taskbuilder.geometry import Box, Pose, Vec3
from taskbuilder.schema.disturbances import Disturbances
from taskbuilder.schema.load import TaskFile
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.task import LookPart
from taskbuilder.sim import divergence
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.contact_order import ContactOrder
from taskbuilder.sim.contacts import part
from taskbuilder.sim.single import Single
from taskbuilder.sim.snapshots import Commanded, release, restore, save
from taskbuilder.world.cameras import camera_view
from taskbuilder.world.distractors import scattered
from taskbuilder.world.disturbing import Disturber
from taskbuilder.world.forces import ForceMeter, Pair
from taskbuilder.world.frames import SceneFrames
from taskbuilder.world.locks import locks_of
from taskbuilder.world.looks import AS_WRITTEN, Look, Painter, draw_look, furniture
from taskbuilder.world.piles import PILES, Piles
from taskbuilder.world.placement import PlacementPlan, place_all, settling_steps
from taskbuilder.world.randomness import EpisodeRandomness, apply, drawn, written
from taskbuilder.world.robot import Robot
from taskbuilder.world.scene_objects import SceneObject, Site
from taskbuilder.world.segments import segments_of
from taskbuilder.world.state import WorldState
from taskbuilder.world.touch import Touch


class World(Single):
    """The robots, objects and sites of a scene, by name, in one physics client.

    Values are read from the physics once and cached until the next step, so that they stay the same
    within a control step. A world implements `WorldView`, the interface through which descriptions
    read values.

    Attributes:
        task: The contents of the task file, with the robots and assets that it uses.
        spec: The keys and values of the task file.
        scene: The scene that was built, with the changes of the variation.
        client: The physics client.
        robots: The robots by name, in the order of the task file.
        objects: The objects by name: all bodies that are not robots.
        sites: The sites by name: frames without a body.
        floor: The body of the floor, or None if the scene has no floor.
        segments: The numbers and names in segmentation masks.
        warnings: Warnings from the physics engine while assets were loaded.
        time: Seconds since the episode began.
        quantities: Values in this episode of what the task file lists under ``randomize``.
        look: Light, background, textures, distractors and camera poses of this episode.
        disturbed: What this episode drew for disturbances, by axis, as JSON can hold it.
        piled: Resting pose of each object in a pile at the start of this episode, relative to the
            position of the pile.
        onlooker: None, or a generator that is advanced before each physics step and can thus read
            the state in the middle of a control step. The generator must not change the world, and
            must call `refresh` before it reads any values.
        contact_order: Whether the order of contacts is certain although a state was restored.
    """

    def __init__(
        self,
        task: TaskFile,
        scene: SceneSpec,
        client: Client,
        robots: Mapping[str, Robot],
        objects: Mapping[str, SceneObject],
        sites: Mapping[str, Site],
        floor: Body | None,
        warnings: tuple[Finding, ...] = (),
        disturbances: Disturbances = (),
    ) -> None:
        self.task = task
        self.spec = task.spec
        self.scene = scene
        self.client = client
        self.robots = robots
        self.objects = objects
        self.sites = sites
        self.floor = floor
        self.segments = segments_of(robots, objects, sites, floor)
        self.warnings = warnings
        self.time = 0.0
        self._disturber = Disturber(dict(disturbances))
        self.quantities: Mapping[str, Any] = {
            **self._disturber.written(self),
            **written(scene, task.spec.randomize, task.names.groups),
        }
        self.disturbed: Mapping[str, Any] = {}
        self.look = AS_WRITTEN
        self.contact_order = ContactOrder(client, self._bodies)
        self._painter = Painter(client, objects, floor, furniture(task.spec, scene))
        self.onlooker: Iterator[None] | None = None
        self._locks = locks_of(objects)
        self._springs = tuple(
            joint for thing in objects.values() for joint in thing.passive.values() if joint.acts
        )
        self._ends = tuple(robot.gripper for robot in robots.values())
        self._graspable = tuple((thing.body, thing.free_links) for thing in objects.values())
        self._frames = SceneFrames(robots, objects, sites)
        self._touch = Touch(client, robots, objects)
        self._forces = ForceMeter(client.physics_hz, self._touch)
        self.plan = PlacementPlan.of(scene)
        self._settling_steps = settling_steps(task)
        self._piles = Piles(task, scene)
        self.piled: Mapping[str, Pose] = {}
        self._built: WorldState | None = None

    # Time

    def keep_as_built(self) -> WorldState:
        """Save the current state as the state that every `reset` starts from."""
        self._built = self.save()
        return self._built

    def reset(
        self, seed: int, *, randomized: bool = False, looks: Collection[LookPart] = ()
    ) -> None:
        """Begin an episode: reset the robots, place the objects and let the objects settle briefly.

        Args:
            seed: Seed of the random-number generators for placing objects and for randomisation.
            randomized: Whether to randomise what the task file lists under ``randomize``.
            looks: The parts of the scene's appearance to draw at random: any of ``light``,
                ``background``, ``furniture``, ``textures``, ``distractors`` and ``cameras``.

        Raises:
            PlacementError: The objects could not be placed without overlap.
            ExplosionError: The physics diverged.
        """
        randomness = EpisodeRandomness(seed)
        if self._piles:
            self._pile(int(randomness.piles().integers(PILES)))
        self.restore(self._built or self.keep_as_built())
        self.contact_order.begun_anew()
        values = dict(self.quantities)
        if randomized:
            values |= drawn(self.spec.randomize, randomness.quantities())
        self._set_quantities(self._disturber.quantities(values, randomness))
        starts = self._disturber.start_arms(self, randomness)
        place_all(self, randomness.placement())
        self._run({}, self._settling_steps)
        if parts := {*looks, *self._disturber.look_parts}:
            self._set_look(self._drawn_look(parts, randomness))
        self.disturbed = self._disturber.drawn(self, starts)
        self.time = 0.0
        self._forces.clear()

    def _drawn_look(self, parts: Collection[LookPart], randomness: EpisodeRandomness) -> Look:
        look = self._disturber.scaled(draw_look(self.spec, self.scene, randomness.looks(), parts))
        if "distractors" not in parts:
            return look
        most = self._disturber.most_distractors
        return replace(look, distractors=scattered(self, randomness.distractors(), most))

    def _pile(self, number: int) -> None:
        """Take one of the piles, and settle it if that was never done."""
        if self._piles.settled(number) is None:
            onlooker, self.onlooker = self.onlooker, None  # of the episode, which has not begun
            randomness = EpisodeRandomness(number)
            self.restore(self._built or self.keep_as_built())
            self.piled = self._piles.loose(randomness.piles())
            place_all(self, randomness.placement())
            self._piles.settle(number, self)
            self.onlooker = onlooker
        self.piled = self._piles.settled(number) or {}

    def step(self, arm_targets: Mapping[str, Sequence[float]] | None = None) -> None:
        """Run one control step.

        Args:
            arm_targets: Target joint positions (rad or m) by robot. The commanded positions change
                linearly, and reach the targets in the last physics step. Arms without targets, and
                all grippers, keep their previous commands.

        Raises:
            ExplosionError: The physics diverged; build a new world.
        """
        self._run(arm_targets or {}, self.spec.timing.substeps)

    def _run(self, targets: Mapping[str, Sequence[float]], substeps: int) -> None:
        """Run some physics steps."""
        drives = [self.robots[name].ramp(to, substeps) for name, to in targets.items()]
        drives += [r.push() for n, r in self.robots.items() if r.pushes and n not in targets]
        drives += [joint.act() for joint in self._springs]
        ends = [drive for end in self._ends if (drive := end.drive(self._graspable)) is not None]
        drives += ends
        if self.onlooker is not None:
            drives.append(self.onlooker)
        self._forces.begin()
        watches = [self._forces.read] if self._forces else []
        watches += [self.contact_order.look] if self.contact_order.watched else []
        self.client.step(substeps, drives, watches, self._locks.holds)
        for end in ends:
            next(end)
        self.time += substeps / self.spec.timing.physics_hz
        self.refresh()
        self._check()

    def set_locks(self, conditions: Mapping[str, bool]) -> None:
        """Lock or free every joint that has a ``lock`` in the task file; `reset` locks all of them.

        Args:
            conditions: Whether each condition of the description holds, by name.
        """
        self._locks.obey(conditions)

    @property
    def has_locks(self) -> bool:
        """Whether any joint has a ``lock`` in the task file."""
        return bool(self._locks.of)

    @property
    def locked(self) -> Mapping[str, str]:
        """The locked joints, such as ``box.hinge``, each with the condition that frees it."""
        return self._locks.locked

    def refresh(self) -> None:
        """Clear the cached values, so that they are read from the physics again."""
        self._frames.refresh()
        self._touch.refresh()

    def save(self) -> WorldState:
        """Save the state, including motor targets. This takes about 3 ms and 250 KB of memory.

        Call `release` when the state is no longer needed.
        """
        motors: list[Commanded] = [*self._locks.joints]
        for robot in self.robots.values():
            motors += [robot.arm, robot.gripper]
        sites = {name: site.pose for name, site in self.sites.items()}
        snapshot, met = save(self.client, motors), self.contact_order.contacts()
        return WorldState(
            *(snapshot, self.time, sites, self.quantities, met, self._forces.readings, self.look),
            self.disturbed,
        )

    def restore(self, state: WorldState) -> None:
        """Restore a saved state of this world.

        It goes on to the bit as it did unless `contact_order` becomes uncertain.
        """
        part(self.client, self._bodies)
        restore(state.snapshot)
        self.contact_order.restored(self.contact_order.contacts() == state.contacts)
        self.time = state.time
        for name, pose in state.sites.items():
            self.sites[name].pose = pose
        self._set_quantities(state.quantities)
        self._set_look(state.look)
        self.disturbed = state.disturbed
        self._forces.restore(state.forces)
        self.refresh()

    def release(self, state: WorldState) -> None:
        """Free a saved state. It can then no longer be restored."""
        release(state.snapshot)

    def close(self) -> None:
        """Close the physics client."""
        self.client.close()

    @property
    def _bodies(self) -> list[Body]:
        bodies = [thing.body for thing in self.objects.values()]
        return bodies + [robot.body for robot in self.robots.values()]

    def _set_quantities(self, values: Mapping[str, Any]) -> None:
        """Give what the task can randomise its values; the physics' snapshots hold none of them."""
        changed = {k: value for k, value in values.items() if value != self.quantities[k]}
        apply(self.robots, self.objects, self.sites, changed, self.task.names.groups)
        self.quantities = values

    def _set_look(self, look: Look) -> None:
        if look is not self.look:
            self._painter.paint(look)
        self.look = look

    def _check(self) -> None:
        for name, thing in self.objects.items():
            if not thing.spec.fixed:
                divergence.check_pose(name, self.pose(name))
            if thing.joints:
                divergence.check_joints(name, thing.body.joint_states(thing.joints)[1])
        for name, robot in self.robots.items():
            divergence.check_joints(name, robot.speeds())

    # Names

    @cached_property
    def robot_names(self) -> tuple[str, ...]:
        """The names of the robots, in the order of the task file."""
        return tuple(self.robots)

    @cached_property
    def object_names(self) -> tuple[str, ...]:
        """The names of the objects, in the order of the task file."""
        return tuple(self.objects)

    @cached_property
    def movable(self) -> tuple[str, ...]:
        """The names of the objects that are not fixed, in the order of the task file."""
        return tuple(name for name, thing in self.objects.items() if not thing.spec.fixed)

    @cached_property
    def mechanisms(self) -> tuple[str, ...]:
        """The moving links of fixed objects, such as doors: a hand on one can only move with it."""
        return tuple(
            f"{name}.{link}"
            for name, thing in self.objects.items()
            if thing.spec.fixed
            for link in thing.moving_links
        )

    @cached_property
    def holdable(self) -> tuple[str, ...]:
        """What robots can hold: objects that are not fixed, and moving links of fixed objects."""
        return (*self.movable, *self.mechanisms)

    def is_solid(self, name: str) -> bool:
        """True for the name of an object, a part or a link; False for the name of a site."""
        return name not in self.sites

    # Where things are

    def pose(self, frame: str) -> Pose:
        """The pose of a named frame in the world.

        Raises:
            UnknownNameError: The scene has no such frame.
        """
        return self._frames.pose(frame)

    def position(self, frame: str) -> Vec3:
        """The position of a named frame in the world, in metres."""
        return self._frames.pose(frame).position

    def velocity(self, frame: str) -> tuple[Vec3, Vec3]:
        """Linear (m/s) and angular (rad/s) velocity of a named frame, in world axes."""
        return self._frames.velocity(frame)

    def box(self, body: str) -> Box:
        """Bounding box of an object, a part, a link or a site marker, in the frame of ``body``."""
        return self._frames.box(body)

    def opening(self, robot: str) -> float:
        """How far a robot's gripper is open, from 0 (closed) to 1 (open)."""
        return self.robots[robot].opening()

    def joint(self, name: str) -> float:
        """Position of an articulated object's joint, in rad or m."""
        return self._frames.joint(name)

    # What touches what

    def held(self, body: str, robot: str) -> bool:
        """Whether a robot holds an object, a part or a link: with fingers, suction or attached."""
        return self._touch.held(body, robot)

    def grip_forces(self, body: str, robot: str) -> tuple[float, ...]:
        """Force in newtons with which each finger of a robot presses on an object, part or link."""
        return self._touch.grip_forces(body, robot)

    def fingers_touch(self, body: str, robot: str) -> bool:
        """Whether any finger or tool of a robot touches an object, a part or a link."""
        return self._touch.fingers_touch(body, robot)

    def touching(self, first: str, second: str) -> bool:
        """Whether two objects, parts, links or robots touch; a robot includes its gripper."""
        return bool(self._touch.between(first, second))

    def support(self, body: str, below: str) -> float:
        """Upward force in newtons with which the body ``below`` carries the body ``body``."""
        return self._touch.support(body, below)

    def watch_forces(self, pairs: Iterable[Pair]) -> None:
        """From now on, measure the contact forces between these pairs of bodies and no others.

        A pair that was already watched continues to be measured without interruption.

        Raises:
            UnknownNameError: There is no such object, part or robot.
        """
        known = self._forces.readings
        self._forces = ForceMeter(self.client.physics_hz, self._touch, pairs)
        self._forces.restore(known)

    def contact_force(self, first: str, second: str) -> float:
        """Contact force between two bodies or robots in newtons, 0 after reset; see `ContactForce`.

        Raises:
            UsageError: The pair is not watched.
        """
        return self._forces.force(first, second)

    # Cameras

    def camera(self, name: str, size: tuple[int, int] | None = None) -> CameraView:
        """The current view of a named camera, with the camera randomisation of this episode.

        Raises:
            UnknownNameError: The scene has no such camera.
        """
        return camera_view(self.scene.cameras, name, self.pose, self.look, size)

    def move_markers(self) -> None:
        """Move each marker to the current pose of its site; needed only before rendering."""
        for name, site in self.sites.items():
            if site.marker is not None and site.rides_on:
                site.marker.place(self.pose(name))
