"""A body: its pose, links and joints.

A body's pose is that of its base link's frame. Bullet speaks of the base's centre of mass
instead; the two are converted here, so that nothing above needs to know.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

from taskbuilder.errors import SimulationError
from taskbuilder.geometry import (
    ORIGIN,
    Box,
    Pose,
    Vec3,
    add,
    bounding_box,
    cross,
    subtract,
    total,
)
from taskbuilder.shapes import RGBA
from taskbuilder.sim.bullet import p
from taskbuilder.sim.client import Client

BASE = -1

PAD_M = 0.01
"""Torque against turning on the spot for a unit of a pad's force, m: about the pad's radius."""

JointType = Literal["revolute", "prismatic", "fixed"]

_JOINT_TYPES: Mapping[int, JointType] = MappingProxyType(
    {p.JOINT_REVOLUTE: "revolute", p.JOINT_PRISMATIC: "prismatic", p.JOINT_FIXED: "fixed"}
)


@dataclass(frozen=True, slots=True)
class JointInfo:
    """A joint as its URDF declares it.

    Attributes:
        index: Bullet's index of the joint, which is also that of its child link.
        lower: Smallest position, rad or m; minus infinity for a joint that turns without end.
        upper: Largest position.
        velocity: Fastest speed, rad/s or m/s.
        effort: Largest torque in Nm or force in N.
        child: Index of the link it moves; equal to ``index``.
        parent: Index of the link that it is on.
    """

    index: int
    type: JointType
    lower: float
    upper: float
    velocity: float
    effort: float
    child: int
    parent: int


class Velocity(NamedTuple):
    """Velocity of a frame's origin (m/s) and angular velocity (rad/s), in world axes."""

    linear: Vec3
    angular: Vec3


class LinkState(NamedTuple):
    """Where a link frame is and how it moves, in the world."""

    pose: Pose
    velocity: Velocity


class AddedInertia(NamedTuple):
    """What a link's inertia is raised by: a mass (kg), and a moment (kg·m²) about every axis."""

    mass: float = 0.0
    moment: float = 0.0


