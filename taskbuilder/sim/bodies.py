"""Making bodies, from primitive parts or from a URDF file.

A body of several parts is a multibody whose parts are links fixed to the first. Bullet's compound
shapes would step a little faster (8 µs for a tray of seven parts) but report every contact on
the one link; as links, each part is known by name in a contact. The motion is the same: Bullet's
articulated-body algorithm joins the parts' inertias exactly.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.looks import MeshLook
from taskbuilder.errors import SimulationError
from taskbuilder.geometry import NO_TURN, ORIGIN, Box, Pose, Vec3, bounding_box, total
from taskbuilder.geometry import scale as scaled
from taskbuilder.shapes import (
    AT_ORIGIN,
    BoxShape,
    CapsuleShape,
    CylinderShape,
    MeshShape,
    Part,
    Shape,
    SphereShape,
    check_shape,
    mesh_groups,
    placed_bounds,
    solid,
)
from taskbuilder.sim.body import BASE, Body, set_inertia
from taskbuilder.sim.bullet import p
from taskbuilder.sim.client import Client
from taskbuilder.sim.redrawn import redrawn

NO_SHAPE = -1
READABLE = (".obj", ".stl")

MOST_BOXES = 16
"""The engine makes one shape of so many at most, and leaves out others without a word."""


@dataclass(frozen=True)
class _BodyPart:
    """A part and its share of the body's mass.

    Attributes:
        inertial: Its centre of mass and principal axes, in the body's frame.
        moments: Principal moments of inertia, kg·m².
    """

    part: Part
    mass: float
    inertial: Pose
    moments: Vec3


def create_body(
    client: Client,
    parts: Mapping[str, Part],
    *,
    name: str | None = None,
    mass: float = 0.0,
    pose: Pose = AT_ORIGIN,
    friction: float = 0.8,
    rolling_friction: float = 0.0,
    spinning_friction: float = 0.0,
    restitution: float = 0.0,
    collides: bool = True,
) -> Body:
    """Make a rigid body of named parts.

    Its mass is spread over the parts by volume, each of uniform density.

    Args:
        client: Where it lives.
        parts: Part name to part; the names become the body's ``links``, whose frames all
            coincide with the body's.
        name: What people call it; its first part's name unless given.
        mass: In kilograms; 0 makes a body that never moves.
        pose: Of the body's frame in the world.
        friction: Coulomb coefficient; Bullet multiplies those of two bodies in contact.
        rolling_friction: Torque against rolling for a unit of force, in metres. Without any, a
            cylinder that rolls in Bullet gains speed; with some, contacts of boxes cost ten
            times the solver time, of cylinders four times, of spheres next to nothing.
        spinning_friction: The same against spinning on the spot.
        restitution: 0 keeps no speed in a bounce, 1 all of it.
        collides: Whether it has collision shapes, or only a look.

    Raises:
        SimulationError: No parts, a shape or mass that makes no sense, or a mesh not readable.
    """
    name = name or next(iter(parts), "body")
    if not parts:
        raise SimulationError(f"{name}: a body needs at least one part")
    if not 0.0 <= mass < float("inf"):
        raise SimulationError(f"{name}: a mass must be 0 (static) or above, not {mass}")
    for part in parts.values():
        check_shape(part.shape)
    pieces = _weighed(list(parts.values()), mass)
    collisions = [
        _collision_shape(client, part, moving=mass > 0.0) if collides else NO_SHAPE
        for part in parts.values()
    ]
    with _folder_for_looks(client, parts) as folder:  # read with the body
        body_id = _multibody(client, name, pieces, pose, collisions, folder)
    for index, piece in enumerate(pieces, start=BASE):
        if mass:
            set_inertia(client, body_id, index, piece.mass, piece.moments)
        client.bullet.changeDynamics(
            body_id,
            index,
            lateralFriction=friction,
            rollingFriction=rolling_friction,
            spinningFriction=spinning_friction,
            restitution=restitution,
        )
    links = {part_name: index for index, part_name in enumerate(parts, start=BASE)}
    for name_of, part in parts.items():
        if collides and _collides_by(part, moving=mass > 0.0) == "exact":
            client.surfaces[body_id, links[name_of]] = part
    boxes = [placed_bounds(part.shape, part.pose) for part in parts.values() if collides]
    return Body(client, body_id, name, links, _around(boxes))


def load_urdf(
    client: Client,
    path: Path,
    *,
    name: str | None = None,
    pose: Pose = AT_ORIGIN,
    fixed_base: bool,
    scale: float = 1.0,
) -> Body:
    """Load a body from a URDF file, with its own inertias and with joints that move freely.

    Bullet crashes on malformed files and searches the working directory for meshes: the file
    must have been checked, and its meshes named by absolute paths.

    Args:
        client: Where it lives.
        path: The file.
        name: What people call it; the URDF's name unless given.
        pose: Of the base link's frame in the world.
        fixed_base: Whether the base stays where it is put.
        scale: Factor on all lengths. The density stays: masses grow by its cube, and moments of
            inertia by its fifth power. Bullet itself leaves both as they are.

    Raises:
        SimulationError: Bullet refuses the file, or it has joints of other kinds than revolute,
            prismatic and fixed.
    """
    bullet = client.bullet
    body_id: int = bullet.loadURDF(
        str(path),
        useFixedBase=fixed_base,
        globalScaling=scale,
        # Without the second flag a cylinder collides as a prism.
        flags=p.URDF_USE_INERTIA_FROM_FILE | p.URDF_USE_IMPLICIT_CYLINDER,
    )
    base_name, urdf_name = (text.decode() for text in bullet.getBodyInfo(body_id))
    links = {base_name: BASE}
    for index in range(bullet.getNumJoints(body_id)):
        links[bullet.getJointInfo(body_id, index)[12].decode()] = index
        # Bullet gives every joint a motor that brakes it.
        bullet.setJointMotorControl2(body_id, index, p.VELOCITY_CONTROL, force=0.0)
    if scale != 1.0:
        for index in links.values():
            mass, _, moments, *_ = bullet.getDynamicsInfo(body_id, index)
            larger = scaled(moments, scale**5)
            set_inertia(client, body_id, index, mass * scale**3, larger)
    # Loaded at the origin, where the world's frame is the base link's.
    boxes = [box for index in links.values() for box in _link_bounds(client, body_id, index)]
    body = Body(client, body_id, name or urdf_name, links, _around(boxes))
    body.place(pose)
    return body


def _weighed(parts: Sequence[Part], mass: float) -> list[_BodyPart]:
    """The parts with the mass spread over them by volume."""
    if not mass:
        return [_BodyPart(part, 0.0, part.pose, ORIGIN) for part in parts]
    solids = [solid(part.shape) for part in parts]
    density = mass / total(piece.volume for piece in solids)
    return [
        _BodyPart(
            part,
            density * piece.volume,
            part.pose @ piece.principal,
            scaled(piece.inertia, density * piece.volume),
        )
        for part, piece in zip(parts, solids, strict=True)
    ]


def _multibody(
    client: Client,
    name: str,
    pieces: Sequence[_BodyPart],
    pose: Pose,
    collisions: Sequence[int],
    folder: Path,
) -> int:
    """Make the first piece the base and fix the others to it, all in the body's frame."""
    visuals = [_visual_shape(client, piece.part, folder) for piece in pieces]
    base, *others = pieces
    count = len(others)
    body_id: int = client.bullet.createMultiBody(
        baseMass=base.mass,
        baseCollisionShapeIndex=collisions[0],
        baseVisualShapeIndex=visuals[0],
        basePosition=pose.position,
        baseOrientation=pose.quaternion,
        baseInertialFramePosition=base.inertial.position,
        baseInertialFrameOrientation=base.inertial.quaternion,
        linkMasses=[piece.mass for piece in others],
        linkCollisionShapeIndices=collisions[1:],
        linkVisualShapeIndices=visuals[1:],
        linkPositions=[ORIGIN] * count,
        linkOrientations=[NO_TURN] * count,
        linkInertialFramePositions=[piece.inertial.position for piece in others],
        linkInertialFrameOrientations=[piece.inertial.quaternion for piece in others],
        linkParentIndices=[0] * count,
        linkJointTypes=[p.JOINT_FIXED] * count,
        linkJointAxis=[(0.0, 0.0, 1.0)] * count,
    )
    if body_id < 0:
        raise SimulationError(f"{name}: Bullet makes no body of these parts")
    return body_id


