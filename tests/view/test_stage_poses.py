"""The poses that the expert's stages require are judged, with margins, before anything moves."""

from __future__ import annotations

import math
from contextlib import closing

import pytest

from taskbuilder import load_task
from taskbuilder.errors import Finding
from taskbuilder.view.stage_poses import stage_poses
from taskbuilder.view.words import expert_poses, subjects
from taskbuilder.world.building import build_world

WALL = "wall: {shape: {box: [0.02, 0.6, 0.6]}, fixed: true, position: [0.45, 0, 0.4]}"


def poses_of(file):
    task = load_task(file)
    with closing(build_world(task.file)) as world:
        world.reset(0)
        before = world.pose("arm.tcp")
        poses = stage_poses(world)
        assert world.pose("arm.tcp") == before
        return poses


def test_a_pose_in_reach_has_a_margin_to_the_edge_of_the_workspace(touch):
    (pose,) = poses_of(touch)
    assert (pose.stage, pose.robot, pose.order) == (1, "arm", "reach ball")
    assert pose.verdict == "in reach"
    assert pose.pose.position == pytest.approx((0.45, 0.0, 0.4))
    assert 100.0 < pose.reach_mm < 500.0
    assert pose.obstacle == ""
    assert "reach \\+" in expert_poses([pose])


def test_a_pose_out_of_reach_says_how_much_nearer_it_must_be(touch):
    text = touch.read_text()
    touch.write_text(text.replace("[0.45, 0, 0.4]", "[0.9, 0, 0.4]"))
    (pose,) = poses_of(touch)
    assert pose.verdict == "out of reach"
    assert -400.0 < pose.margin_mm < 0.0
    touch.write_text(text.replace("[0.45, 0, 0.4]", "[3.0, 0, 0.4]"))
    (pose,) = poses_of(touch)
    assert pose.margin_mm == -math.inf
    assert "nowhere near" in expert_poses([pose])


def test_a_pose_in_a_wall_is_in_collision_by_so_much(touch):
    touch.write_text(touch.read_text().replace("  objects:\n", f"  objects:\n    {WALL}\n"))
    (pose,) = poses_of(touch)
    assert pose.verdict == "in collision"
    assert pose.obstacle == "wall"
    assert pose.margin_mm < -3.0
    assert "mm from wall" in expert_poses([pose])


CABINET = """<robot name="cabinet">
  <link name="case"><collision><geometry><box size="0.02 0.6 0.6"/></geometry></collision></link>
  <link name="flap"><collision><geometry><box size="0.02 0.6 0.6"/></geometry></collision></link>
  <joint name="hinge" type="prismatic"><parent link="case"/><child link="flap"/>
    <origin xyz="{flap} 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.3" effort="1" velocity="1"/>
  </joint>
</robot>"""


@pytest.mark.parametrize(
    ("case", "flap", "verdict"), [(0.45, 0.4, "in collision"), (0.85, -0.4, "in reach")]
)
def test_of_an_object_with_joints_only_what_stands_still_is_in_the_way(touch, case, flap, verdict):
    (touch.parent / "cabinet.urdf").write_text(CABINET.format(flap=flap))
    cabinet = f"cabinet: {{shape: {{urdf: cabinet.urdf}}, fixed: true, position: [{case}, 0, 0.4]}}"
    touch.write_text(touch.read_text().replace("  objects:\n", f"  objects:\n    {cabinet}\n"))
    (pose,) = poses_of(touch)
    assert pose.verdict == verdict


def test_a_table_under_an_arm_is_no_collision(touch):
    table = "table: {shape: {box: [2.0, 2.0, 0.02]}, fixed: true, position: [0, 0, -0.01]}"
    touch.write_text(touch.read_text().replace("  objects:\n", f"  objects:\n    {table}\n"))
    (pose,) = poses_of(touch)
    assert pose.verdict == "in reach"
    assert pose.obstacle in ("table", "")


def test_findings_speak_of_the_names_in_their_paths():
    found = [
        Finding("TB102", "no", "expert[2].left.grasp"),
        Finding("TB102", "no", "scene.objects.cube.shape"),
    ]
    assert {"left", "cube"} <= subjects(found)
    assert subjects([]) == frozenset()