class Body:
    """A rigid or articulated body of one client.

    Made by `bodies.create_body` and `bodies.load_urdf`.

    Attributes:
        client: The client it lives in.
        id: Bullet's number for it; known here and in `world` only.
        name: What people call it.
        links: Link name to Bullet's index; the base is -1.
        joints: Joint name to `JointInfo`, fixed ones included.
    """

    def __init__(
        self,
        client: Client,
        body_id: int,
        name: str,
        links: Mapping[str, int],
        extent: Box | None,
    ) -> None:
        self.client = client
        self.id = body_id
        self.name = name
        self.links: Mapping[str, int] = MappingProxyType(dict(links))
        self._link_names = {index: name for name, index in links.items()}
        self.joints: Mapping[str, JointInfo] = MappingProxyType(_read_joints(client, body_id))
        self._extent = extent
        self._bullet = client.bullet
        base_from_com = inertial_frame(client, body_id, BASE)
        self._base_from_com = base_from_com
        self._com_from_base = base_from_com.inverse()
        # Where the two frames coincide, as for most single objects, no arithmetic is needed.
        self._base_is_com = base_from_com == Pose()
        self._inertias = {index: _inertia(client, body_id, index) for index in self.indices}
        self._mass_ratio = 1.0, 1.0
        self._added: dict[int, Mapping[int, AddedInertia]] = {}

    def __repr__(self) -> str:
        return f"Body({self.name!r}, id={self.id})"

    @property
    def indices(self) -> tuple[int, ...]:
        """Indices of all links, the base (-1) first."""
        return (BASE, *range(len(self.joints)))

    def link_name(self, index: int) -> str:
        """The name of a link or part; the body's own for one that has none."""
        return self._link_names.get(index, self.name)

    def called(self, link: str) -> str:
        """The body's name, with that of a link or part if there are several: ``table.top``."""
        return f"{self.name}.{link}" if len(self.links) > 1 else self.name

    # Poses and velocities

    def pose(self) -> Pose:
        """Pose of the base link frame in the world."""
        position, quaternion = self._bullet.getBasePositionAndOrientation(self.id)
        world_from_com = Pose(position, quaternion)
        return world_from_com if self._base_is_com else world_from_com @ self._com_from_base

    def place(self, pose: Pose) -> None:
        """Put the base link frame at a pose in the world, at rest.

        Joints stay as they are. Contacts are stale until `Client.collide` or the next step.
        """
        world_from_com = pose @ self._base_from_com
        self._bullet.resetBasePositionAndOrientation(
            self.id, world_from_com.position, world_from_com.quaternion
        )
        self._bullet.resetBaseVelocity(self.id, ORIGIN, ORIGIN)

    def velocity(self) -> Velocity:
        """Velocity of the base link frame's origin."""
        linear, angular = self._bullet.getBaseVelocity(self.id)
        if self._base_is_com:
            return Velocity(linear, angular)
        position, quaternion = self._bullet.getBasePositionAndOrientation(self.id)
        arm = subtract(Pose(position, quaternion).apply(self._com_from_base.position), position)
        return Velocity(add(linear, cross(angular, arm)), angular)

    def link_pose(self, index: int) -> Pose:
        """Pose of a link's frame in the world."""
        if index == BASE:
            return self.pose()
        # Without forward kinematics Bullet answers with poses one physics step old.
        state = self._bullet.getLinkState(self.id, index, computeForwardKinematics=1)
        return Pose(state[4], state[5])

    def pose_of(self, link: str) -> Pose:
        """Pose of a link's frame in the world, by the name of the link."""
        return self.link_pose(self.links[link])

    def link_state(self, index: int) -> LinkState:
        """Pose and velocity of a link's frame, in one call to Bullet."""
        if index == BASE:
            return LinkState(self.pose(), self.velocity())
        com, _, _, _, origin, quaternion, linear, angular = self._bullet.getLinkState(
            self.id, index, computeLinkVelocity=1, computeForwardKinematics=1
        )
        at_origin = add(linear, cross(angular, subtract(origin, com)))
        return LinkState(Pose(origin, quaternion), Velocity(at_origin, angular))

    def center_of_mass(self, link: str) -> Vec3:
        """Centre of mass of a link in the world, by the name of the link."""
        index = self.links[link]
        if index == BASE:
            position: Vec3 = self._bullet.getBasePositionAndOrientation(self.id)[0]
        else:
            position = self._bullet.getLinkState(self.id, index, computeForwardKinematics=1)[0]
        return position

    def mass_of(self, link: str) -> float:
        """Mass of a link in kilograms as built, by the name of the link."""
        return self._inertias[self.links[link]][0]

    def push(self, force: Vec3) -> None:
        """Pull at the centre of mass of the base with a force (N) during the next physics step."""
        center = self._bullet.getBasePositionAndOrientation(self.id)[0]
        self._bullet.applyExternalForce(self.id, BASE, force, center, p.WORLD_FRAME)

    def bounds(self) -> Box:
        """Box around all collision shapes, in the base link frame, joints at zero.

        Raises:
            SimulationError: The body has no collision shape.
        """
        if self._extent is None:
            raise SimulationError(f"{self.name} has no collision shape, so no bounds")
        return self._extent

    def occupied(self) -> Box:
        """Box around all links in the world as they stand, a little loose."""
        ends = [self._bullet.getAABB(self.id, index) for index in self.indices]
        return bounding_box([corner for low_high in ends for corner in low_high])

    # Joints

    def joint_states(self, indices: Sequence[int]) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Positions (rad or m) and velocities of joints, in the given order."""
        if not indices:
            return (), ()
        positions, velocities, *_ = zip(*self._bullet.getJointStates(self.id, indices), strict=True)
        return positions, velocities

    def joint_position(self, joint: str) -> float:
        """Position of a joint (rad or m), by its name."""
        return self.joint_states((self.joints[joint].index,))[0][0]

    def all_joint_states(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Positions and velocities of all joints, fixed ones included, in their own order."""
        return self.joint_states(range(len(self.joints)))

    def joint_speeds(self, indices: Sequence[int]) -> tuple[float, ...]:
        """Velocities of joints (rad/s or m/s), in the given order."""
        return tuple(state[1] for state in self._bullet.getJointStates(self.id, indices))

    def put_joints(self, positions: Mapping[str, float]) -> None:
        """Put joints at positions (rad or m) by their names; see `reset_joints`."""
        self.reset_joints([self.joints[name].index for name in positions], [*positions.values()])

    def reset_joints(self, indices: Sequence[int], positions: Sequence[float]) -> None:
        """Put joints at positions, at rest, past all limits and motors."""
        for index, position in zip(indices, positions, strict=True):
            self._bullet.resetJointState(self.id, index, position, 0.0)

    def set_joint_friction(self, index: int, force: float) -> None:
        """Hold a joint against forces up to this one (N or Nm), as a drawer's runner does."""
        self._bullet.setJointMotorControl2(
            self.id, index, p.VELOCITY_CONTROL, targetVelocity=0.0, force=force
        )

    def drop_joint_damping(self, index: int) -> None:
        """Take away the damping that a joint has by its URDF."""
        self._bullet.changeDynamics(self.id, index, jointDamping=0.0)

    # Properties

    @property
    def mass(self) -> float:
        """Mass of all links in kilograms; 0 for a body that cannot move."""
        wanted, built = self._mass_ratio
        return total(mass for mass, _ in self._inertias.values()) * wanted / built

    def set_mass(self, mass: float) -> None:
        """Change the mass (kg), keeping how it is spread. No snapshot restores it.

        Raises:
            SimulationError: The body is static, or the mass is not above zero.
        """
        built = total(link_mass for link_mass, _ in self._inertias.values())
        if built <= 0.0:
            raise SimulationError(f"{self.name} is static: it has no mass to change")
        if not 0.0 < mass < float("inf"):
            raise SimulationError(f"{self.name}: a mass must be above 0 kg, not {mass}")
        self._mass_ratio = mass, built
        for index in self._inertias:
            self._set_inertia(index)

    def add_inertia(self, joint: int, added: Mapping[int, AddedInertia]) -> None:
        """Add to the inertia of links on behalf of a joint, in place of what it added before.

        It scales with the mass of the body. No snapshot restores it.

        Args:
            joint: Index of the joint.
            added: What is added, by index of the link; empty for nothing.
        """
        before = self._added.get(joint, {})
        self._added[joint] = added
        for index in {**before, **added}:
            self._set_inertia(index)

    def inertia(self, index: int) -> tuple[float, Vec3]:
        """Mass (kg) and principal moments (kg·m²) of a link as built."""
        return self._inertias[index]

    def _set_inertia(self, index: int) -> None:
        mass, moments = self._inertias[index]
        # In the order of joints, so that sums do not depend on which was locked first.
        for joint in sorted(self._added):
            more = self._added[joint].get(index)
            if more is not None:
                x, y, z = (moment + more.moment for moment in moments)
                mass, moments = mass + more.mass, (x, y, z)
        wanted, built = self._mass_ratio
        scaled = [moment * wanted / built for moment in moments]
        set_inertia(self.client, self.id, index, mass * wanted / built, scaled)

    def set_friction(self, lateral: float, links: Sequence[int] | None = None) -> None:
        """Change the friction coefficient of some links, or all. No snapshot restores it."""
        for index in self.indices if links is None else links:
            self._bullet.changeDynamics(self.id, index, lateralFriction=lateral)

    def set_rolling_friction(self, rolling: float) -> None:
        """Change the torque against rolling of every link (m). No snapshot restores it."""
        for index in self.indices:
            self._bullet.changeDynamics(self.id, index, rollingFriction=rolling)

    def set_restitution(self, restitution: float) -> None:
        """Change how much speed a bounce keeps, 0 to 1. No snapshot restores it."""
        for index in self.indices:
            self._bullet.changeDynamics(self.id, index, restitution=restitution)

    def set_grip(self, index: int, friction: float) -> None:
        """Make a link hold what it presses on, as a soft pad does.

        Its friction is anchored to where it took hold: without that, a solver that stops early
        lets a held object creep by a millimetre a second. And it resists turning on the spot: the
        solver likes to put all of a pad's force on one point, about which a long object would
        swing when the arm sets off.
        """
        self._bullet.changeDynamics(
            self.id, index, lateralFriction=friction, frictionAnchor=1, spinningFriction=PAD_M
        )

    def raise_inertia(self, index: int, least: float) -> None:
        """Give a link principal moments of at least this much, in kg·m²."""
        mass, moments = _inertia(self.client, self.id, index)
        set_inertia(self.client, self.id, index, mass, [max(least, m) for m in moments])

    def colors(self) -> dict[int, RGBA]:
        """The colour of every link that has a look, by index; that of its last shape."""
        return {data[1]: data[7] for data in self._bullet.getVisualShapeData(self.id)}

    def set_color(self, color: RGBA, index: int | None = None) -> None:
        """Paint one link, or all."""
        for link in self.indices if index is None else (index,):
            self._bullet.changeVisualShape(self.id, link, rgbaColor=color)
        self.client.looks += 1


