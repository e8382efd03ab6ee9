"""What tools hold moves with them, and is kept from bumping into things as they are."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest
from plan_scenes import Scene, facing, made

from taskbuilder.expert.planning.planner import Move, PlanningError, Trajectory
from taskbuilder.geometry import NO_TURN, Pose, norm, subtract
from taskbuilder.sim.contacts import closest_distance


@pytest.fixture
def scene(tmp_path):
    """Makes scenes of texts, or of tasks of the library."""
    scenes: list[Scene] = []

    def make(text: str) -> Scene:
        scenes.append(made(tmp_path / f"made{len(scenes)}", text))
        return scenes[-1]

    yield make
    for made_scene in scenes:
        made_scene.close()


def take_bar(both: Scene) -> Pose:
    """Left takes the bar by its middle; where the tool is in it."""
    above = Pose((-0.15, 0.0, 0.25), both.commanded("left").quaternion)
    both.go(Move({"left": Pose()}, above))
    both.go(Move({"left": Pose()}, replace(above, position=(-0.15, 0.0, 0.125)), straight=True))
    both.grip("left", 0.0)
    assert both.world.held("bar", "left")
    both.touched.clear()
    return both.in_object("left", "bar")


def fastest(both: Scene, plan: Trajectory) -> float:
    """How far the left tool goes in a control step, m."""
    chain = both.world.robots["left"].chain
    tools = [chain.forward(joints).position for joints in plan.joints["left"]]
    return max(norm(subtract(after, before)) for before, after in pairwise(tools))


class TestOneArm:
    def test_brings_an_object_to_where_it_is_to_be(self, scene):
        both = scene(facing())
        grasp = take_bar(both)
        goal = Pose((-0.25, 0.1, 0.3), both.world.pose("bar").quaternion)
        both.go(Move({"left": grasp}, goal), left="bar")
        assert norm(subtract(both.world.position("bar"), goal.position)) < 0.005
        assert both.world.held("bar", "left")

    def test_lifts_what_lies_on_a_table(self, scene):
        both = scene(facing())
        grasp = take_bar(both)
        bar = both.world.pose("bar")
        both.go(Move({"left": grasp}, bar.moved((0.0, 0.0, 0.1)), straight=True), left="bar")
        assert both.world.position("bar")[2] == pytest.approx(bar.position[2] + 0.1, abs=0.005)

    def test_slides_what_lies_on_a_table(self, scene):
        both = scene(facing())
        grasp = take_bar(both)
        goal = both.world.pose("bar").moved((0.1, 0.0, 0.0))
        both.go(Move({"left": grasp}, goal, straight=True), left="bar")
        assert norm(subtract(both.world.position("bar"), goal.position)) < 0.01
        assert ("bar", "table") in both.touched

    def test_goes_no_faster_than_a_grasp_holds(self, scene):
        both = scene(facing(action="arm: joint_position"))
        free = both.plan(both.at("left", (-0.15, 0.0, 0.25)))
        take_bar(both)
        laden = both.go(both.at("left", (-0.2, -0.15, 0.3)), left="bar")
        assert fastest(both, laden) <= 0.06 < fastest(both, free)
        assert both.world.held("bar", "left")

    def test_does_not_push_it_into_the_table(self, scene):
        both = scene(facing())
        grasp = take_bar(both)
        goal = both.world.pose("bar").moved((0.1, 0.0, -0.01))
        with pytest.raises(PlanningError, match="the bar would be 10 mm inside the table") as seen:
            both.plan(Move({"left": grasp}, goal), left="bar")
        assert (seen.value.robot, seen.value.cause) == ("left", "in collision")

    def test_does_not_knock_things_over_with_it(self, scene):
        both = scene(facing())
        beside, beyond = (-0.15, 0.1, 0.25), (-0.15, 0.42, 0.25)
        both.go(both.at("left", beside))
        both.plan(replace(both.at("left", beyond), straight=True))  # past the post
        take_bar(both)
        both.go(both.at("left", beside), left="bar")
        way = both.at("left", beyond)
        with pytest.raises(PlanningError, match=r"the bar would be .* the post"):
            both.plan(replace(way, straight=True), left="bar")
        both.go(way, left="bar")
        assert not both.touched & {("bar", "post"), ("left", "post")}
        assert both.world.held("bar", "left")

    def test_sees_what_the_other_arm_holds(self, scene):
        both = scene(facing())
        take_bar(both)
        both.go(both.at("left", (-0.15, -0.1, 0.3)), left="bar")
        with pytest.raises(
            PlanningError, match=r"right's left_finger would be .* inside the bar"
        ) as seen:
            both.plan(both.at("right", (0.0, -0.14, 0.3)), left="bar")
        assert seen.value.robot == "right"


class TestLoads:
    def lifted(self, scene) -> tuple[Scene, dict[str, Pose]]:
        """The tray of the library's lift, held by both arms."""
        lift = scene("collaborative_lift")
        world = lift.world
        heights = (0.1, 0.0)
        for height in heights:
            handles = {name: f"tray.{name}_handle_top" for name in ("left", "right")}
            moves = [
                lift.at(name, world.pose(handle).moved((0.0, 0.0, height)).position)
                for name, handle in handles.items()
            ]
            lift.go(*(replace(move, straight=True) for move in moves))
        for name in world.robots:
            world.robots[name].move_gripper(0.0)
        lift.grip("left", 0.0)
        assert all(world.held("tray", name) for name in world.robots)
        lift.touched.clear()
        return lift, {name: lift.in_object(name, "tray") for name in world.robots}

    def test_are_moved_level_by_all_that_hold_them(self, scene):
        lift, grasps = self.lifted(scene)
        goal = Pose((0.03, 0.05, 0.55), NO_TURN)
        trajectory = lift.go(Move(grasps, goal), left="tray", right="tray")
        assert set(trajectory.joints) == {"left", "right"}
        tray = lift.world.pose("tray")
        assert norm(subtract(tray.position, goal.position)) < 0.01
        assert tray.axis(2)[2] > 0.999
        assert all(lift.world.held("tray", name) for name in ("left", "right"))

    def test_take_along_what_lies_on_them(self, scene):
        lift, grasps = self.lifted(scene)
        before = lift.world.pose("tray").inverse() @ lift.world.pose("cube")
        goal = Pose((0.03, 0.05, 0.55), NO_TURN)
        # Were the cube taken to stay behind, the tray would have to go round it.
        lift.go(Move(grasps, goal, straight=True), left="tray", right="tray")
        after = lift.world.pose("tray").inverse() @ lift.world.pose("cube")
        assert norm(subtract(after.position, before.position)) < 0.01

    def test_do_not_go_where_an_arm_cannot_follow(self, scene):
        lift, grasps = self.lifted(scene)
        goal = Pose((0.8, 0.0, 0.6), NO_TURN)
        with pytest.raises(PlanningError) as seen:
            lift.plan(Move(grasps, goal), left="tray", right="tray")
        assert (seen.value.robot, seen.value.cause) == ("left", "out of reach")


def test_fingers_close_in_on_what_they_are_to_grasp(scene):
    both = scene(facing())
    over = Pose((-0.15, 0.0, 0.3), both.commanded("left").quaternion)
    both.go(Move({"left": Pose()}, over))
    into = replace(over, position=(-0.15, 0.0, 0.125))
    trajectory = both.go(Move({"left": Pose()}, into))
    assert trajectory.steps <= 6
    robot, bar = both.world.robots["left"].body, both.world.objects["bar"].body
    distance = closest_distance(robot, bar, within=0.1)
    assert distance is not None
    assert 0.0 < distance < 0.03
    assert not both.touched - {("bar", "table")}