def _around(boxes: Sequence[Box]) -> Box | None:
    if len(boxes) <= 1:
        return boxes[0] if boxes else None  # a ball keeps its own, which stays exact when it rolls
    return bounding_box([corner for box in boxes for corner in (box.low, box.high)])


def _link_bounds(client: Client, body_id: int, index: int) -> Iterator[Box]:
    """Boxes around a link's collision shapes, in the world."""
    bullet = client.bullet
    state = (
        bullet.getBasePositionAndOrientation(body_id)
        if index == BASE
        else bullet.getLinkState(body_id, index, computeForwardKinematics=1)
    )
    world_from_com = Pose(state[0], state[1])
    for _, _, kind, sizes, file, position, quaternion in bullet.getCollisionShapeData(
        body_id, index
    ):
        shape = _shape_of(kind, sizes, Path(file.decode()))
        if shape is None:
            yield Box.around(*bullet.getAABB(body_id, index))
        else:
            yield placed_bounds(shape, world_from_com @ Pose(position, quaternion))


def _shape_of(kind: int, sizes: Vec3, file: Path) -> Shape | None:
    """A shape from Bullet's account of it; None for one it does not describe."""
    if kind == p.GEOM_BOX:
        return BoxShape(sizes)
    if kind == p.GEOM_SPHERE:
        return SphereShape(sizes[0])
    if kind == p.GEOM_CYLINDER:
        return CylinderShape(radius=sizes[1], length=sizes[0])
    if kind == p.GEOM_CAPSULE:
        return CapsuleShape(radius=sizes[1], length=sizes[0])
    if kind == p.GEOM_MESH and file.suffix.lower() in READABLE:
        return MeshShape(file, sizes)
    return None


