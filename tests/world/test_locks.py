"""Locked joints hold against the robots of the library, which push and turn with full force."""

from __future__ import annotations

import math
from functools import cache
from itertools import product

import numpy as np
import pytest
from moves import squeeze, state

from taskbuilder.geometry import Pose, from_rpy_deg, turn_between
from taskbuilder.kinematics.inverse import solve
from taskbuilder.schema.catalogue import Catalogue

# The five joints of the SO-101 do not keep its tool upright on a straight way aside.
ROBOTS = tuple(sorted(Catalogue.discover().robots.keys() - {"so101"}))
QUICK = ("gantry", "panda", "ur5e", "ur5e_pusher", "ur5e_suction")
TURNING = tuple(robot for robot in ROBOTS if robot != "ur5e_pusher")  # which can hold nothing
MOST = {"revolute": math.radians(0.5), "prismatic": 0.001}
LIGHT, HEAVY = 0.02, 5.0  # kg
PLATE = (0.5, 0.04, 0.4)

THING = """<robot name="thing">
  <link name="base">
    <inertial><mass value="2"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    {base}
  </link>
  <link name="part">
    <inertial><origin xyz="{at}"/><mass value="{mass}"/>
      <inertia ixx="{ixx}" iyy="{iyy}" izz="{izz}" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></collision>
  </link>
  <joint name="joint" type="{type}">
    <parent link="base"/><child link="part"/><axis xyz="{axis}"/>
    <limit lower="-3" upper="3" effort="100" velocity="5"/>
  </joint>
</robot>
"""

ROOM = """
timing: {control_hz: 10, physics_hz: HZ}
scene:
  floor: false
  robots:
    arm: {model: MODEL, base: {position: [0, 0, 0.5]}}
  objects:
    thing:
      shape: {urdf: thing.urdf}
      fixed: FIXED
      position: AT
      friction: 1
      joints: JOINTS
"""

LOCKED = "{joint: {friction: 0, lock: {unless: free}}}"

STOPS = """
    wall: {shape: {box: [0.5, 0.04, 0.5]}, fixed: true, position: WALL}
    shelf: {shape: {box: [0.5, 0.5, 0.02]}, fixed: true, position: SHELF}
"""


def thing(joint, mass, size, *, at=(0, 0, 0), base=""):
    """A URDF with one joint, whose part is a box with the inertia of a solid one."""
    x, y, z = size
    pairs = {"ixx": (y, z), "iyy": (x, z), "izz": (x, y)}
    moments = {name: mass / 12 * (a * a + b * b) for name, (a, b) in pairs.items()}
    return THING.format(
        type=joint,
        mass=mass,
        size=" ".join(map(str, size)),
        at=" ".join(map(str, at)),
        base=base,
        axis="0 0 1" if joint == "revolute" else "0 1 0",
        **moments,
    )


@pytest.fixture
def room(build, tmp_path):
    def make(model, urdf, at, *, hz=120, fixed=True, more="", joints=LOCKED):
        (tmp_path / "thing.urdf").write_text(urdf, encoding="utf-8")
        values = {
            "HZ": hz,
            "MODEL": model,
            "FIXED": str(fixed).lower(),
            "JOINTS": joints,
            "AT": [float(value) for value in at],
        }
        text = ROOM
        for key, value in values.items():
            text = text.replace(key, str(value))
        world = build(text + more)
        world.reset(0)
        return world

    return make


@pytest.fixture
def tool(build):
    """Where the tool of a robot is at home."""

    @cache
    def of(model):
        text = ROOM[: ROOM.index("  objects:")].replace("MODEL", model).replace("HZ", "120")
        return build(text).robots["arm"].tcp

    return of


def joints_for(world, pose):
    """Joint positions of the arm that bring its tool to a pose; None if it cannot get there."""
    arm = world.robots["arm"]
    goal, rng = arm.body.pose().inverse() @ pose, np.random.default_rng(0)
    found = solve(arm.chain, goal, start=arm.home, rng=rng)
    return np.array(found.joints) if found.ok else None


