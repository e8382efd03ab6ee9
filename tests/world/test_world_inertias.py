"""Inertias and centres of mass of objects that their shapes and masses do not allow."""

from __future__ import annotations

import math
import re
import shutil

import pytest

from taskbuilder.assets import read_urdf
from taskbuilder.assets.model import Urdf
from taskbuilder.assets.paths import pybullet_data_folder
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import read_task
from taskbuilder.world.inertias import FAR_FACTOR, check_inertias, doubtful_inertias, inertias

BRICK = """<robot name="brick">
  <link name="brick">
    <inertial>
      <origin xyz="{center}" rpy="{rpy}"/>
      <mass value="0.1"/>
      <inertia {inertia}/>
    </inertial>
    <collision>{origin}<geometry>{shape}</geometry></collision>
  </link>
</robot>
"""
BOX = '<box size="0.02 0.04 0.06"/>'
RIGHT = 'ixx="4.33e-05" ixy="0" ixz="0" iyy="3.33e-05" iyz="0" izz="1.67e-05"'
ONES = 'ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"'
TILTED = """
timing: {control_hz: 20, physics_hz: 240}
scene:
  robots:
    arm: {model: ur5e, base: {position: [-2, 0, 0]}}
  objects:
    table: {shape: {box: [1, 1, 0.04]}, fixed: true, position: [0, 0, 0.38]}
    brick:
      shape: {urdf: lego.urdf}
      place: {surface: table, center: [0, 0], size: [0, 0], rpy_deg: [30, 0, 0]}
"""


def brick(inertia=RIGHT, shape=BOX, center="0 0 0", rpy="0 0 0", origin=""):
    return BRICK.format(inertia=inertia, shape=shape, center=center, rpy=rpy, origin=origin)


@pytest.fixture
def found(tmp_path):
    """What is found of a URDF of the given text."""

    def check(text, *, fixed=False):
        path = tmp_path / "brick.urdf"
        path.write_text(text)
        return list(check_inertias(read_urdf(path, [tmp_path], fixed=fixed), fixed=fixed))

    return check


def written_line(finding):
    """The attributes of the element that a finding says to write."""
    return re.search(r"write <inertia (.*)/>", finding.message)[1]


def test_the_moments_of_uniform_density_are_right(found):
    assert found(brick()) == []


@pytest.mark.parametrize("factor", [1.5 * FAR_FACTOR, 1e4, 0.7 / FAR_FACTOR])
def test_moments_far_from_those_of_the_shape_are_found_with_those_to_write(found, factor):
    far = re.sub(r'"([^"]+)"', lambda entry: f'"{factor * float(entry[1]):g}"', RIGHT)
    (finding,) = found(brick(far))
    assert (finding.code, finding.severity, finding.path) == ("TB422", "warning", "link brick")
    assert finding.location.line == 6
    assert written_line(finding) == RIGHT


@pytest.mark.parametrize("factor", [1.0, 0.8 * FAR_FACTOR, 1.2 / FAR_FACTOR])
def test_the_written_line_and_what_is_near_it_are_right(found, factor):
    near = re.sub(r'"([^"]+)"', lambda entry: f'"{factor * float(entry[1]):g}"', RIGHT)
    codes = {finding.code for finding in found(brick(near))}
    most = 0.1 * (0.01**2 + 0.02**2 + 0.03**2)
    assert codes == ({"TB422"} if factor * 4.33e-05 > most else set())


def test_moments_beyond_mass_times_distance_squared_are_impossible(found):
    most = 0.1 * (0.01**2 + 0.02**2 + 0.03**2)
    for moment, impossible in ((0.99 * most, False), (1.01 * most, True)):
        wrong = found(brick(f'ixx="{moment}" iyy="{moment}" izz="{moment}"'))
        assert bool(wrong) == impossible
    assert f"can have ({most:.3g})" in wrong[0].message


