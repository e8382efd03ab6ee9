"""Build a world from a task file: a straight list of steps."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.assets.urdf import with_limits
from taskbuilder.errors import FileError
from taskbuilder.geometry import Pose
from taskbuilder.kinematics.chain import Chain
from taskbuilder.kinematics.inverse import solve
from taskbuilder.schema.agents import RobotEntry
from taskbuilder.schema.disturbances import Disturbances
from taskbuilder.schema.grasping import grasping
from taskbuilder.schema.joints import JointSpec
from taskbuilder.schema.load import TaskFile
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.robots import joint_values
from taskbuilder.schema.sites import SiteSpec
from taskbuilder.schema.values import rgb
from taskbuilder.shapes import RGBA, BoxShape, Part, bounds
from taskbuilder.sim.bodies import create_body
from taskbuilder.sim.body import BASE, Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.islands import unite
from taskbuilder.sim.passive_joints import PassiveJoint
from taskbuilder.sim.renderers import Request, choose
from taskbuilder.world.loading import Loader
from taskbuilder.world.mimics import couple_joints, mimics_of, starting
from taskbuilder.world.nearest import nearest_reached
from taskbuilder.world.placement import placement_order, put, put_aloft
from taskbuilder.world.robot import Robot
from taskbuilder.world.robot_building import arm_chain, build_robot
from taskbuilder.world.scene_objects import ObjectFrame, SceneObject, Site
from taskbuilder.world.shapes import link_box, parts_of, shape_of
from taskbuilder.world.weights import weighed
from taskbuilder.world.world import World

THICK_M, ZONE_OPACITY = 0.06, 0.35  # markers of zones, which things are seen in
FLOOR_COLOR: RGBA = (0.86, 0.87, 0.885, 1.0)


def build_world(
    task: TaskFile,
    *,
    variation: int = 0,
    renderer: Request = "auto",
    disturbances: Disturbances = (),
) -> World:
    """Build the world of a task.

    Args:
        task: Contents of the task file: ``load_task(...).file``.
        variation: Number of the variation; 0 is the task as written.
        renderer: Renderer of camera images: ``raster``, ``tiny``, ``egl`` or ``auto``; see
            `Options`.
        disturbances: What episodes have otherwise than the task file says, besides the layout.

    Raises:
        FileError: The world cannot be built from the task's files; the findings say where the
            problems are.
        SimulationError: The renderer does not work on this machine.
    """
    scene = task.scenes[variation]
    client = Client(physics_hz=task.spec.timing.physics_hz, renderer=choose(renderer))
    try:
        floor = _build_floor(client) if scene.floor else None
        with tempfile.TemporaryDirectory(prefix="taskbuilder-") as folder:
            loader = Loader(client, task, Path(folder))
            robots = {name: _build_robot(loader, name, it) for name, it in scene.robots.items()}
            objects = {name: _build_object(loader, name, it) for name, it in scene.objects.items()}
        sites = {name: _build_site(client, name, spec) for name, spec in scene.sites.items()}
        heard = tuple(loader.heard)
        world = World(task, scene, client, robots, objects, sites, floor, heard, disturbances)
        _put_all(world)
        unite(_movers(world))
        world.keep_as_built()
    except BaseException:
        client.close()
        raise
    return world


def _build_floor(client: Client) -> Body:
    """A wide floor to fall on, of which the middle is seen.

    Beyond a few metres shadows end in a hard line, which a floor that fades into the backdrop
    does not show.
    """
    wide, seen = BoxShape((20.0, 20.0, 0.1)), BoxShape((3.6, 2.6, 0.1))
    slab = Part(wide, Pose((0.0, 0.0, -0.05)), FLOOR_COLOR, look=seen)
    return create_body(client, {"floor": slab}, name="floor")


def _build_robot(loader: Loader, name: str, entry: RobotEntry) -> Robot:
    model = loader.task.robots[name]
    body = loader.urdf(model.urdf, name, entry.base.pose, fixed=True)
    chain = arm_chain(model)
    home = _home(loader, name, entry, chain)
    how = grasping(entry, model)
    return build_robot(body, name, model, chain=chain, home=home, grasping=how)


def _home(loader: Loader, name: str, entry: RobotEntry, chain: Chain) -> tuple[float, ...]:
    """Joint positions of a robot's home, by inverse kinematics where it is given as a pose."""
    model = loader.task.robots[name]
    if entry.home is None:
        return model.home
    if entry.home.joints_deg is not None:
        return joint_values(model.arm, entry.home.joints_deg)
    if entry.home.tcp is None:
        raise ValueError("a home is a tcp pose or joint positions")
    target = entry.base.pose.inverse() @ entry.home.tcp.pose
    rng = np.random.default_rng(0)  # the same home in every world
    found = solve(chain, target, start=model.home, rng=rng)
    if found.ok:
        return found.joints
    near = nearest_reached(chain, entry.base.pose, entry.home.tcp.pose, model.home)
    right = "turn the tool: turned like this, it reaches nothing between here and its base"
    if near is not None:
        at = ", ".join(f"{value:g}" for value in near)
        right = f"turned like this, it reaches position: [{at}]; or turn the tool"
    message = (
        f"{name} cannot reach this pose: it comes within {found.position_error_m * 100:.1f} cm and "
        f"{math.degrees(found.angle_error):.0f}°; {right}"
    )
    raise FileError([loader.finding("TB303", message, "scene", "robots", name, "home", "tcp")])


