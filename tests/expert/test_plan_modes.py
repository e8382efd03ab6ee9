"""What is planned for an action mode is within what the mode can command in a control step."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from plan_scenes import Scene, facing, made, walled

from taskbuilder.env.actions import ARM_MODES, can_be_planned
from taskbuilder.errors import UsageError
from taskbuilder.expert.planning.planner import Move, PlanningError, Trajectory
from taskbuilder.geometry import Pose, from_rpy_deg, norm, subtract, turn_between
from taskbuilder.schema.agents import ActionSpec

BEYOND = (0.45, 0.25, 0.3)
"""On the other side of the wall."""

MODES = (
    "arm: tcp_delta",
    "arm: tcp_delta, max_step: 0.02, max_turn_deg: 5, turn: full",
    "arm: tcp_delta, turn: none, frame: tcp",
    "arm: tcp_pose",
    "arm: tcp_path",
    "arm: joint_delta",
    "arm: joint_delta, max_turn_deg: 4",
    "arm: joint_position",
    "arm: joint_velocity",
)


def test_every_mode_that_can_be_planned_is_tried_here():
    planned = {name for name in ARM_MODES if can_be_planned(ActionSpec(arm=name))}
    assert {mode.split(": ")[1].partition(",")[0] for mode in MODES} == planned


@pytest.fixture
def scene(tmp_path):
    """Makes scenes of texts."""
    scenes: list[Scene] = []

    def make(text: str) -> Scene:
        scenes.append(made(tmp_path / f"made{len(scenes)}", text))
        return scenes[-1]

    yield make
    for made_scene in scenes:
        made_scene.close()


def check_limits(scene: Scene, start: dict[str, tuple[float, ...]], plan: Trajectory) -> None:
    """No control step of a plan asks for more than the action mode can command."""
    for name, points in plan.joints.items():
        robot, spec = scene.world.robots[name], scene.world.scene.robots[name].action
        dt = 1.0 / scene.world.spec.timing.control_hz
        fastest = [joint.velocity * dt for joint in robot.model.arm]
        turn = math.radians(spec.max_turn_deg)
        for before, after in pairwise([start[name], *points]):
            moved = np.abs(np.subtract(after, before))
            assert (moved <= np.add(fastest, 1e-9)).all()
            if spec.arm == "joint_delta":
                assert moved.max() <= turn + 1e-9
            if spec.arm.startswith("tcp"):
                begin, end = robot.chain.forward(before), robot.chain.forward(after)
                assert norm(subtract(end.position, begin.position)) <= spec.max_step
                assert turn_between(begin.quaternion, end.quaternion) <= turn


def joints_of(scene: Scene) -> dict[str, tuple[float, ...]]:
    """Where arms are commanded."""
    return {name: robot.arm.command.values for name, robot in scene.world.robots.items()}


@pytest.mark.parametrize("mode", MODES)
class TestEveryMode:
    def test_gets_round_a_wall_within_its_limits(self, scene, mode):
        barred = scene(walled(action=mode))
        start = joints_of(barred)
        plan = barred.go(barred.at("arm", BEYOND))
        check_limits(barred, start, plan)
        assert norm(subtract(barred.world.position("arm.tcp"), BEYOND)) < 0.004
        assert barred.nearest(plan, "arm", "wall") > 0.007
        assert not barred.touched

    def test_turns_within_its_limits(self, scene, mode):
        free = scene(walled(action=mode))
        start = joints_of(free)
        yaw = 0.0 if "none" in mode else 80.0
        goal = Pose((0.45, -0.3, 0.3), from_rpy_deg((180.0, 0.0, yaw)))
        check_limits(free, start, free.go(Move({"arm": Pose()}, goal)))
        turned = turn_between(free.world.pose("arm.tcp").quaternion, goal.quaternion)
        assert turned < math.radians(1.5)


@pytest.mark.parametrize("mode", ["arm: tcp_delta", "arm: joint_delta"])
def test_a_tool_goes_straight_where_it_must(scene, mode):
    free = scene(walled(action=mode))
    goal = Pose((0.3, -0.45, 0.5), free.commanded("arm").quaternion)
    start = free.commanded("arm").position
    plan = free.plan(Move({"arm": Pose()}, goal, straight=True))
    way = np.subtract(goal.position, start)
    chain = free.world.robots["arm"].chain
    for joints in plan.joints["arm"]:
        off = np.subtract(chain.forward(joints).position, start)
        assert np.linalg.norm(off - way * (off @ way) / (way @ way)) < 0.002


@pytest.mark.parametrize(
    ("model", "mode"), [("panda", "tcp_delta"), ("xarm6", "tcp_delta"), ("panda", "joint_delta")]
)
def test_other_robots_get_round_a_wall(scene, model, mode):
    barred = scene(walled(model=model, action=f"arm: {mode}"))
    start = joints_of(barred)
    plan = barred.go(barred.at("arm", BEYOND))
    check_limits(barred, start, plan)
    assert norm(subtract(barred.world.position("arm.tcp"), BEYOND)) < 0.004
    assert not barred.touched


class TestWhatModesKeep:
    TILTED = Pose((0.45, -0.3, 0.3), from_rpy_deg((180.0, 50.0, 0.0)))
    TURNED = Pose((0.45, -0.3, 0.3), from_rpy_deg((180.0, 0.0, 50.0)))

    @pytest.mark.parametrize("mode", ["tcp_delta", "tcp_pose", "tcp_path"])
    def test_a_tool_that_only_yaws_is_not_tilted(self, scene, mode):
        free = scene(walled(action=f"arm: {mode}"))
        free.plan(Move({"arm": Pose()}, self.TURNED))
        with pytest.raises(PlanningError, match="keeps the tilt that the tool has at home"):
            free.plan(Move({"arm": Pose()}, self.TILTED))

    @pytest.mark.parametrize("mode", ["tcp_delta", "tcp_pose", "tcp_path"])
    def test_a_tool_that_does_not_turn_is_not_turned(self, scene, mode):
        free = scene(walled(action=f"arm: {mode}, turn: none"))
        with pytest.raises(PlanningError, match="keeps the orientation that the tool has at home"):
            free.plan(Move({"arm": Pose()}, self.TURNED))

    @pytest.mark.parametrize("mode", ["tcp_delta, turn: full", "joint_delta", "joint_position"])
    def test_others_tilt_it(self, scene, mode):
        free = scene(walled(action=f"arm: {mode}"))
        free.go(Move({"arm": Pose()}, self.TILTED))
        turned = turn_between(free.world.pose("arm.tcp").quaternion, self.TILTED.quaternion)
        assert turned < math.radians(1.5)


def test_torques_are_not_planned(scene):
    free = scene(walled(action="arm: joint_torque"))
    with pytest.raises(UsageError, match="do not plan for joint_torque; use another mode"):
        free.plan(free.at("arm", BEYOND))


def test_joints_lead_to_the_goal_in_another_posture_where_the_nearest_collides(scene):
    text = walled(action="arm: joint_position", height=0.05)
    free = scene(text)
    move = free.at("arm", BEYOND)
    # A lamp where the forearm would be.
    lamp = "    lamp: {shape: {box: [0.1, 0.1, 0.1]}, position: [0.2, 0.12, 0.57], fixed: true}\n"
    barred = scene(text.replace("    wall:", f"{lamp}    wall:"))
    plan = barred.go(move, seed=1)
    near, other = free.plan(move).joints["arm"][-1], plan.joints["arm"][-1]
    assert np.abs(np.subtract(near, other)).max() > 0.5
    assert norm(subtract(barred.world.position("arm.tcp"), BEYOND)) < 0.004
    assert barred.nearest(plan, "arm", "lamp") > 0.007
    assert not barred.touched


def test_two_arms_by_joints_make_way_for_each_other(scene):
    both = scene(facing(action="arm: joint_delta"))
    both.go(both.at("left", (-0.05, -0.3, 0.3)), both.at("right", (0.12, 0.3, 0.3)))
    goals = {"left": (0.05, 0.3, 0.3), "right": (-0.05, -0.3, 0.3)}
    plan = both.go(*(both.at(robot, goal) for robot, goal in goals.items()))
    assert both.nearest(plan, "left", "right") > 0.007
    assert ("left", "right") not in both.touched
