"""The option ``grasp``: how the grippers of an environment hold objects."""

from __future__ import annotations

import pickle
from contextlib import closing

import numpy as np
import pytest
from env_tasks import LIBRARY

from taskbuilder.env.parallel import parallel_env
from taskbuilder.env.vector import make_vec
from taskbuilder.errors import UsageError
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout.files import load_rollouts, save_rollouts
from taskbuilder.rollout.play import play, replay
from taskbuilder.task import load_task
from taskbuilder.world.attaching import AttachingFingers

SEED = 1


def expert(env):
    return Expert(env)


def attaching(env):
    """Which robots attach what they close around."""
    robots = env.episode.world.robots.items()
    return {name for name, robot in robots if isinstance(robot.gripper, AttachingFingers)}


def test_by_default_no_gripper_attaches():
    with closing(parallel_env("handover", horizon=1)) as env:
        assert env.options.grasp == "task"
        assert not attaching(env)


def test_a_loaded_task_keeps_its_rule():
    task = load_task("handover", grasp="attach")
    with closing(parallel_env(task, horizon=1)) as env:
        assert attaching(env) == {"left", "right"}
    with closing(parallel_env(task, horizon=1, grasp="friction")) as env:
        assert not attaching(env)


def test_robots_without_fingers_stay_what_they_are():
    with closing(parallel_env("pusher_and_picker", horizon=1, grasp="attach")) as env:
        assert len(attaching(env)) == 1
        assert len(env.possible_agents) == 2


def test_a_rule_that_is_none_is_refused():
    with pytest.raises(UsageError, match='grasp "magnet": one of: task, friction, attach'):
        parallel_env("handover", grasp="magnet")


def test_a_rule_that_no_robot_can_have_is_refused():
    with pytest.raises(UsageError, match="has fingers to hold objects by"):
        parallel_env(
            "handover", grasp="attach", robots={"left": "ur5e_suction", "right": "ur5e_pusher"}
        )


@pytest.mark.parametrize("task", LIBRARY)
def test_the_expert_of_each_task_of_the_paper_succeeds(task, tmp_path):
    """The episode is also recorded, and replayed to the bit in another environment."""
    with closing(parallel_env(task, grasp="attach")) as env:
        played = play(env, expert(env), SEED)
        assert played.success_at_end, played.trouble
    save_rollouts(tmp_path / "r.npz", [played])
    (loaded,) = load_rollouts(tmp_path / "r.npz")
    assert loaded.options.grasp == "attach"
    with closing(parallel_env(task, grasp="attach")) as env:
        play(env, expert(env), SEED + 1)  # ends holding something
        assert replay(env, loaded).equals(played)


def test_a_state_in_which_both_hold_goes_on_to_the_bit():
    with closing(parallel_env("handover", grasp="attach", flat=True)) as env:
        played = play(env, expert(env), SEED)
        actions = [{a: played.actions[a][i] for a in played.actions} for i in range(played.steps)]
        env.reset(seed=SEED)
        rows, kept, begun = [], None, 0
        for step, action in enumerate(actions):
            if kept is None and all(env.episode.holding(robot) for robot in env.agents):
                kept, begun = env.episode.save(), step
            rows.append(repr(env.step(action)[:2]))
        assert 0 < begun < played.steps - 10
        for _ in range(2):
            env.episode.load(kept)
            env.agents = list(env.possible_agents)
            again = [repr(env.step(action)[:2]) for action in actions[begun:]]
            assert again == rows[begun:]
            env.reset(seed=SEED + 1)


def test_copies_have_the_same_rule():
    with closing(parallel_env("handover", grasp="attach", horizon=4)) as env:
        env.reset(seed=1)
        with closing(pickle.loads(pickle.dumps(env))) as copy:
            assert attaching(copy) == {"left", "right"}


def test_processes_play_the_same_episodes():
    def played(workers):
        with closing(make_vec("pick_push_place", 2, workers, grasp="attach")) as envs:
            rng = np.random.default_rng(0)
            seen = [envs.reset(seed=3)[0]]
            for _ in range(8):
                actions = {
                    agent: rng.uniform(-1, 1, space.shape).astype(np.float32)
                    for agent, space in envs.action_space.items()
                }
                seen.append(envs.step(actions)[:2])
            return repr(seen)

    assert played(0) == played(2)
