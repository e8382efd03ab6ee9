from __future__ import annotations

import re

import pytest
from moves import bench, state
from written_tasks import NAMES

from taskbuilder.errors import FileError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import read_task
from taskbuilder.world.building import build_world

WEDGE = """
v 0 0 0
v 0.1 0 0
v 0 0.1 0
v 0 0 0.1
f 1 3 2
f 1 2 4
f 2 3 4
f 3 1 4
"""

CABINET = """<robot name="cabinet">
  <link name="case">
    <inertial><mass value="5"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.15"/><geometry><box size="0.3 0.3 0.02"/></geometry></collision>
    <visual><origin xyz="0 0 0.15"/><geometry><box size="0.3 0.3 0.02"/></geometry></visual>
  </link>
  <link name="drawer">
    <inertial><mass value="0.5"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.25 0.25 0.1"/></geometry></collision>
    <visual><geometry><box size="0.25 0.25 0.1"/></geometry></visual>
  </link>
  <joint name="slide" type="prismatic">
    <parent link="case"/><child link="drawer"/><origin xyz="0 0 0.05"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.2" effort="50" velocity="1"/>
  </joint>
</robot>
"""

CROWD = """
timing: {control_hz: 20, physics_hz: 120}
scene:
  robots:
    first: {model: ur5e, base: {position: [-1, 0, 0]}}
    second: {model: panda, base: {position: [1, 0, 0], rpy_deg: [0, 0, 180]}}
    third: {model: ur5e, base: {position: [0, 1.5, 0], rpy_deg: [0, 0, -90]}}
  objects:
    wedge: {shape: {mesh: wedge.obj, scale: 0.5}, mass: 0.1, position: [0, 0, 0.001]}
    cabinet:
      shape: {urdf: cabinet.urdf}
      fixed: true
      joints: {slide: 0.05}
      grasps: {top: {at: [0, 0, 0.16]}}
      position: [0, -1, 0.01]
      rpy_deg: [0, 0, 90]
"""


@pytest.fixture
def crowd(build, tmp_path):
    (tmp_path / "wedge.obj").write_text(WEDGE, encoding="utf-8")
    (tmp_path / "cabinet.urdf").write_text(CABINET, encoding="utf-8")
    world = build(CROWD)
    world.reset(0)
    return world


def test_three_robots_of_two_models_stand_where_they_are_put(crowd):
    assert crowd.robot_names == ("first", "second", "third")
    for name, position in (("first", (-1, 0, 0)), ("second", (1, 0, 0)), ("third", (0, 1.5, 0))):
        assert crowd.position(f"{name}.base") == pytest.approx(position, abs=1e-6)
        robot = crowd.robots[name]
        assert robot.arm_state()[0] == pytest.approx(robot.model.home, abs=1e-2)
    assert len(crowd.robots["second"].home) == 7
    for step in range(1, 6):
        turn = 0.02 * step
        crowd.step({name: [j + turn for j in robot.home] for name, robot in crowd.robots.items()})
    for robot in crowd.robots.values():
        assert robot.arm_state()[0] == pytest.approx([j + 0.1 for j in robot.home], abs=0.02)


def test_a_mesh_has_its_size_and_rests_on_the_floor(crowd):
    assert crowd.box("wedge").half == pytest.approx((0.025, 0.025, 0.025), abs=1e-6)
    for _ in range(20):
        crowd.step()
    assert crowd.support("wedge", "cabinet") == 0.0
    assert crowd.position("wedge")[2] == pytest.approx(0.0, abs=5e-3)


def test_a_drawer_opens_as_written_and_carries_its_frames(crowd):
    assert crowd.joint("cabinet.slide") == pytest.approx(0.05, abs=1e-3)
    assert crowd.position("cabinet.drawer") == pytest.approx((0, -0.95, 0.06), abs=1e-3)
    assert crowd.position("cabinet.top") == pytest.approx((0, -1, 0.17), abs=1e-6)
    assert crowd.box("cabinet.drawer").half == pytest.approx((0.125, 0.125, 0.05))
    body = crowd.objects["cabinet"].body
    index = body.joints["slide"].index
    crowd.client.bullet.resetJointState(body.id, index, 0.05, 0.1)
    crowd.refresh()
    linear, _ = crowd.velocity("cabinet.drawer")
    assert linear == pytest.approx((0.0, 0.1, 0.0), abs=1e-6)
    assert crowd.velocity("cabinet.top")[0] == (0.0, 0.0, 0.0)
    for _ in range(20):
        crowd.step()
    resting = crowd.joint("cabinet.slide")
    assert 0.0 <= resting < 0.07  # its runner brakes it
    crowd.reset(1)
    assert crowd.joint("cabinet.slide") == pytest.approx(0.05, abs=1e-3)