def drive(world, joints, *, steps=4, hold=12):
    """Drive the arm at full force; the positions of the joint at every physics step, in order."""
    body = world.objects["thing"].body
    index, seen, touched = body.joints["joint"].index, [], False

    def watch():
        while True:
            seen.append(body.joint_states((index,))[0][0])
            yield

    world.onlooker = watch()
    start = np.array(world.robots["arm"].commanded())
    for step in range(1, steps + hold + 1):
        share = min(step / steps, 1.0)
        world.step({"arm": tuple((start + share * (joints - start)).tolist())})
        touched |= world.touching("arm", "thing.part") or world.held("thing", "arm")
    world.onlooker = None
    assert touched
    return [*seen, body.joint_states((index,))[0][0]]


def shifted(point, y, z=0.0):
    return (np.array(point) + np.array((0.0, y, z))).tolist()


def way(world):
    """Joint positions at the end of a straight way, and its direction along y."""
    at = world.robots["arm"].tcp
    for length, sign in product((0.35, 0.25, 0.18), (1.0, -1.0)):
        joints = joints_for(world, at.moved((0.0, length * sign, 0.0)))
        if joints is not None:
            return joints, sign
    raise AssertionError("it reaches neither way")


def pushed(room, tool, model, joint, mass, *, hz=120):
    """A robot that pushes a plate which is locked; the joint's positions, and the tool's way."""
    middle = np.array(tool(model).position)
    _, sign = way(room(model, thing(joint, mass, PLATE), (9.0, 9.0, 9.0)))
    middle += (0.0, 0.12 * sign, 0.0)
    lever = 0.1 if joint == "revolute" else 0.0
    urdf = thing(joint, mass, PLATE, at=(lever, 0, 0))
    world = room(model, urdf, middle - (lever, 0.0, 0.0), hz=hz)
    squeeze(world, "arm")
    seen = drive(world, way(world)[0])
    return seen, sign * (world.robots["arm"].tcp.position[1] - middle[1])


def turned(room, tool, model, mass, *, hz=120):
    """A robot that holds a bar which is locked, and turns about its middle."""
    at = Pose(tool(model).position, from_rpy_deg((180.0, 0.0, 0.0)))
    seal = 0.021 if model == "ur5e_suction" else 0.0
    urdf = thing("revolute", mass, (0.14, 0.022, 0.04))
    world = room(model, urdf, np.array(at.position) - (0.0, 0.0, seal), hz=hz)
    arm = world.robots["arm"]
    start = joints_for(world, at)
    arm.body.reset_joints(arm.arm.indices, start)
    arm.move_arm(tuple(start.tolist()))
    world.step()
    squeeze(world, "arm", steps=8)
    assert world.held("thing", "arm")
    for yaw in (70.0, -70.0):
        joints = joints_for(world, Pose(at.position, from_rpy_deg((180.0, 0.0, yaw))))
        if joints is not None:
            return drive(world, joints, steps=5)
    raise AssertionError("it turns neither way")


@pytest.mark.parametrize("mass", [LIGHT, HEAVY])
@pytest.mark.parametrize("joint", ["revolute", "prismatic"])
@pytest.mark.parametrize(
    "model",
    [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in ROBOTS],
)
def test_a_locked_joint_does_not_give_way_to_a_robot_that_pushes(room, tool, model, joint, mass):
    seen, past = pushed(room, tool, model, joint, mass)
    assert max(map(abs, seen)) < MOST[joint]
    assert past < 0.05  # and nothing passes through it


@pytest.mark.parametrize("mass", [LIGHT, HEAVY])
@pytest.mark.parametrize(
    "model",
    [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in TURNING],
)
def test_a_locked_hinge_does_not_give_way_to_a_robot_that_turns_it(room, tool, model, mass):
    assert max(map(abs, turned(room, tool, model, mass))) < MOST["revolute"]


@pytest.mark.slow
@pytest.mark.parametrize("hz", [60, 240])
@pytest.mark.parametrize("mass", [LIGHT, 0.2, HEAVY])
@pytest.mark.parametrize("model", ROBOTS)
def test_locked_joints_hold_at_other_rates_of_the_physics(room, tool, model, mass, hz):
    for joint in MOST:
        assert max(map(abs, pushed(room, tool, model, joint, mass, hz=hz)[0])) < MOST[joint]
    if model in TURNING:
        assert max(map(abs, turned(room, tool, model, mass, hz=hz))) < MOST["revolute"]


