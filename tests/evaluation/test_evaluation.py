"""Policies are played in episodes of their own, and what they achieve is added up."""

from __future__ import annotations

import pickle
import subprocess
import sys
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from made_rollouts import made_rollout
from made_runs import ENV, sideways, write_task

from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.errors import UsageError
from taskbuilder.evaluation.arms import SUBJECT, Job, TrialConfig, jobs_of, play_all
from taskbuilder.evaluation.summary import summarise
from taskbuilder.policies.fitting import check_fits, options_of
from taskbuilder.policies.grammar import parse_policy
from taskbuilder.policies.trained import Network, TrainedPolicy
from taskbuilder.rollout import play

SEEDS = range(7)  # a goal behind the arm, goals on its way, one where it begins


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return write_task(tmp_path_factory.mktemp("task"))


@pytest.fixture(scope="module")
def env(file):
    made = parallel_env(file)
    yield made
    made.close()


@dataclass(frozen=True)
class Make:
    file: Path

    def __call__(self) -> TaskEnv:
        return parallel_env(self.file)


def test_success_and_stages_count_wherever_in_the_episode_they_were_reached(env):
    played = [play(env, sideways().act, seed) for seed in SEEDS]
    assert any(e.first_success is not None and 1 < e.first_success < 9 for e in played)
    assert {episode.stage[-1] for episode in played} == {1, 2}
    still = play(env, sideways(push=0.0).act, 5)
    assert (still.success, still.first_success, still.stage[-1]) == (False, None, 0)


def test_a_policy_is_asked_at_every_step_about_what_is_seen_then(env):
    seen = []

    def act(observations):
        seen.append(observations["arm"].copy())
        return {"arm": np.array([0.0, 0.5, 0.0, 0.0, 0.0], dtype=np.float32)}

    play(env, act, 2)
    first, _ = env.reset(seed=2)
    assert np.array_equal(seen[0], first["arm"])
    assert [look[-1] for look in seen] == pytest.approx([1.0 - step / 12 for step in range(12)])
    assert all(after[1] > before[1] for before, after in pairwise(seen))


def test_episodes_come_in_order_and_are_the_same_wherever_they_are_played(env, file):
    def elsewhere(function, seeds):
        function = pickle.loads(pickle.dumps(function))  # as on its way to another process
        return map(function, seeds)

    asked = {"forces": True, "explain": True}
    expected = [play(env, sideways().act, seed, **asked) for seed in (4, 1, 5)]
    config = TrialConfig(parse_policy(sideways()), Make(file), Make(file))
    for spread in (map, elsewhere):
        found = [played[SUBJECT] for played in play_all(config, jobs_of((4, 1, 5), 0), spread)]
        assert all(one.equals(other) for one, other in zip(found, expected, strict=True))


def test_episodes_come_as_soon_as_they_have_been_played(file):
    asked = []

    def seeds():
        for seed in range(3):
            asked.append(seed)
            yield seed

    config = TrialConfig(parse_policy(sideways()), Make(file), Make(file))
    episodes = play_all(config, (Job(seed, False) for seed in seeds()))
    next(episodes)
    assert asked == [0]
    episodes.close()


def episode(seed, *, first=None, stage=0, paid=0.0):
    terms = {"near": [paid - 1.0] + [0.0] * 11, "far": [0.0] * 11 + [1.0]}
    held = () if first is None else range(first, 13)
    return made_rollout([0] + [stage] * 12, seed=seed, success=held, terms=terms)