def inertial_frame(client: Client, body_id: int, index: int) -> Pose:
    """Pose of a link's centre-of-mass frame in the link's frame."""
    info = client.bullet.getDynamicsInfo(body_id, index)
    return Pose(info[3], info[4])


def set_inertia(
    client: Client, body_id: int, index: int, mass: float, moments: Sequence[float]
) -> None:
    """Set a link's mass (kg) and principal moments (kg·m²); Bullet guesses moments otherwise."""
    client.bullet.changeDynamics(body_id, index, mass=mass, localInertiaDiagonal=moments)


def _inertia(client: Client, body_id: int, index: int) -> tuple[float, Vec3]:
    info: Sequence[Any] = client.bullet.getDynamicsInfo(body_id, index)
    return info[0], info[2]


def _read_joints(client: Client, body_id: int) -> dict[str, JointInfo]:
    joints = {}
    for index in range(client.bullet.getNumJoints(body_id)):
        info = client.bullet.getJointInfo(body_id, index)
        name, kind = info[1].decode(), _JOINT_TYPES.get(info[2])
        if kind is None:
            raise SimulationError(f"joint {name}: only revolute, prismatic and fixed joints work")
        lower, upper = info[8], info[9]
        if kind == "revolute" and lower > upper:  # how Bullet marks a joint without limits
            lower, upper = float("-inf"), float("inf")
        joints[name] = JointInfo(index, kind, lower, upper, info[11], info[10], index, info[16])
    return joints
