from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Pose, norm, scale, subtract, turn_between
from taskbuilder.shapes import BoxShape, MeshShape, Part, SphereShape
from taskbuilder.sim.bodies import create_body, load_urdf
from taskbuilder.sim.bullet import p
from taskbuilder.sim.contacts import contacts

TILTED = Pose.from_rpy_deg((0.1, -0.2, 0.6), (30, 40, 50))

OFF_CENTRE_URDF = """
<robot name="door">
  <link name="frame">
    <inertial>
      <origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/>
      <mass value="2"/>
      <inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision>
      <origin xyz="0.5 0 0" rpy="0 0 1.5707963267948966"/>
      <geometry><box size="0.2 0.4 0.6"/></geometry>
    </collision>
    <collision>
      <origin xyz="0 0 1" rpy="1.5707963267948966 0 0"/>
      <geometry><cylinder radius="0.1" length="0.4"/></geometry>
    </collision>
  </link>
  <link name="leaf">
    <inertial>
      <origin xyz="0 0.1 0"/>
      <mass value="1"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="frame"/>
    <child link="leaf"/>
    <origin xyz="0 0 0.5"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="2" effort="3" velocity="4"/>
  </joint>
</robot>
"""


@pytest.fixture
def door_file(tmp_path: Path) -> Path:
    path = tmp_path / "door.urdf"
    path.write_text(OFF_CENTRE_URDF)
    return path


def assert_same_pose(found: Pose, wanted: Pose, tolerance: float = 1e-9) -> None:
    assert norm(subtract(found.position, wanted.position)) < tolerance
    assert turn_between(found.quaternion, wanted.quaternion) < tolerance


def test_parts_are_links_named_after_them(tray):
    assert tray.links == {"floor": -1, "wall": 0, "left_handle": 1, "right_handle": 2}
    assert tray.name == "tray"
    assert tray.mass == pytest.approx(0.4)


def test_a_contact_tells_which_part_is_touched(client, tray, make_cube):
    tray.place(Pose((0.0, 0.0, 0.3)))
    left, right = make_cube((-0.16, 0.0, 0.42)), make_cube((0.16, 0.0, 0.42))
    client.collide()
    assert {c.link_a for c in contacts(client, tray, left)} == {tray.links["left_handle"]}
    assert {c.link_a for c in contacts(client, tray, right)} == {tray.links["right_handle"]}


@pytest.mark.parametrize("fixed_base", [True, False])
def test_poses_are_of_the_base_link_not_of_its_centre_of_mass(client, door_file, fixed_base):
    body = load_urdf(client, door_file, pose=TILTED, fixed_base=fixed_base)
    assert_same_pose(body.pose(), TILTED)
    body.place(Pose((1.0, 2.0, 3.0)))
    assert_same_pose(body.pose(), Pose((1.0, 2.0, 3.0)))
    assert_same_pose(body.link_pose(body.links["leaf"]), Pose((1.0, 2.0, 3.5)), 1e-6)


def test_a_compound_is_where_it_was_put(client, tray):
    tray.place(TILTED)
    assert_same_pose(tray.pose(), TILTED)
    for index in tray.links.values():
        assert_same_pose(tray.link_pose(index), TILTED, 1e-6)


def test_a_compound_turns_as_if_cut_from_one_piece(client):
    # A bar cut into three unequal parts against the bar whole.
    cut = {
        "middle": Part(BoxShape((0.1, 0.04, 0.02)), Pose((0.02, 0.0, 0.0))),
        "left": Part(BoxShape((0.17, 0.04, 0.02)), Pose((-0.115, 0.0, 0.0))),
        "right": Part(
            BoxShape((0.04, 0.13, 0.02)), Pose.from_rpy_deg((0.135, 0.0, 0.0), (0, 0, 90))
        ),
    }
    apart = (0.0, 0.0, 5.0)
    whole = create_body(client, {"bar": Part(BoxShape((0.4, 0.04, 0.02)))}, mass=0.7, pose=TILTED)
    pieces = create_body(client, cut, mass=0.7, pose=TILTED.moved(apart))
    for body in (whole, pieces):
        pushed = body.pose().apply((0.1, 0.01, 0.0))
        client.bullet.applyExternalForce(body.id, -1, (0.0, 3.0, 8.0), pushed, p.WORLD_FRAME)
    client.step(60)
    assert turn_between(TILTED.quaternion, whole.pose().quaternion) > 1.0
    # Bullet's air drag acts on the first part alone, which leaves a small difference.
    assert_same_pose(pieces.pose(), whole.pose().moved(apart), 5e-3)


def test_velocity_is_that_of_the_frame_origin(client, door_file):
    body = load_urdf(client, door_file, pose=TILTED, fixed_base=False)
    client.bullet.resetBaseVelocity(body.id, (0.1, 0.2, 0.3), (1.0, 2.0, 3.0))
    before, stated = body.pose(), body.velocity()
    client.bullet.setGravity(0, 0, 0)
    client.step(1)
    moved = scale(subtract(body.pose().position, before.position), client.physics_hz)
    assert norm(subtract(moved, stated.linear)) < 0.05
    assert norm(subtract(moved, (0.1, 0.2, 0.3))) > 0.2


