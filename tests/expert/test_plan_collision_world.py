"""Distances are asked of a copy of the world that is as the world is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from plan_scenes import Scene, facing, made

from taskbuilder.expert.planning.clearance import CLEARANCE_M, Clearance, Posture
from taskbuilder.expert.planning.collision_world import CollisionWorld
from taskbuilder.expert.planning.errors import PlanningError
from taskbuilder.geometry import Pose
from taskbuilder.kinematics.inverse import solve
from taskbuilder.sim.contacts import closest_distance, gaps, pose_joints


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """Two arms and a table."""
    scene = made(tmp_path_factory.mktemp("collision_world"), facing())
    yield scene
    scene.close()


@pytest.fixture(scope="module")
def collision_world(both):
    """A copy of it."""
    copy = CollisionWorld(both.world)
    yield copy
    copy.close()


def test_joints_posed_for_a_look_are_where_reset_joints_puts_them(collision_world):
    robot = collision_world.world.robots["left"]
    body, joints = robot.body, [0.3, -1.2, 1.1, -1.5, -1.0, 0.4]
    body.reset_joints(robot.arm.indices, joints)
    expected = [body.link_pose(index) for index in body.indices]
    near = closest_distance(body, collision_world.world.objects["table"].body, within=1.0)
    body.reset_joints(robot.arm.indices, [0.0] * 6)
    pose_joints(body, robot.arm.indices, joints)
    assert [body.link_pose(index) for index in body.indices] == expected
    assert closest_distance(body, collision_world.world.objects["table"].body, within=1.0) == near


def test_gaps_say_which_links_are_near_and_what_is_above(collision_world):
    bar, table = (collision_world.world.objects[name].body for name in ("bar", "table"))
    found = gaps(bar, table, 0.01)
    assert min(gap.distance for gap in found) == closest_distance(bar, table, within=0.01)
    assert {(gap.link_a, gap.link_b) for gap in found} == {("box", "box")}
    assert all(math.isclose(gap.up, 1.0, abs_tol=1e-3) for gap in found)
    assert all(gap.up < -0.99 for gap in gaps(table, bar, 0.01))
    assert not gaps(bar, collision_world.world.objects["post"].body, 0.01)


def test_a_copy_has_arms_where_they_are_commanded_and_the_rest_where_it_is(
    both: Scene, collision_world
):
    both.env.reset(seed=0)
    both.world.robots["left"].move_gripper(0.5)
    for height in (0.32, 0.36):
        both.world.step(
            {"left": both.plan(both.at("left", (-0.2, -0.15, height))).joints["left"][0]}
        )
    joints = collision_world.copy(both.world)
    for name, robot in both.world.robots.items():
        copied = collision_world.world.robots[name]
        assert joints[name] == robot.arm.command.values
        assert copied.arm_state()[0] == pytest.approx(robot.arm.command.values, abs=1e-12)
        assert copied.opening() == pytest.approx(robot.opening(), abs=1e-12)
    assert joints["left"] != pytest.approx(both.world.robots["left"].arm_state()[0], abs=1e-5)
    for name, thing in both.world.objects.items():
        copied_pose, pose = collision_world.world.objects[name].body.pose(), thing.body.pose()
        assert copied_pose.position == pytest.approx(pose.position, abs=1e-12)
        assert copied_pose.quaternion == pytest.approx(pose.quaternion, abs=1e-12)


def left_at(both: Scene, height: float, aside: float = 0.0) -> Posture:
    """The left arm with its tool at a height, and so far aside, in metres."""
    left = both.world.robots["left"]
    tool = Pose((-0.2, -0.15 + aside, height), both.commanded("left").quaternion)
    goal = left.body.pose().inverse() @ tool
    start, rng = left.arm.command.values, np.random.default_rng(0)
    found = solve(left.chain, goal, start=start, rng=rng)
    assert found.ok
    return Posture({"left": found.joints}, {"left": tool})


def height_above_table(both: Scene, collision_world: CollisionWorld, gap: float) -> float:
    """The height of the left tool at which the arm is so far above the table, in metres."""
    table = collision_world.world.objects["table"].body

    def gap_at(height: float) -> float:
        collision_world.pose_arm("left", left_at(both, height).joints["left"])
        arm = collision_world.world.robots["left"].body
        found = closest_distance(arm, table, within=0.1)
        assert found is not None
        return found

    height = 0.15 - gap_at(0.15) + gap
    assert gap_at(height) == pytest.approx(gap, abs=1e-4)
    return height


def test_what_is_near_at_one_end_has_to_part_on_the_way_from_there(both: Scene, collision_world):
    """Within a finger's length of the end it may stay as near; farther on, it must part."""
    low = height_above_table(both, collision_world, 3e-3)
    clearance = Clearance(collision_world, ["left"], [], {}, {})
    for ends in ((low, 0.3), (0.3, low)):
        clearance.between(*(left_at(both, height) for height in ends))
        assert clearance.trouble(left_at(both, low, aside=0.05)) is None
        assert clearance.trouble(left_at(both, low, aside=0.15)) is not None


@pytest.mark.parametrize("gap_mm", [8.6, 9.4])
def test_a_motion_may_sag_a_little_from_where_it_begins(both: Scene, collision_world, gap_mm):
    """On either side of the clearance, the distance at the start has the same tolerance."""

    def tool_at(height: float) -> Posture:
        return left_at(both, height)

    low = height_above_table(both, collision_world, gap_mm * 1e-3)
    clearance = Clearance(collision_world, ["left"], [], {}, {})
    clearance.between(tool_at(low), tool_at(0.3))
    assert clearance.trouble(tool_at(low - 8e-4)) is None
    too_near = clearance.trouble(tool_at(low - 1.6e-3))
    assert too_near is not None
    assert too_near.distance < CLEARANCE_M


@pytest.mark.parametrize(
    ("start_mm", "goal_mm", "allowed"),
    [(None, -2.0, True), (None, -4.0, False), (-5.0, -5.5, True), (-5.0, -7.0, False)],
)
def test_a_motion_may_end_as_deep_as_poses_are_known_or_as_it_began(
    both: Scene, collision_world, start_mm, goal_mm, allowed
):
    def tool_at(gap_mm: float) -> Posture:
        return left_at(both, height_above_table(both, collision_world, gap_mm * 1e-3))

    start = left_at(both, 0.3) if start_mm is None else tool_at(start_mm)
    clearance = Clearance(collision_world, ["left"], [], {}, {})
    if allowed:
        clearance.between(start, tool_at(goal_mm))
        return
    with pytest.raises(PlanningError, match=r"at the end .* left's .* inside the table"):
        clearance.between(start, tool_at(goal_mm))
