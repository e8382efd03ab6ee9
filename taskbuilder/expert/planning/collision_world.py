"""A second world for distance queries, which leaves the simulated one unchanged."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from taskbuilder.expert.planning.reach import Reach
from taskbuilder.geometry import Pose
from taskbuilder.sim.contacts import copy_joints, gaps
from taskbuilder.world.building import build_world
from taskbuilder.world.world import World

RESTING_M = 0.003
"""An object closer than this (m) to one below it rests on it."""


@dataclass(frozen=True)
class AttachedObject:
    """An object that moves rigidly with a tool.

    Attributes:
        name: The object.
        robot: The robot.
        pose: Pose of the object in the tool's frame.
    """

    name: str
    robot: str
    pose: Pose


class CollisionWorld:
    """A copy of a world whose arms can be put in any configuration.

    Args:
        world: The world to copy: its task and scene, but not its state.

    Attributes:
        world: The copy.
        reaches: Its arms.
    """

    def __init__(self, world: World) -> None:
        scenes = world.task.scenes
        variation = next(k for k, scene in enumerate(scenes) if scene is world.scene)
        self.world = build_world(world.task, variation=variation)
        self.reaches = {name: Reach.of(self.world, name) for name in self.world.robots}

    def copy(self, live: World) -> dict[str, tuple[float, ...]]:
        """Copy the state of a world of the same scene, with arms at their commanded positions.

        Returns:
            The commanded joints of each arm.
        """
        for name, obj in self.world.objects.items():
            original = live.objects[name].body
            obj.body.place(original.pose())
            copy_joints(obj.body, original)
        commanded = {name: robot.commanded() for name, robot in live.robots.items()}
        for name, robot in self.world.robots.items():
            copy_joints(robot.body, live.robots[name].body)
            self.pose_arm(name, commanded[name])
        return commanded

    def pose_arm(self, robot: str, joints: Sequence[float]) -> None:
        """Put an arm's joints at positions, in rad or m."""
        self.world.robots[robot].pose_arm(joints)

    def riders(self, live: World, held: Mapping[str, str]) -> list[AttachedObject]:
        """Objects that move with the tools: held ones, those that rest on these, and so on.

        Args:
            live: The world that was copied, for the grasps.
            held: The object that each robot holds.
        """
        riding: dict[str, AttachedObject] = {}
        for robot, name in held.items():
            if name not in riding and name in self.world.movable:  # else its handle is held
                grasp = live.pose(f"{robot}.tcp").inverse() @ live.pose(name)
                riding[name] = AttachedObject(name, robot, grasp)
        waiting = list(riding)
        while waiting:
            below = riding[waiting.pop(0)]
            for name in self._resting_on(below.name):
                if name not in riding:
                    pose = below.pose @ live.pose(below.name).inverse() @ live.pose(name)
                    riding[name] = AttachedObject(name, below.robot, pose)
                    waiting.append(name)
        return list(riding.values())

    def close(self) -> None:
        """Close the physics engine."""
        self.world.close()

    def _resting_on(self, below: str) -> Iterator[str]:
        """The movable objects that rest on one."""
        carrier = self.world.objects[below].body
        for name in self.world.movable:
            body = self.world.objects[name].body
            if name != below and any(gap.up > 0.5 for gap in gaps(body, carrier, RESTING_M)):
                yield name