@pytest.mark.parametrize("joint", ["revolute", "prismatic"])
@pytest.mark.parametrize("model", ["gantry", "ur5e"])
def test_a_locked_joint_of_something_that_can_move_does_not_give_way(room, tool, model, joint):
    middle = np.array(tool(model).position)
    plate = (0.2, 0.04, 0.18)
    _, sign = way(room(model, thing(joint, LIGHT, plate), (9.0, 9.0, 9.0)))
    middle += (0.0, 0.12 * sign, 0.0)
    lever = 0.1 if joint == "revolute" else 0.0
    box = f'<collision><origin xyz="{lever} {0.09 * sign} 0"/>'
    box += '<geometry><box size="0.2 0.12 0.2"/></geometry></collision>'
    stops = STOPS.replace("WALL", str(shifted(middle, 0.172 * sign)))
    stops = stops.replace("SHELF", str(shifted(middle, 0.1 * sign, -0.111)))
    urdf = thing(joint, LIGHT, plate, at=(lever, 0, 0), base=box)
    world = room(model, urdf, middle - (lever, 0.0, 0.0), fixed=False, more=stops)
    squeeze(world, "arm")
    assert max(map(abs, drive(world, way(world)[0]))) < MOST[joint]


@pytest.mark.parametrize("joint", ["revolute", "prismatic"])
def test_what_has_a_locked_joint_flies_like_one_body(room, joint):
    """A lock changes neither the mass of a thing, nor its inertia."""
    flights = []
    for kind in (joint, "fixed"):
        urdf = thing(kind, 0.5, (0.1, 0.06, 0.02), at=(0.1, 0.02, 0.05))
        joints = LOCKED if kind == joint else "{}"
        world = room("ur5e", urdf, (3.0, 0.0, 2.0), fixed=False, joints=joints)
        body = world.objects["thing"].body
        body.place(Pose((3.0, 0.0, 2.0)))
        body.client.bullet.resetBaseVelocity(body.id, (0.5, 0.0, 2.0), (1.0, 2.0, 3.0))
        for _ in range(5):
            world.step()
        flights.append(world.pose("thing"))
    locked, rigid = flights
    assert locked.position == pytest.approx(rigid.position, abs=0.002)
    assert math.degrees(turn_between(locked.quaternion, rigid.quaternion)) < 0.5


def test_a_state_in_which_a_robot_pushes_a_locked_joint_is_restored_to_the_bit(room, tool):
    middle = shifted(np.array(tool("ur5e").position) - (0.1, 0.0, 0.0), 0.12)
    world = room("ur5e", thing("revolute", LIGHT, PLATE, at=(0.1, 0, 0)), middle)
    joints = way(world)[0]
    drive(world, joints, hold=2)
    kept = world.save()

    def episode():
        seen = []
        for step in range(8):
            world.set_locks({"free": step in (3, 4, 5)})
            drive(world, joints, steps=1, hold=0)
            seen.append((state(world), dict(world.locked)))
        return seen

    first = episode()
    world.restore(kept)
    assert episode() == first


def test_a_lock_stops_what_moves(room):
    urdf = thing("prismatic", LIGHT, (0.1, 0.1, 0.1))
    world = room("ur5e", urdf, (3.0, 0.0, 2.0))
    world.set_locks({"free": True})
    body = world.objects["thing"].body
    body.client.bullet.resetJointState(body.id, 0, 0.01, 3.0)
    world.set_locks({"free": False})
    world.step()
    assert body.joint_states((0,))[0] == pytest.approx((0.01,), abs=1e-5)


def test_a_lock_does_not_change_what_a_thing_weighs(room):
    world = room("ur5e", thing("prismatic", LIGHT, (0.1, 0.1, 0.1)), (3.0, 0.0, 2.0))
    body = world.objects["thing"].body
    locked = body.mass
    world.set_locks({"free": True})
    assert body.mass == pytest.approx(locked)
