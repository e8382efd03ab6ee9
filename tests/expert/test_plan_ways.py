"""Ways lead where they should, past what is in the way."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from plan_scenes import Scene, facing, made, walled

from taskbuilder.errors import UsageError
from taskbuilder.expert.planning.planner import Move, PlanningError
from taskbuilder.geometry import Pose, from_rpy_deg, norm, subtract, turn_between

BEYOND = (0.45, 0.25, 0.3)
"""On the other side of the wall."""

DOWN = from_rpy_deg((180.0, 0.0, 0.0))


@pytest.fixture
def scene(tmp_path):
    """Makes scenes of texts, or of tasks of the library."""
    scenes: list[Scene] = []

    def make(text: str, **options: str) -> Scene:
        scenes.append(made(tmp_path / f"made{len(scenes)}", text, **options))
        return scenes[-1]

    yield make
    for made_scene in scenes:
        made_scene.close()


def reached(scene: Scene, robot: str, goal: Pose) -> tuple[float, float]:
    """How far a tool is from a goal: metres, rad."""
    tool = scene.world.pose(f"{robot}.tcp")
    off = norm(subtract(tool.position, goal.position))
    return off, turn_between(tool.quaternion, goal.quaternion)


def straight(move: Move) -> Move:
    """The same move, only along a straight line."""
    return replace(move, straight=True)


class TestOneArm:
    def test_goes_straight_where_nothing_is_in_the_way(self, scene):
        free = scene(walled())
        trajectory = free.go(free.at("arm", (0.45, -0.45, 0.3)))
        assert trajectory.steps == 6  # 4 at full speed, and 1.6 for the ramps
        assert reached(free, "arm", Pose((0.45, -0.45, 0.3), DOWN))[0] < 0.003

    def test_goes_round_what_is_in_the_way(self, scene):
        barred = scene(walled())
        trajectory = barred.go(barred.at("arm", BEYOND))
        assert reached(barred, "arm", Pose(BEYOND, DOWN))[0] < 0.003
        assert barred.nearest(trajectory, "arm", "wall") > 0.007
        assert not barred.touched

    def test_finds_a_way_where_simple_ones_fail(self, scene):
        barred = scene(walled(height=2.0))  # too high to go over
        trajectory = barred.go(barred.at("arm", BEYOND))
        assert reached(barred, "arm", Pose(BEYOND, DOWN))[0] < 0.003
        assert barred.nearest(trajectory, "arm", "wall") > 0.007
        assert not barred.touched

    def test_turns_its_tool_on_the_way(self, scene):
        free = scene(walled())
        goal = Pose((0.45, -0.3, 0.3), from_rpy_deg((180.0, 0.0, 70.0)))
        free.go(Move({"arm": Pose()}, goal))
        assert reached(free, "arm", goal)[1] < math.radians(2.0)

    def test_goes_at_a_share_of_its_speed(self, scene):
        free = scene(walled())
        move = free.at("arm", (0.45, -0.45, 0.3))
        slow = free.plan(replace(move, speed=0.25))
        assert slow.steps == 18

    def test_stays_where_it_is_in_no_time(self, scene):
        free = scene(walled())
        assert free.plan(Move({"arm": Pose()}, free.commanded("arm"))).steps == 0
        assert free.plan().joints == {}


class TestBlocked:
    def test_out_of_reach_says_how_far_off_the_tool_stays(self, scene):
        free = scene(walled())
        with pytest.raises(
            PlanningError, match=r"arm cannot bring its tool to .*: the nearest pose .* off by \d"
        ) as seen:
            free.plan(free.at("arm", (1.3, -0.3, 0.3)))
        assert (seen.value.robot, seen.value.cause) == ("arm", "out of reach")

    def test_a_tilt_that_the_mode_cannot_command_is_out_of_reach(self, scene):
        free = scene(walled())
        goal = Pose((0.45, -0.3, 0.3), from_rpy_deg((180.0, 40.0, 0.0)))
        with pytest.raises(PlanningError, match="40° more than its actions") as seen:
            free.plan(Move({"arm": Pose()}, goal))
        assert (seen.value.robot, seen.value.cause) == ("arm", "out of reach")

    def test_a_slight_tilt_is_left_out(self, scene):
        free = scene(walled())
        goal = Pose((0.45, -0.3, 0.3), from_rpy_deg((180.0, 10.0, 0.0)))
        free.go(Move({"arm": Pose()}, goal))
        assert reached(free, "arm", Pose(goal.position, DOWN))[1] < math.radians(1.0)

    def test_in_collision_names_the_link_and_the_thing(self, scene):
        barred = scene(walled())
        with pytest.raises(
            PlanningError, match=r"arm's \w+ would be \d+ mm inside the wall"
        ) as seen:
            barred.plan(barred.at("arm", (0.5, 0.0, 0.3)))
        assert (seen.value.robot, seen.value.cause) == ("arm", "in collision")

    def test_no_straight_way_names_what_is_in_the_way(self, scene):
        barred = scene(walled())
        with pytest.raises(PlanningError, match=r"take the direct path: .* the wall") as seen:
            barred.plan(straight(barred.at("arm", BEYOND)))
        assert (seen.value.robot, seen.value.cause) == ("arm", "no path")

    def test_no_way_names_what_is_in_the_way(self, scene):
        parted = scene(walled(height=3.0, width=2.4, behind=True))
        with pytest.raises(PlanningError, match=r"arm finds no path: .* the (wall|rest)") as seen:
            parted.plan(parted.at("arm", BEYOND))
        assert (seen.value.robot, seen.value.cause) == ("arm", "no path")


def test_things_may_be_touched_on_purpose(scene):
    both = scene(facing())
    into = both.at("left", (0.0, 0.26, 0.25))
    with pytest.raises(PlanningError, match=r"left's \w+ would be \d+ mm inside the post"):
        both.plan(into)
    assert both.plan(replace(into, touching=("post",))).steps > 0


class TestTwoArms:
    def test_make_way_for_each_other(self, scene):
        both = scene(facing())
        both.go(both.at("left", (-0.05, -0.3, 0.3)), both.at("right", (0.12, 0.3, 0.3)))
        goals = {"left": (0.05, 0.3, 0.3), "right": (-0.05, -0.3, 0.3)}
        moves = [both.at(robot, goal) for robot, goal in goals.items()]
        with pytest.raises(PlanningError, match=r"left and right .* inside right's gripper"):
            both.plan(*(straight(move) for move in moves))
        trajectory = both.go(*moves)
        for robot, goal in goals.items():
            assert reached(both, robot, both.at(robot, goal).goal)[0] < 0.003
        assert both.nearest(trajectory, "left", "right") > 0.007
        assert ("left", "right") not in both.touched

    def test_arrive_together(self, scene):
        both = scene(facing())
        near, far = (-0.2, -0.1, 0.3), (0.2, 0.2, 0.3)
        trajectory = both.plan(both.at("left", near), both.at("right", far))
        assert len(trajectory.joints["left"]) == len(trajectory.joints["right"]) >= 8
        *_, before, last = trajectory.joints["left"]
        assert before != last

    def test_meet_in_collision(self, scene):
        both = scene(facing())
        middle = (0.0, -0.1, 0.3)
        with pytest.raises(
            PlanningError, match=r"left's \w+ would be \d+ mm inside right's"
        ) as seen:
            both.plan(both.at("left", middle), both.at("right", middle))
        assert seen.value.cause == "in collision"

    def test_one_that_stands_is_in_the_way_of_the_other(self, scene):
        both = scene(facing())
        both.go(both.at("right", (-0.1, 0.1, 0.3)), both.at("left", (-0.1, -0.25, 0.3)))
        move = both.at("left", (-0.1, 0.35, 0.3))
        with pytest.raises(PlanningError, match=r"left's gripper would be .* right's gripper"):
            both.plan(straight(move))
        both.go(move)
        assert reached(both, "left", move.goal)[0] < 0.003
        assert ("left", "right") not in both.touched


class TestMistakes:
    def test_one_robot_cannot_make_two_moves(self, scene):
        free = scene(walled())
        move = free.at("arm", BEYOND)
        with pytest.raises(UsageError, match="arm is to make two moves at once"):
            free.plan(move, move)

    def test_only_robots_move(self, scene):
        free = scene(walled())
        with pytest.raises(UsageError, match='no robot "wall"'):
            free.plan(Move({"wall": Pose()}, Pose()))

    def test_only_objects_are_held(self, scene):
        free = scene(walled())
        with pytest.raises(UsageError, match='no object "spot"'):
            free.plan(free.at("arm", BEYOND), arm="spot")

    @pytest.mark.parametrize("speed", [0.0, 1.5])
    def test_a_speed_is_a_share(self, scene, speed):
        free = scene(walled())
        with pytest.raises(UsageError, match="above 0 and at most 1"):
            free.plan(Move({"arm": Pose()}, free.commanded("arm"), speed=speed))