def test_link_state_is_of_this_step_and_of_the_link_origin(client, panda, panda_arm):
    panda_arm.velocity([0.3, -0.2, 0.4, 0.1, 0.2, 0.3, 0.4])
    client.step(30)
    before = panda.link_state(8)
    client.step(1)
    after = panda.link_state(8)
    difference = scale(subtract(after.pose.position, before.pose.position), client.physics_hz)
    assert norm(after.velocity.linear) > 0.05
    assert norm(subtract(difference, after.velocity.linear)) < 0.01 * norm(difference) + 2e-3
    assert after.pose == panda.link_pose(8)


def test_placing_a_body_brings_it_to_rest(client, make_cube):
    cube = make_cube((0.0, 0.0, 1.0))
    client.step(30)
    cube.place(Pose((0.0, 0.0, 1.0)))
    assert cube.velocity() == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_joints_are_described_and_start_free(client, door_file):
    door = load_urdf(client, door_file, fixed_base=True)
    hinge = door.joints["hinge"]
    assert (hinge.type, hinge.lower, hinge.upper) == ("revolute", -1.0, 2.0)
    assert (hinge.effort, hinge.velocity, hinge.child) == (3.0, 4.0, door.links["leaf"])
    door.reset_joints([hinge.index], [0.5])
    assert door.joint_states([hinge.index]) == ((0.5,), (0.0,))
    client.bullet.applyExternalTorque(door.id, hinge.index, (0.0, 0.0, 0.2), p.WORLD_FRAME)
    client.step(5)
    assert door.joint_states([hinge.index])[1][0] > 0.005


def test_joint_friction_holds_a_joint(client, door_file):
    door = load_urdf(client, door_file, fixed_base=True)
    hinge = door.joints["hinge"].index
    door.set_joint_friction(hinge, 1.0)
    client.bullet.applyExternalTorque(door.id, hinge, (0.0, 0.0, 0.2), p.WORLD_FRAME)
    client.step(5)
    assert abs(door.joint_states([hinge])[1][0]) < 1e-6


def test_bounds_enclose_all_shapes_in_the_base_frame(client, door_file, tray):
    door = load_urdf(client, door_file, pose=TILTED, fixed_base=True)
    assert door.bounds().low == pytest.approx((-0.1, -0.2, -0.3), abs=1e-6)
    assert door.bounds().high == pytest.approx((0.7, 0.2, 1.1), abs=1e-6)
    assert tray.bounds().low == pytest.approx((-0.17, -0.1, -0.005))
    assert tray.bounds().high == pytest.approx((0.17, 0.1, 0.1))


def test_bounds_of_a_ball_are_the_same_however_it_is_turned(client):
    ball = create_body(client, {"ball": Part(SphereShape(0.03))}, mass=0.1)
    assert ball.bounds().seen_from(TILTED).half == pytest.approx((0.03, 0.03, 0.03))


def test_scale_applies_to_bounds_and_joints(client, door_file):
    door = load_urdf(client, door_file, fixed_base=True, scale=2.0)
    assert door.bounds().high == pytest.approx((1.4, 0.4, 2.2), abs=1e-6)