def _collides_by(part: Part, *, moving: bool) -> str:
    """How a part's mesh collides; see `MeshShape`. "" for a part without one."""
    if not isinstance(part.shape, MeshShape):
        return ""
    return part.shape.collide or ("pieces" if moving else "exact")


def _collision_shape(client: Client, part: Part, *, moving: bool) -> int:
    if isinstance(part.shape, MeshShape):
        how = _collides_by(part, moving=moving)
        if how == "boxes":
            return _boxes(client, part.shape, part)
        if how == "hull" and len(groups := mesh_groups(part.shape)) > 1:
            return _hull(client, part, np.concatenate(groups))
        flags = {"flags": p.GEOM_FORCE_CONCAVE_TRIMESH} if how == "exact" else {}
        options = _geometry(part.shape) | flags
        return _made(client.bullet.createCollisionShape, part, "collision", options)
    options = _geometry(part.shape)
    if "length" in options:
        options["height"] = options.pop("length")  # pybullet names it differently here
    return _made(client.bullet.createCollisionShape, part, "collision", options)


def _hull(client: Client, part: Part, corners: NDArray[np.float64]) -> int:
    """The convex hull of all groups of a mesh, of which the engine would make one of each."""
    points = np.unique(corners.reshape(-1, 3), axis=0).tolist()
    options = {"shapeType": p.GEOM_MESH, "vertices": points}
    return _made(client.bullet.createCollisionShape, part, "collision", options)


