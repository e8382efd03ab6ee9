from __future__ import annotations

import pytest
import torch
import torchrl_rollout
from torchrl.envs import MarlGroupMapType, PettingZooWrapper
from torchrl.envs.utils import check_env_specs

import taskbuilder
from taskbuilder import NumericInfos

TASKS = ("collaborative_lift", "handover", "pick_push_place")


@pytest.mark.parametrize("groups", list(MarlGroupMapType))
@pytest.mark.parametrize("task", TASKS)
def test_an_environment_passes_its_check(task, groups):
    numeric = NumericInfos(taskbuilder.parallel_env(task))
    env = PettingZooWrapper(numeric, group_map=groups, return_state=True)
    check_env_specs(env)
    env.close()


def test_an_environment_of_dictionaries_passes_its_check():
    env = NumericInfos(taskbuilder.parallel_env("handover", flat=False))
    wrapped = PettingZooWrapper(env, group_map=MarlGroupMapType.ONE_GROUP_PER_AGENT)
    check_env_specs(wrapped)
    wrapped.close()


def test_a_rollout_is_a_whole_episode():
    rollout = torchrl_rollout.main(50)
    assert rollout.batch_size == torch.Size([50])
    assert rollout["left", "observation"].shape == (50, 1, 20)
    assert rollout["next", "left", "truncated"].flatten().tolist() == [False] * 49 + [True]
    assert torch.isfinite(rollout["next", "left", "reward"]).all()
    team = rollout["next", "left", "info", "team_reward"].flatten()
    assert torch.equal(team, rollout["next", "left", "reward"].flatten())
    assert rollout["state"].shape[0] == 50


def test_rollouts_repeat_with_the_seed():
    env = torchrl_rollout.make()
    seen = []
    for _ in range(2):
        env.set_seed(5)
        torch.manual_seed(5)
        seen.append(env.rollout(10)["next", "right", "observation"])
    assert torch.equal(*seen)
    env.close()
