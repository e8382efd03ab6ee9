"""What actions cannot do: go through a table, beyond the bounds, or depend on which way is up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from env_tasks import arm, facing, moment, near, random_actions, still, tcp

from taskbuilder.geometry import NO_TURN, Pose, norm, subtract

TABLE = """
  objects:
    block: {shape: {box: [0.6, 0.6, 0.3]}, fixed: true, position: [0.45, 0, 0.15]}
"""
ARM_ALONE = """
from taskbuilder.description import Description, Distance, Near


class Made(Description):
    success = Near("arm.tcp", "spot", within=0.01)
    reward = (Distance("reach", "arm.tcp", "spot"),)
"""
STEP = 0.05


def commanded(env, agent):
    """Where a tool was last told to be, in the world."""
    robot = env.episode.world.robots[agent]
    return robot.body.pose() @ robot.chain.forward(robot.arm.command.values)


@pytest.mark.parametrize("model", ["ur5e", "xarm6", "panda"])
def test_a_blocked_tool_is_commanded_no_further_than_two_steps_ahead(make, model):
    text = arm(model).replace("  sites:", TABLE.strip("\n") + "\n  sites:")
    env = make(text, ARM_ALONE)
    env.reset(seed=0)
    down, up = still(env), still(env)
    down["arm"][2], up["arm"][2] = -1.0, 1.0
    for _ in range(25):
        measured = tcp(env, "arm").position
        env.step(down)
        ahead = norm(subtract(commanded(env, "arm").position, measured))
        assert ahead <= 2.0 * STEP + 1e-3
    blocked = tcp(env, "arm").position[2]
    assert blocked > 0.25
    for _ in range(4):
        env.step(up)
    assert tcp(env, "arm").position[2] > blocked + 0.02


@pytest.mark.parametrize("model", ["ur5e", "xarm6", "panda"])
@pytest.mark.parametrize("turn", ["none", "yaw"])
def test_the_tool_keeps_its_tilt_from_home_unless_it_may_turn_fully(make, model, turn):
    """Except at a joint's limit, where an arm cannot give in without tilting."""
    text = arm(model, action=f"turn: {turn}, frame: base", steps=200)
    high = text.replace("base: {position: [0, 0, 0]}", "base: {position: [0, 0, 1.2]}")
    env = make(high.replace("position: [0.45, 0, 0.4]", "position: [0.45, 0, 1.6]"))
    rng = np.random.default_rng(0)
    robot = env.episode.world.robots["arm"]
    tilts = []
    for seed in range(3):
        env.reset(seed=seed)
        home, since_limit = tcp(env, "arm"), 0
        while env.agents:
            env.step({"arm": rng.uniform(-1.0, 1.0, env.action_space("arm").shape)})
            free = robot.chain.within_limits(robot.arm.command.values, 1e-6)
            since_limit = since_limit + 1 if free else 0
            if since_limit > 5:
                cosine = np.dot(tcp(env, "arm").axis(2), home.axis(2))
                tilts.append(math.degrees(math.acos(min(1.0, cosine))))
    assert len(tilts) > 200
    assert np.quantile(tilts, 0.95) < 3.0
    assert max(tilts) < 15.0  # stretched out, position and tilt give in both


@pytest.mark.parametrize("normalize", [True, False])
@pytest.mark.parametrize("mode", ["tcp_delta", "tcp_pose", "joint_position", "joint_torque"])
def test_numbers_beyond_the_bounds_do_what_the_bounds_do(make, mode, normalize):
    env = make(arm(action=f"arm: {mode}"), normalize=normalize)
    space = env.action_space("arm")
    beyond, at = [], []
    for sign in (1.0, -1.0):
        env.reset(seed=1)
        bound = (space.high if sign > 0 else space.low).astype(np.float64)
        middle = (space.high + space.low) / 2.0
        env.step({"arm": middle + 5.0 * (bound - middle)})
        beyond.append(moment(env))
        env.reset(seed=1)
        env.step({"arm": bound})
        at.append(moment(env))
    for one, other in zip(beyond, at, strict=True):
        # float32 bounds, float64 limits: the last few bits may differ
        assert near(one["arm"][0][0], other["arm"][0][0], 1e-5)