def colors(world, name):
    body = world.objects[name].body
    return {shape[7] for shape in world.client.bullet.getVisualShapeData(body.id)}


def test_a_colour_of_the_task_file_paints_every_link_of_a_urdf(build, tmp_path):
    (tmp_path / "wedge.obj").write_text(WEDGE, encoding="utf-8")
    paint = '<visual><material name="m"><color rgba="0 0 1 1"/></material>'
    painted = CABINET.replace("<visual>", paint)
    (tmp_path / "cabinet.urdf").write_text(painted, encoding="utf-8")
    plain = build(CROWD)
    assert colors(plain, "cabinet") == {(0.0, 0.0, 1.0, 1.0)}
    red = build(CROWD.replace("fixed: true", "fixed: true\n      color: '#ff0000'"))
    assert colors(red, "cabinet") == {(1.0, 0.0, 0.0, 1.0)}


def test_what_a_task_file_says_of_a_urdfs_surface_holds_for_every_link(build, tmp_path):
    (tmp_path / "wedge.obj").write_text(WEDGE, encoding="utf-8")
    (tmp_path / "cabinet.urdf").write_text(CABINET, encoding="utf-8")
    said = "fixed: true\n      restitution: 0.5\n      rolling_friction: 0.01"
    world = build(CROWD.replace("fixed: true", said))
    body = world.objects["cabinet"].body
    for link in body.indices:
        info = world.client.bullet.getDynamicsInfo(body.id, link)
        assert (info[5], info[6]) == pytest.approx((0.5, 0.01))


def test_a_home_out_of_reach_is_refused_where_it_is_written(build):
    with pytest.raises(FileError, match="arm cannot reach this pose") as caught:
        build(bench(height=3.0))
    (finding,) = caught.value.findings
    assert (finding.code, finding.path) == ("TB303", "scene.robots.arm.home.tcp")
    assert finding.location is not None


@pytest.mark.parametrize("far", ["[2.5, 0, 0.6]", "[0.2, -1.9, 1.4]"])
def test_the_position_that_is_named_instead_of_one_out_of_reach_is_reached(build, far):
    home = re.compile(r"(home: \{tcp: \{position: )(\[.*?\])")
    assert home.search(bench())
    with pytest.raises(FileError) as caught:
        build(home.sub(rf"\g<1>{far}", bench()))
    (finding,) = caught.value.findings
    said = re.search(r"; turned like this, it reaches position: (\[.*?\]); or ", finding.message)
    assert said
    build(home.sub(rf"\g<1>{said[1]}", bench()))


def test_a_home_turned_so_that_nothing_is_reached_is_to_be_turned(build):
    inside = bench().replace("rpy_deg: [180, 0, 0]", "rpy_deg: [0, 0, 0]")
    assert inside != bench()
    with pytest.raises(FileError, match="turn the tool"):
        build(re.sub(r"(home: \{tcp: \{position: )\[.*?\]", r"\g<1>[0.05, 0, 0.1]", inside))


@pytest.mark.parametrize("name", NAMES)
def test_every_task_of_the_library_builds_without_warnings(library, name):
    world = library[name]
    assert world.warnings == ()
    assert world.floor is not None
    assert set(world.objects) == set(world.scene.objects)
    assert set(world.sites) == set(world.scene.sites)


def test_a_variation_is_built_as_its_scene_says(build):
    text = bench() + "variations:\n  - {block.mass: 0.4}\n"
    assert build(text).objects["block"].body.mass == pytest.approx(0.1)
    assert build(text, variation=1).objects["block"].body.mass == pytest.approx(0.4)


def test_building_twice_gives_the_same_world_to_the_bit():
    catalogue = Catalogue.discover()
    file = read_task(catalogue.task("handover"), catalogue)
    one, other = build_world(file), build_world(file)
    try:
        assert state(one) == state(other)
    finally:
        one.close()
        other.close()