def test_a_summary_is_as_worked_out_by_hand():
    played = [
        episode(10, first=4, stage=3, paid=-8.0),
        episode(11, stage=1, paid=50.0),  # paid best, but failed
        episode(12, first=8, stage=3, paid=-2.0),
        episode(13, stage=0, paid=-20.0),
        episode(14, first=5, stage=3, paid=-3.0),
        episode(15, stage=1, paid=-1.0),
    ]
    summary = summarise(played, stages=4)
    assert (summary.episodes, summary.successes, summary.success_rate) == (6, 3, 0.5)
    assert summary.interval == pytest.approx((0.187616, 0.812384), abs=1e-6)
    assert summary.mean_return == pytest.approx(16.0 / 6.0)
    assert summary.iqm_return == pytest.approx((-8.0 - 3.0 - 2.0 - 1.0) / 4.0)
    assert summary.steps_to_success == 5
    assert (summary.successes_at_end, summary.success_at_end_rate) == (3, 0.5)
    assert summary.interval_at_end == summary.interval
    assert summary.success_held_s == pytest.approx((22 / 30, 0.8))
    assert summary.peak_robot_force is None
    assert summary.stages == (1, 2, 0, 3, 0)
    assert summary.terms == pytest.approx({"near": 10.0 / 6.0, "far": 1.0})
    # In order of merit: failed 13, 15, 11; succeeded 10, 14, 12.
    assert (summary.best, summary.median, summary.failed) == (12, 10, 15)


def test_a_summary_of_failures_and_of_successes_only():
    summary = summarise([episode(1, paid=-3.0), episode(2, paid=-1.0)], stages=0)
    assert (summary.success_rate, summary.steps_to_success, summary.stages) == (0.0, None, (2,))
    assert (summary.best, summary.median, summary.failed) == (2, 2, 2)
    summary = summarise([episode(7, first=1)], stages=0)
    assert (summary.success_rate, summary.best, summary.median) == (1.0, 7, 7)
    assert summary.failed is None


def test_options_are_those_that_policies_see_by_and_never_starts():
    policy = sideways(env={**ENV, "observe": "scene", "opening_share": 0.5, "horizon": 3})
    assert options_of(policy) == {**ENV, "observe": "scene", "horizon": 3}
    with pytest.raises(UsageError, match="does not say what its environment was"):
        options_of(sideways(env=None))


def test_a_policy_of_the_task_fits(env):
    check_fits(sideways(), env)


@pytest.mark.parametrize(
    ("policy", "message"),
    [
        (sideways(task="handover"), "zoo:x was trained on handover, not on sideways"),
        (
            sideways(agents=("left", "right")),
            "zoo:x plays left, right, and sideways as it is now has arm; train anew",
        ),
        (
            sideways(seen=20),
            "zoo:x: arm sees 20 numbers, in sideways as it is now 11; train it anew",
        ),
        (
            sideways(said=7),
            "zoo:x: arm acts by 7 numbers, in sideways as it is now 5; train it anew",
        ),
    ],
    ids=["task", "agents", "sees", "acts"],
)
def test_a_policy_that_does_not_fit_is_refused(policy, message, env):
    with pytest.raises(UsageError, match=message):
        check_fits(policy, env, "zoo:x")


@pytest.mark.parametrize(
    "layers",
    [
        (),
        ((np.zeros((11, 4), np.float32), np.zeros(4, np.float32)),) * 2,
        ((np.zeros((11, 5), np.float32), np.zeros(3, np.float32)),),
        ((np.float32(1.0), np.zeros(5, np.float32)),),
    ],
    ids=["none", "chain", "bias", "scalar"],
)
def test_layers_that_do_not_fit_each_other_are_refused(layers, env):
    policy = TrainedPolicy({"arm": Network(layers, squash=True)}, sideways().about)
    with pytest.raises(UsageError, match="the policy is damaged: its layers do not fit each other"):
        check_fits(policy, env)


def test_summaries_do_not_depend_on_the_order_of_equals():
    played = [episode(seed, first=3, paid=1.0) for seed in (5, 3, 4)]
    summary = summarise(played, stages=0)
    assert (summary.best, summary.median) == (3, 4)
    assert summarise(played[::-1], stages=0) == summary


def test_measuring_and_plotting_need_no_torch():
    names = ("evaluation.assessment", "evaluation.verify", "learn.run_groups", "policies.mixture")
    modules = ", ".join(f"taskbuilder.{name}" for name in names)
    code = f"import sys; sys.modules['torch'] = None; import {modules}"
    subprocess.run([sys.executable, "-c", code], check=True)
