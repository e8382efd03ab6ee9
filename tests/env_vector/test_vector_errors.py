"""What callers get wrong is refused before anything moves."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from vector_tasks import digest, random_actions

from taskbuilder.description import Description, Distance, Near
from taskbuilder.env.errors import ActionError, AgentError, EpisodeOverError
from taskbuilder.env.vector import make_vec
from taskbuilder.errors import UsageError
from taskbuilder.task import load_task

GOOD = np.zeros((2, 7), np.float32)


def with_bad_number(value: float) -> np.ndarray:
    bad = GOOD.copy()
    bad[1, 3] = value
    return bad


@pytest.mark.parametrize(
    ("actions", "error", "says"),
    [
        ({"left": GOOD, "right": with_bad_number(np.nan)}, ActionError, "right in environment 1"),
        ({"left": with_bad_number(np.inf), "right": GOOD}, ActionError, "left in environment 1"),
        ({"left": GOOD[:1], "right": GOOD}, ActionError, r"left has shape \(1, 7\)"),
        ({"left": GOOD, "right": GOOD[:, :3]}, ActionError, r"right has shape \(2, 3\)"),
        ({"left": GOOD, "right": "up"}, ActionError, "right is str"),
        ({"left": [[0.0] * 7, [0.0] * 6], "right": GOOD}, ActionError, "left is list"),
        ({"left": GOOD}, AgentError, "no actions for right; the agents are left, right"),
        ({"left": GOOD, "right": GOOD, "third": GOOD}, AgentError, "no agent third"),
        (GOOD, AgentError, "mapping"),
    ],
)
def test_wrong_actions_change_nothing(vec, actions, error, says):
    env, other = vec(2), vec(2)
    env.reset(seed=1)
    other.reset(seed=1)
    with pytest.raises(error, match=says):
        env.step(actions)
    good = random_actions(env, 1)[0]
    assert digest(env.step(good)) == digest(other.step(good))


def test_wrong_parts_of_actions(vec):
    env = vec(2, flat=False)
    env.reset()
    good = env.action_space.sample()
    with pytest.raises(ActionError, match="left is not a mapping"):
        env.step({**good, "left": {"arm": good["left"]["arm"]}})
    with pytest.raises(ActionError, match="right has shape"):
        env.step({**good, "right": {**good["right"], "gripper": np.zeros(2)}})


def test_nothing_to_step_or_see_before_a_reset(vec):
    env = vec(2)
    with pytest.raises(EpisodeOverError, match="call reset"):
        env.step({"left": GOOD, "right": GOOD})
    with pytest.raises(EpisodeOverError, match="call reset"):
        env.state()


@pytest.mark.parametrize("seed", [-1, 1.5, "one", [1], [1, 2, 3], [1, -2], 2**63])
def test_seeds_that_are_none(vec, seed):
    with pytest.raises(UsageError, match="seed"):
        vec(2).reset(seed=seed)


def test_a_reset_of_some_environments_is_refused(vec):
    with pytest.raises(UsageError, match="reset_mask"):
        vec(2).reset(options={"reset_mask": np.array([True, False])})


def test_an_error_in_this_process_is_raised_here(vec, task_file):
    env = vec(2)
    env.reset(seed=1)
    task_file.with_suffix(".order").write_text("raise")
    with pytest.raises(RuntimeError, match="told to"):
        env.step({"left": GOOD, "right": GOOD})
    with pytest.raises(EpisodeOverError, match="call reset"):
        env.step({"left": GOOD, "right": GOOD})
    env.reset(seed=1)
    env.step({"left": GOOD, "right": GOOD})


def test_workers_need_descriptions_that_can_be_imported(task_file):
    class Local(Description):
        success = Near("ball", "left.tcp", within=0.1)
        reward = (Distance("reach", "left.tcp", "ball"),)

    task = dataclasses.replace(load_task(task_file), declared=Local)
    make_vec(task, 1).close()
    with pytest.raises(UsageError, match="at the top of a module"):
        make_vec(task, 1, 1)