def test_the_moments_to_write_are_along_the_axes_of_the_inertial_frame(found):
    (finding,) = found(brick(ONES, rpy=f"0 0 {math.pi / 2}"))
    assert written_line(finding).startswith('ixx="3.33e-05" ixy="0" ixz="0" iyy="4.33e-05"')
    (finding,) = found(brick(ONES, origin=f'<origin rpy="0 {math.pi / 2} 0"/>'))
    assert written_line(finding).startswith('ixx="1.67e-05" ixy="0" ixz="0" iyy="3.33e-05"')


def test_shapes_beside_each_other_add_up(found):
    halves = (
        '<box size="0.02 0.04 0.03"/></geometry></collision><collision><origin xyz="0 0 0.03"/>'
    )
    halves += '<geometry><box size="0.02 0.04 0.03"/>'
    (finding,) = found(brick(ONES, shape=halves, center="0 0 0.015"))
    assert written_line(finding) == RIGHT


def test_what_cannot_turn_is_not_looked_at(found):
    assert found(brick(ONES), fixed=True) == []


@pytest.mark.parametrize("name", ["lego/lego.urdf", "duck_vhacd.urdf", "objects/mug.urdf"])
def test_placeholders_of_pybullet_data_are_found(name):
    folder = pybullet_data_folder()
    (finding,) = check_inertias(read_urdf(folder / name, []), fixed=False)
    assert finding.code == "TB422"
    assert finding.message.endswith("/>, in a copy of the file in the folder of the task")


def tilt(world):
    """Angle in degrees by which the brick stands on an edge."""
    across = math.degrees(world.pose("brick").tilt(1)) % 90
    return min(across, 90 - across)


def test_a_tilted_brick_falls_once_the_written_moments_are_taken(build, tmp_path):
    original = pybullet_data_folder() / "lego"
    for file in ("lego.urdf", "lego.obj"):
        shutil.copy(original / file, tmp_path)
    standing = build(TILTED)
    (finding,) = doubtful_inertias(standing.task)
    text = (tmp_path / "lego.urdf").read_text()
    mended = re.sub(r"<inertia .*/>", f"<inertia {written_line(finding)}/>", text)
    (tmp_path / "lego.urdf").write_text(mended)
    falling = build(TILTED)
    assert doubtful_inertias(falling.task) == ()
    for world in (standing, falling):
        world.reset(0)
        for _ in range(40):
            world.step()
    assert tilt(standing) > 25
    assert tilt(falling) < 1


@pytest.mark.parametrize(
    ("center", "outside"), [("0 0 0.06", False), ("0 0 0.1", True), ("0.2 0 0", True)]
)
def test_a_centre_of_mass_far_outside_the_shapes_is_found(found, center, outside):
    wrong = [finding for finding in found(brick(center=center)) if finding.code == "TB423"]
    assert bool(wrong) == outside
    if outside:
        assert center in wrong[0].message
        assert wrong[0].location.line == 4
        assert '<origin xyz="0 0 0"/>' in wrong[0].message


def test_shapes_of_links_that_are_fixed_to_it_count_for_a_centre_of_mass(found):
    more = '<link name="far"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
    more += '</link><joint name="j" type="fixed"><parent link="brick"/><child link="far"/>'
    more += '<origin xyz="0.2 0 0"/></joint></robot>'
    text = brick(center="0.2 0 0").replace("</robot>", more)
    assert "TB423" not in {finding.code for finding in found(text)}


@pytest.mark.parametrize("task", Catalogue.discover().tasks)
def test_no_task_of_the_library_has_a_doubtful_inertia(task):
    catalogue = Catalogue.discover()
    file = read_task(catalogue.task(task), catalogue)
    for name, asset in file.assets.items():
        if isinstance(asset, Urdf):
            fixed = file.spec.scene.objects[name].fixed
            assert list(check_inertias(asset, fixed=fixed)) == []
            assert all(1 / 3 < inertia.factor < 3 for inertia in inertias(asset, fixed=fixed))