def test_a_static_mesh_is_hollow_and_a_moving_one_is_its_hull(client, tmp_path, make_cube):
    # An open box: four walls and a floor, as one mesh.
    path = tmp_path / "bin.obj"
    vertices = [(x, y, z) for z in (0.0, 0.2) for y in (-0.2, 0.2) for x in (-0.2, 0.2)]
    faces = ["1 2 4 3", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    path.write_text(
        "\n".join([f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {face}" for face in faces])
    )
    create_body(client, {"bin": Part(MeshShape(path))})
    inside = make_cube((0.0, 0.0, 0.1))
    create_body(client, {"bin": Part(MeshShape(path))}, mass=5.0, pose=Pose((2.0, 0.0, 0.01)))
    create_body(client, {"floor": Part(BoxShape((2.0, 2.0, 0.02)))}, pose=Pose((2.0, 0.0, -0.01)))
    above = make_cube((2.0, 0.0, 0.3))
    client.step(240)
    assert inside.pose().position[2] == pytest.approx(0.02, abs=3e-3)
    assert above.pose().position[2] == pytest.approx(0.22, abs=3e-3)


def test_mass_can_be_changed_and_keeps_its_spread(client, tray):
    def moments() -> list[float]:
        return [
            m for i in tray.links.values() for m in client.bullet.getDynamicsInfo(tray.id, i)[2]
        ]

    before = moments()
    tray.set_mass(1.2)
    assert tray.mass == pytest.approx(1.2)
    assert moments() == pytest.approx([3 * moment for moment in before])
    tray.set_mass(0.4)
    assert moments() == pytest.approx(before)


def test_friction_decides_whether_a_cube_slides(client):
    slope = Pose.from_rpy_deg((0.0, 0.0, 0.0), (0, 20, 0))
    create_body(client, {"slope": Part(BoxShape((4.0, 4.0, 0.1)))}, pose=slope, friction=1.0)
    start = slope @ Pose((0.0, 0.0, 0.07))
    cube = create_body(client, {"cube": Part(BoxShape((0.04,) * 3))}, mass=0.1, pose=start)

    def slid() -> float:
        cube.place(start)
        client.step(60)
        return norm(subtract(cube.pose().position, start.position))

    cube.set_friction(0.8)
    stuck = slid()
    cube.set_friction(0.05)
    assert stuck < 0.03 < 0.2 < slid()


@pytest.mark.parametrize(
    ("parts", "mass", "message"),
    [
        ({}, 1.0, "at least one part"),
        ({"a": Part(SphereShape(0.1))}, -1.0, "mass"),
        ({"a": Part(SphereShape(0.1))}, math.nan, "mass"),
        ({"a": Part(SphereShape(0.0))}, 1.0, "above 0"),
        ({"a": Part(MeshShape(Path("missing.obj")))}, 1.0, "missing.obj"),
    ],
)
def test_bodies_that_make_no_sense_are_refused(client, parts, mass, message):
    with pytest.raises(SimulationError, match=message):
        create_body(client, parts, mass=mass)


def test_masses_that_make_no_sense_are_refused(table, tray):
    with pytest.raises(SimulationError, match="static"):
        table.set_mass(1.0)
    with pytest.raises(SimulationError, match="above 0"):
        tray.set_mass(0.0)


def test_a_body_that_does_not_collide_has_no_bounds(client, make_cube):
    marker = create_body(client, {"goal": Part(SphereShape(0.1))}, collides=False)
    cube = make_cube((0.0, 0.0, 0.0))
    client.step(10)
    assert contacts(client, cube) == ()
    with pytest.raises(SimulationError, match="no collision shape"):
        marker.bounds()


def test_a_missing_urdf_is_a_simulation_error(client, tmp_path):
    with pytest.raises(SimulationError, match="loadURDF"):
        load_urdf(client, tmp_path / "missing.urdf", fixed_base=True)


def test_rolling_friction_slows_what_rolls(client, table):
    def rolled(rolling_friction: float) -> float:
        ball = create_body(
            client,
            {"ball": Part(SphereShape(0.05))},
            mass=0.2,
            pose=Pose((0.0, 0.0, 0.05)),
            rolling_friction=rolling_friction,
        )
        client.bullet.resetBaseVelocity(ball.id, (0.3, 0.0, 0.0), (0.0, 6.0, 0.0))
        client.step(120)
        ball.place(ball.pose().moved((0.0, 0.5, 0.0)))
        return ball.pose().position[0]

    assert rolled(0.0) == pytest.approx(0.3, rel=0.1)
    assert rolled(0.002) < 0.25


def test_building_worlds_again_and_again_does_not_grow_memory():
    script = """
import resource
from taskbuilder.geometry import Pose
from taskbuilder.sim.bodies import create_body
from taskbuilder.shapes import BoxShape, Part
from taskbuilder.sim.client import Client
from taskbuilder.sim.snapshots import release, restore, save

def episode():
    with Client(physics_hz=120) as client:
        create_body(client, {"floor": Part(BoxShape((2, 2, 0.1)))})
        create_body(client, {"cube": Part(BoxShape((0.1,) * 3))}, mass=1, pose=Pose((0, 0, 0.2)))
        for _ in range(3):
            start = save(client)
            for _ in range(20):
                client.step(10)
                restore(start)
            release(start)

def peak_kb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

for _ in range(10):
    episode()
before = peak_kb()
for _ in range(60):
    episode()
print(peak_kb() - before)
"""
    child = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert int(child.stdout) < 3000  # kB; one unreleased snapshot an episode would be 15 MB


def test_numpy_scalars_are_taken_for_numbers(client, make_cube):
    cube = make_cube((0.0, 0.0, 0.0))
    cube.place(Pose(tuple(np.array([1.0, 2.0, 3.0]))))
    assert cube.pose().position == (1.0, 2.0, 3.0)


def test_more_boxes_than_the_engine_takes_are_refused(client, tmp_path):
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    lines = []
    for group in range(17):
        lines.append(f"o box_{group}")
        lines += [f"v {x + 2 * group} {y} {z}" for x, y, z in corners]
        lines.append(f"f {8 * group + 1} {8 * group + 2} {8 * group + 3}")
        lines.append(f"f {8 * group + 5} {8 * group + 7} {8 * group + 8}")
    file = tmp_path / "row.obj"
    file.write_text("\n".join(lines) + "\n")
    with pytest.raises(SimulationError, match=r"row\.obj has 17 groups, .* at most 16 boxes"):
        create_body(client, {"row": Part(MeshShape(file, collide="boxes"))}, mass=1.0)