def _build_object(loader: Loader, name: str, spec: ObjectSpec) -> SceneObject:
    asset = loader.task.assets.get(name)
    if isinstance(asset, Urdf):
        return _build_articulated(loader, name, spec, asset)
    parts = parts_of(spec, asset, loader.task.collisions.get(name))
    body = loader.body(parts, name, spec)
    boxes = {part: bounds(made.shape) for part, made in parts.items()}
    frames = {part: written.pose for part, written in (spec.parts or {}).items()}
    in_body = {part: ObjectFrame(pose) for part, pose in frames.items()}
    return SceneObject(name, spec, body, boxes, in_body | _grasp_frames(spec, body))


def _grasp_frames(spec: ObjectSpec, body: Body) -> dict[str, ObjectFrame]:
    return {
        name: ObjectFrame(Pose(grasp.at), BASE if grasp.link is None else body.links[grasp.link])
        for name, grasp in spec.grasps.items()
    }


def _build_articulated(loader: Loader, name: str, spec: ObjectSpec, urdf: Urdf) -> SceneObject:
    size = (spec.shape.scale if spec.shape else None) or 1.0
    moving = urdf.moving_joints
    said = {j.name: spec.joint(j.name, turns=j.type != "prismatic") for j in moving}
    limited = weighed(with_limits(urdf, _limits(moving, said, size)), spec, size)
    body = loader.urdf(limited, name, spec.pose, fixed=spec.fixed, size=size)
    body.set_friction(spec.friction)
    # What a task file leaves open stays as the URDF says.
    if "color" in spec.model_fields_set:
        body.set_color((*rgb(spec.color), 1.0))
    if "rolling_friction" in spec.model_fields_set:
        body.set_rolling_friction(spec.rolling_friction)
    if "restitution" in spec.model_fields_set:
        body.set_restitution(spec.restitution)
    indices = tuple(body.joints[joint.name].index for joint in moving)
    mimics = mimics_of(urdf, size)
    start = starting({name: joint.begin or 0.0 for name, joint in said.items()}, mimics)
    body.reset_joints(indices, list(start.values()))
    couple_joints(body, mimics)
    passive = {
        joint: made
        for index, (joint, how) in zip(indices, said.items(), strict=True)
        if (made := _build_passive(body, index, how, grounded=spec.fixed))
    }
    boxes = {link.name: link_box(link.collisions, size) for link in urdf.links}
    links = tuple(link.name for link in urdf.links if urdf.moving_joints_above(link.name))
    frames = _grasp_frames(spec, body)
    ranges = {joint: how.start_between for joint, how in said.items() if how.start_between}
    return SceneObject(name, spec, body, boxes, frames, indices, links, passive, mimics, ranges)


def _limits(
    moving: Sequence[UrdfJoint], said: Mapping[str, JointSpec], size: float
) -> dict[str, tuple[float, float]]:
    """Limits that a task file gives joints, as the URDF has them before it is scaled."""
    scales = {joint.name: size if joint.type == "prismatic" else 1.0 for joint in moving}
    return {
        name: (how.range[0] / scales[name], how.range[1] / scales[name])
        for name, how in said.items()
        if how.range is not None
    }


def _build_passive(
    body: Body, index: int, how: JointSpec, *, grounded: bool
) -> PassiveJoint | None:
    """What acts on a joint; None where constant friction is all."""
    if how.damping is not None:
        body.drop_joint_damping(index)
    if not (how.damping or how.spring or how.lock):
        body.set_joint_friction(index, how.friction)
        return None
    joint = PassiveJoint(
        body,
        index,
        grounded=grounded,
        friction=how.friction,
        damping=how.damping or 0.0,
        stiffness=how.spring.stiffness if how.spring else 0.0,
        rest=how.spring.at if how.spring else 0.0,
    )
    if how.lock is not None:
        joint.lock()  # until the description is asked
    return joint


def _build_site(client: Client, name: str, spec: SiteSpec) -> Site:
    if spec.marker is None:
        return Site(name, spec, spec.pose, None, None)
    shape = shape_of(spec.marker)
    box = bounds(shape)
    zone = 2.0 * min(box.half) > THICK_M
    opacity = spec.opacity or (ZONE_OPACITY if zone else 1.0)
    part = Part(shape, Pose(), (*rgb(spec.color), opacity))
    marker = create_body(client, {name: part}, name=name, collides=False)
    return Site(name, spec, spec.pose, box, marker)


def _put_all(world: World) -> None:
    """Put what stands at a written position there, in order of dependence."""
    for name in placement_order(world.scene):
        spec = world.scene.objects.get(name) or world.scene.sites[name]
        if spec.place is None:
            put(world, name)
        elif name in world.task.names.groups:
            put_aloft(world, name)


def _movers(world: World) -> list[Body]:
    """The bodies that move, or have parts that do."""
    things = [thing for thing in world.objects.values() if thing.joints or not thing.spec.fixed]
    return [robot.body for robot in world.robots.values()] + [thing.body for thing in things]
