"""Experts whose robots carry out their actions some control steps late."""

from __future__ import annotations

import pytest
from written_experts import RIGHT, made

from taskbuilder.expert import Expert

MODES = (
    "arm: tcp_delta",
    "arm: tcp_delta, max_step: 0.03, frame: tcp, turn: full",
    "arm: tcp_pose",
    "arm: tcp_path",
    "arm: joint_delta",
    "arm: joint_position",
    "arm: joint_velocity",
    "arm: tcp_delta, gripper: continuous",
)
STAGES = (
    "arm: {grasp: block.middle}",
    "arm: {bring: block, to: goal}",
    "arm: [release, {retreat: 0.05}]",
)


def played(folder, *, stages=STAGES, **scene):
    env = made(folder, *stages, randomize=True, steps=80, **scene)
    found = Expert(env).play(seed=0)
    env.close()
    return found


@pytest.mark.parametrize("mode", MODES)
def test_an_arm_grasps_brings_and_releases_in_every_action_mode(mode, tmp_path):
    late = played(tmp_path, action=mode, extra="randomize: {arm.delay: {choice: [2]}}")
    assert late.trouble is None
    assert len(late.stage_ends) == len(STAGES)


def test_it_takes_the_delay_and_no_more_for_each_motion_and_each_grip(tmp_path):
    ends = []
    for delay in (0, 3):
        folder = tmp_path / f"by_{delay}"
        folder.mkdir()
        late = played(folder, extra=f"randomize: {{arm.delay: {{choice: [{delay}]}}}}")
        assert late.trouble is None
        ends.append(late.stage_ends[-1])
    acts = 2 + 1 + 1 + 1 + 1  # to the block and in, close, bring, open, retreat
    assert ends[0] < ends[1] <= ends[0] + 3 * acts


def test_how_long_it_waits_depends_on_the_longest_delay_that_may_be_drawn(tmp_path):
    """Policies that learn from it do not observe the delay of an episode."""
    env = made(tmp_path, *STAGES, randomize=True, extra="randomize: {arm.delay: {choice: [0, 2]}}")
    expert, ends = Expert(env), {}
    for seed in range(6):
        late = expert.play(seed=seed)
        ends[env.episode.delay("arm")] = late.stage_ends[-1]
    env.close()
    assert 0 <= ends[2] - ends[0] <= 2


def test_two_robots_with_different_delays_play_together(tmp_path):
    late = played(
        tmp_path,
        stages=(*STAGES[:2], "{arm: release, right: {reach: spot}}"),
        robots=RIGHT,
        extra="randomize: {arm.delay: {choice: [1]}, right.delay: {choice: [4]}}",
    )
    assert late.trouble is None
