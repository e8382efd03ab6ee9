"""The read-only view of the world that descriptions use."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from taskbuilder.geometry import Box, Pose, Vec3


class WorldView(Protocol):
    """The state of the world that descriptions read; constant within a control step.

    Frames have names such as ``stick``, ``tray.left_handle``, ``goal`` and ``left.tcp``. Poses and
    velocities are in the world frame, in metres, seconds and radians.
    """

    @property
    def time(self) -> float:
        """Seconds since the episode began."""

    @property
    def robot_names(self) -> Sequence[str]:
        """The names of the robots, in the order of the task file."""

    @property
    def object_names(self) -> Sequence[str]:
        """The names of the objects, in the order of the task file."""

    def pose(self, frame: str) -> Pose:
        """The pose of a named frame."""

    def position(self, frame: str) -> Vec3:
        """The position of a named frame."""

    def velocity(self, frame: str) -> tuple[Vec3, Vec3]:
        """Linear (m/s) and angular (rad/s) velocity of a named frame."""

    def box(self, body: str) -> Box:
        """Bounding box of an object, a part, a link or a site marker, in the frame of ``body``."""

    def is_solid(self, name: str) -> bool:
        """True for the name of an object, a part or a link; False for the name of a site."""

    def held(self, body: str, robot: str) -> bool:
        """Whether a robot holds an object, a part or a link, by opposing fingers or by suction."""

    def touching(self, first: str, second: str) -> bool:
        """Whether two objects, parts, links or robots touch; a robot includes its gripper."""

    def support(self, body: str, below: str) -> float:
        """Upward force in newtons with which ``below`` carries ``body``."""

    def contact_force(self, first: str, second: str) -> float:
        """Peak contact force between two bodies or robots in this control step, in N.

        It is measured only for pairs that a node of the description names in `Node.force_pairs`;
        see `ContactForce` for its definition.
        """

    def fingers_touch(self, body: str, robot: str) -> bool:
        """Whether any finger or tool of a robot touches an object, a part or a link."""

    def opening(self, robot: str) -> float:
        """How far a robot's gripper is open, from 0 (closed) to 1."""

    def joint(self, name: str) -> float:
        """Position of an articulated object's joint, in rad or m."""
