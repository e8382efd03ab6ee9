"""Arms on a base that drives, and gantries: what an expert does with them, on real physics."""

from __future__ import annotations

import math

import pytest

from taskbuilder.env.parallel import parallel_env
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import replay
from taskbuilder.task import load_task

TABLES = """
task: {name}
summary: A task made for a test.
cooperation: optional
timing: {{control_hz: 10, physics_hz: 120, episode_steps: 150}}
scene:
  robots:
    arm: {{{robot}, action: {{{action}}}}}
  objects:
    near:
      parts:
        top: {{box: [0.5, 1.0, 0.04], at: [0, 0, 0.38]}}
        left_side: {{box: [0.44, 0.04, 0.36], at: [0, 0.45, 0.18]}}
        right_side: {{box: [0.44, 0.04, 0.36], at: [0, -0.45, 0.18]}}
      fixed: true
      position: [{near}, 0, 0]
    block:
      shape: {{box: [0.05, 0.04, 0.05]}}
      mass: 0.1
      position: [{block}, 0.425]
      grasps: {{middle: {{across: y}}}}
{objects}  sites:
    goal: {{position: [{goal}]}}
expert:
{expert}
"""
FAR = """\
    far: {shape: {box: [0.5, 1.0, 0.04]}, fixed: true, position: [-1.2, 0, 0.38]}
"""
DESCRIPTION = """
from taskbuilder.description import Bonus, Description, Distance, Near


class Made(Description):
    success = Near("block", "goal", within=0.03)
    reward = (Distance("carry", "block", "goal"), Bonus("there", success, 1.0))
"""
MOBILE = "model: mobile_ur5e, base: {position: [0, 0, 0]}"
GANTRY = "model: gantry, base: {position: [0, 0, 0]}"


@pytest.fixture
def begin(tmp_path):
    """An environment with the given stages for a robot, and its expert."""
    experts = []

    def make(robot, action, *stages, **scene):
        values = {"near": 0.9, "block": "0.8, 0.1", "goal": "0.8, -0.2, 0.426", "objects": ""}
        listed = "\n".join(f"  - {stage}" for stage in stages)
        text = TABLES.format(
            name="made", robot=robot, action=action, expert=listed, **(values | scene)
        )
        (tmp_path / "made.yaml").write_text(text)
        (tmp_path / "made.py").write_text(DESCRIPTION)
        env = parallel_env(load_task(tmp_path / "made.yaml"))
        experts.append(Expert(env))
        return env, experts[-1]

    yield make
    for expert in experts:
        expert.close()
        expert.env.close()


CARRY = ("arm: {grasp: block.middle}", "arm: {bring: block, to: goal}", "arm: release")


@pytest.mark.parametrize("mode", ["joint_delta", "joint_position"])
def test_a_mobile_arm_fetches_from_one_table_to_another(begin, mode):
    lift = "arm: {bring: block, to: [0.6, 0.1, 0.7]}"
    back = "arm: {bring: block, to: [-0.8, 0, 0.7]}"
    stages = (CARRY[0], lift, back, *CARRY[1:], "arm: {retreat: 0.1}")
    env, expert = begin(
        MOBILE, f"arm: {mode}, max_turn_deg: 10", *stages, objects=FAR, goal="-1.1, 0, 0.43"
    )
    rollout = expert.play(0, finish=False)
    assert rollout.trouble is None
    assert rollout.success
    assert replay(env, rollout).equals(rollout)


@pytest.mark.parametrize("mode", ["tcp_delta", "tcp_pose", "tcp_path"])
def test_a_commanded_tool_takes_the_base_along(begin, mode):
    scene = {"near": 1.75, "block": "1.6, 0.1", "goal": "1.0, -0.3, 0.7"}
    env, expert = begin(MOBILE, f"arm: {mode}", *CARRY[:2], **scene)
    moved = []

    def watch(now):
        moved.append(now.episode.world.robots["arm"].arm_state()[0])

    rollout = expert.play(0, finish=False, watch=watch)
    assert rollout.trouble is None
    assert env.episode.world.held("block", "arm")
    assert max(joints[0] for joints in moved) > 0.5
    posture = env.episode.world.robots["arm"].chain.posture
    bent = max(abs(q - home) for q, home in zip(moved[-1][3:], posture[3:], strict=True))
    assert bent < 1.2  # the arm came back to its posture on the way


@pytest.mark.parametrize("mode", ["tcp_delta", "joint_delta", "joint_velocity", "tcp_pose"])
def test_a_gantry_carries_a_block(begin, mode):
    stages = (*CARRY, "arm: {retreat: 0.1}", "arm: home")
    scene = {"near": 0.0, "block": "0.1, 0.1", "goal": "-0.1, -0.2, 0.426"}
    env, expert = begin(GANTRY, f"arm: {mode}", *stages, **scene)
    rollout = expert.play(0, finish=False)
    assert rollout.trouble is None
    assert rollout.success
    assert math.dist(env.episode.world.robots["arm"].arm_state()[0], (0.15, 0, -0.2, 0)) < 0.1


def test_the_base_stands_still_for_what_the_arm_alone_reaches(begin):
    _, expert = begin(MOBILE, "arm: joint_delta", *CARRY)
    env = expert.env
    before = env.episode.world.robots["arm"].arm_state()[0][:3]
    assert expert.play(0, finish=False).trouble is None
    assert math.dist(env.episode.world.robots["arm"].arm_state()[0][:3], before) < 0.02


def test_a_base_stays_out_of_the_way_of_a_table(begin):
    """The straight way would take it into the side of the table on which the block lies."""
    env, expert = begin(
        MOBILE, "arm: joint_delta", *CARRY[:1], near=1.8, block="1.75, 0.2", goal="1.8, -0.2, 0.7"
    )
    touched = []

    def watch(now):
        world = now.episode.world
        touched.append(world.touching("arm", "near"))

    rollout = expert.play(0, finish=False, watch=watch)
    assert rollout.trouble is None
    assert env.episode.world.held("block", "arm")
    assert not any(touched)