@pytest.mark.parametrize("mode", ["tcp_delta", "joint_position", "joint_velocity"])
def test_normalised_and_physical_actions_agree(make, mode):
    text = arm(action=f"arm: {mode}, gripper: continuous")
    shares, units = make(text), make(text, normalize=False)
    space = units.action_space("arm")
    assert near(shares.action_space("arm").low, -1.0, 0.0)
    assert near(shares.action_space("arm").high, 1.0, 0.0)
    actions = random_actions(shares, 0, 10)
    for env in (shares, units):
        env.reset(seed=0)
    for action in actions:
        shares.step(action)
        low, high = space.low.astype(np.float64), space.high.astype(np.float64)
        units.step({"arm": low + (action["arm"] + 1.0) / 2.0 * (high - low)})
    assert near(*(env.episode.world.robots["arm"].arm_state()[0] for env in (shares, units)), 1e-5)
    assert near(*(env.episode.previous_action("arm") for env in (shares, units)), 1e-5)


@pytest.mark.parametrize("flat", [True, False])
def test_huge_but_finite_numbers_raise_no_warning(make, flat):
    env = make(facing(), normalize=False, flat=flat)
    env.reset(seed=0)
    huge = np.full(5, 1e308)
    huge[::2] *= -1.0
    action = huge if flat else {"arm": huge[:-1], "gripper": huge[-1:]}
    env.step({"left": action, "right": action})
    assert all(abs(value) == 1.0 for value in env.episode.previous_action("left"))


def test_arms_that_face_each_other_move_alike_in_the_frames_of_their_bases(make):
    mirrored = facing(action="arm: tcp_delta, frame: base, turn: full")
    env = make(mirrored.replace("position: [-0.1, 0, 0.4005]", "position: [2, 2, 0.05]"))
    env.reset(seed=0)
    half_turn = Pose((0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))
    rng = np.random.default_rng(0)
    bias = np.array([-0.6, 0.4, 0.6, 0.0, 0.0, 0.0, 0.0])
    for _ in range(12):
        action = np.clip(rng.uniform(-1.0, 1.0, 7) * 0.5 + bias, -1.0, 1.0)
        env.step({"left": action, "right": action})
        left, right = tcp(env, "left"), tcp(env, "right")
        image = half_turn @ left
        assert near(image.position, right.position, 1e-4)
        assert abs(np.dot(image.quaternion, right.quaternion)) > 1.0 - 1e-6
    assert norm(subtract(left.position, (-0.1, 0.0, 0.4))) > 0.1
    assert half_turn.quaternion != NO_TURN


def test_a_robot_keeps_its_grip_while_the_other_moves(make):
    env = make(facing())
    env.reset(seed=0)
    close = still(env)
    close["left"][-1] = -1.0
    for _ in range(4):
        env.step(close)
    lift = still(env)
    lift["left"][:3] = (0.0, 0.0, 1.0)
    lift["right"][:3] = (1.0, 1.0, 1.0)
    start = env.episode.world.position("block")
    for _ in range(4):
        env.step(lift)
    env.step(still(env))
    assert env.episode.world.held("block", "left")
    assert near(subtract(env.episode.world.position("block"), start), (0.0, 0.0, 0.2), 0.01)


def test_the_control_rate_sets_how_far_speeds_reach_in_a_step(make):
    text = arm(action="arm: joint_velocity")
    slow, fast = make(text), make(text, control_hz=20)
    for env in (slow, fast):
        env.reset(seed=0)
    speed = {"arm": np.array([0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])}
    begin = slow.episode.world.robots["arm"].arm_state()[0][0]
    for _ in range(5):
        slow.step(speed)
        fast.step(speed)
        fast.step(speed)
    ends = [env.episode.world.robots["arm"].arm_state()[0][0] for env in (slow, fast)]
    assert near(*ends, 0.01)
    assert ends[0] - begin == pytest.approx(0.2 * math.pi * 0.5, rel=0.1)


@pytest.mark.parametrize("mode", ["tcp_delta", "tcp_pose", "joint_delta"])
def test_another_control_rate_leaves_tools_and_joints_as_fast(make, mode):
    text = arm(action=f"arm: {mode}, max_step: 0.02, max_turn_deg: 4")
    travelled = []
    for hz in (None, 20, 5):
        env = make(text, control_hz=hz, normalize=False)
        env.reset(seed=0)
        begin = env.episode.world.pose("arm.tcp").position
        high = env.action_space("arm").high
        for _ in range((hz or 10) // 5 * 2):
            env.step({"arm": high})
        travelled.append(math.dist(begin, env.episode.world.pose("arm.tcp").position))
        env.close()
    usual, fast, slow = travelled
    assert usual > 0.05
    assert fast == pytest.approx(usual, rel=0.15)
    assert slow == pytest.approx(usual, rel=0.15)


def test_another_control_rate_holds_in_every_variation(make):
    text = arm(action="max_step: 0.02") + "variations: [{spot.color: blue}]\n"
    for variation in (0, 1):
        env = make(text, control_hz=20, variation=variation, normalize=False)
        assert env.action_space("arm").high[0] == pytest.approx(0.01)