def _boxes(client: Client, shape: MeshShape, part: Part) -> int:
    """A box around each group of a mesh, along the axes of its file.

    Raises:
        SimulationError: There are more groups than the engine takes; it would leave out the rest.
    """
    groups = mesh_groups(shape)
    if len(groups) > MOST_BOXES:
        raise SimulationError(
            f"{shape.path.name} has {len(groups)} groups, but a shape is made of at most "
            f"{MOST_BOXES} boxes; write collide: pieces, or join groups"
        )
    ends = [(group.min(axis=(0, 1)), group.max(axis=(0, 1))) for group in groups]
    middles = [((low + high) / 2.0).tolist() for low, high in ends]
    poses = [part.pose @ Pose((x, y, z)) for x, y, z in middles]
    made: int = client.bullet.createCollisionShapeArray(
        shapeTypes=[p.GEOM_BOX] * len(ends),
        halfExtents=[np.maximum((high - low) / 2.0, 1e-4).tolist() for low, high in ends],
        collisionFramePositions=[pose.position for pose in poses],
        collisionFrameOrientations=[pose.quaternion for pose in poses],
    )
    if made < 0:
        raise SimulationError(f"Bullet makes no collision shape of {part.shape}")
    return made


@contextmanager
def _folder_for_looks(client: Client, parts: Mapping[str, Part]) -> Iterator[Path]:
    """A folder for meshes that are written anew; none if there are none, to save time."""
    looks = (part.look or part.shape for part in parts.values())
    if client.renderer == "raster" or not any(isinstance(look, MeshShape) for look in looks):
        yield Path()
        return
    with tempfile.TemporaryDirectory(prefix="taskbuilder-") as folder:
        yield Path(folder)


def _visual_shape(client: Client, part: Part, folder: Path) -> int:
    shape = part.look or part.shape
    if isinstance(shape, MeshShape) and client.renderer != "raster":
        looks = redrawn(MeshLook(shape.path, shape.scale, part.color), folder)
        if any(look.file != shape.path for look in looks):
            return _visual_shapes(client, part, looks)
    options = _geometry(part.look or part.shape)
    # Matte: plastic highlights would depend on the camera.
    options |= {"rgbaColor": part.color, "specularColor": (0.0, 0.0, 0.0)}
    return _made(client.bullet.createVisualShape, part, "visual", options)


def _visual_shapes(client: Client, part: Part, looks: Sequence[MeshLook]) -> int:
    """One look that is made of several meshes."""
    made: int = client.bullet.createVisualShapeArray(
        shapeTypes=[p.GEOM_MESH] * len(looks),
        fileNames=[str(look.file) for look in looks],
        meshScales=[look.scale for look in looks],
        rgbaColors=[look.color or part.color for look in looks],
        visualFramePositions=[part.pose.position] * len(looks),
        visualFrameOrientations=[part.pose.quaternion] * len(looks),
    )
    if made < 0:
        raise SimulationError(f"Bullet makes no visual shape of {part.shape}")
    return made


def _made(create: Callable[..., int], part: Part, prefix: str, options: dict[str, Any]) -> int:
    shape = create(
        **options,
        **{
            f"{prefix}FramePosition": part.pose.position,
            f"{prefix}FrameOrientation": part.pose.quaternion,
        },
    )
    if shape < 0:
        raise SimulationError(f"Bullet makes no {prefix} shape of {part.shape}")
    return shape


def _geometry(shape: Shape) -> dict[str, Any]:
    """What pybullet's shape functions want to be told."""
    match shape:
        case BoxShape((x, y, z)):
            return {"shapeType": p.GEOM_BOX, "halfExtents": (x / 2, y / 2, z / 2)}
        case SphereShape(radius):
            return {"shapeType": p.GEOM_SPHERE, "radius": radius}
        case CylinderShape(radius, length):
            return {"shapeType": p.GEOM_CYLINDER, "radius": radius, "length": length}
        case CapsuleShape(radius, length):
            return {"shapeType": p.GEOM_CAPSULE, "radius": radius, "length": length}
        case MeshShape(path, scale, _):
            return {"shapeType": p.GEOM_MESH, "fileName": str(path), "meshScale": scale}
