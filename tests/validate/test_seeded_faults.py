"""Faults that are seeded in environments are all found, each by its code, and sound ones pass."""

from __future__ import annotations

import re
from contextlib import closing
from copy import deepcopy
from itertools import islice

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import VectorWrapper
from pettingzoo.utils import BaseParallelWrapper
from pettingzoo.utils.conversions import parallel_to_aec
from seeded_faults import JOINT, PARALLEL, TURN_BASED, VECTOR, Reversed, exchanged

from taskbuilder import JointEnv, catalogue, check_env, make_vec, parallel_env
from taskbuilder.env.actions import RobotActions
from taskbuilder.env.episode import Episode
from taskbuilder.env.observing import Observer
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.env.shared_buffers import StepView
from taskbuilder.errors import UsageError
from taskbuilder.learn.wrappers import StartPrefix, TrainingWrappers
from taskbuilder.validate.comparing import CHECKS, Compared, play_ends
from taskbuilder.validate.playing import random_actions
from taskbuilder.validate.stages import SingleAgent, TurnBased

pytestmark = pytest.mark.in_process

TASKS = sorted(name for name, entry in catalogue().tasks.items() if entry.trusted)
LAMP = "    lamp: {position: [0.05, 0.25, 0.2]}\n"
CAMERAS = """\
  cameras:
    front: {position: [0, -2, 1], look_at: [0, 0, 0.3]}
    side: {position: [2, 0, 1], look_at: [0, 0, 0.3]}
"""
SMALL = {"camera_size": (32, 24)}


@pytest.fixture
def pair(write_pair):
    return write_pair(("episode_steps: 30", "episode_steps: 20"), (LAMP, LAMP + CAMERAS))


def assert_found(findings, code, text):
    assert {finding.code for finding in findings} == {code}, findings
    assert any(re.search(text, finding.message) for finding in findings), findings


@pytest.mark.parametrize("fault", PARALLEL)
def test_a_fault_of_the_multi_agent_view_is_found(fault, pair):
    spoilt, code, text, options = PARALLEL[fault]
    mode = {"render_mode": "rgb_array"} if "render" in fault else {}
    with closing(parallel_env(pair, **mode, **options)) as env:
        assert_found(check_env(spoilt(env), seeds=(0,), raises=False), code, text)


@pytest.mark.parametrize("fault", JOINT)
def test_a_fault_of_the_joint_view_is_found(fault, pair):
    spoilt, code, text, options = JOINT[fault]
    made = Reversed if spoilt is Reversed else JointEnv
    with closing(made(pair, **options)) as env:
        wrapped = env if spoilt is Reversed else spoilt(env)
        assert_found(check_env(wrapped, seeds=(0,), raises=False), code, text)


@pytest.mark.parametrize("fault", TURN_BASED)
def test_a_fault_of_the_turn_based_view_is_found(fault, pair):
    spoilt, code, text, options = TURN_BASED[fault]
    with closing(parallel_env(pair, **options)) as env:
        assert_found(check_env(spoilt(parallel_to_aec(env)), seeds=(0,), raises=False), code, text)


@pytest.mark.parametrize("fault", VECTOR)
def test_a_fault_of_the_vector_view_is_found(fault, pair):
    spoilt, text = VECTOR[fault]
    pictures = {"cameras": ("front",), **SMALL} if "picture" in fault else {}
    with closing(make_vec(pair, 2, horizon=6, **pictures)) as env:
        assert_found(check_env(spoilt(env), seeds=(0,), raises=False), "TB584", text)


OPTIONS = {
    "default": {},
    "local": {"reward": "local", "normalize": False, "frame": "base", "rotation": "matrix"},
    "sparse": {"reward": "sparse", "flat": False, "control_hz": 5, "horizon": 9},
    "randomized": {"randomize": "all", "variation": "random", "position_noise": 0.01},
    "scene": {"observe": "scene", "distances": "log"},
    "pictures": {"cameras": ("front", "side"), **SMALL},
}
QUICK = ("local", "pictures")


@pytest.mark.parametrize(
    "options",
    [
        pytest.param(options, id=name, marks=() if name in QUICK else pytest.mark.slow)
        for name, options in OPTIONS.items()
    ],
)
def test_sound_environments_pass_with_all_options_in_all_views(options, pair):
    with closing(parallel_env(pair, render_mode="rgb_array", **options)) as env:
        assert check_env(env, raises=False) == ()
        assert check_env(BaseParallelWrapper(env), raises=False) == ()
        assert check_env(parallel_to_aec(env), raises=False) == ()
    with closing(JointEnv(pair, render_mode="rgb_array", **options)) as env:
        assert check_env(env, raises=False) == ()
        assert check_env(gymnasium.wrappers.TimeLimit(env, 5), raises=False) == ()
    vectors = options | {"horizon": 6} | SMALL
    for mode in ("SameStep", "NextStep"):
        with closing(make_vec(pair, 3, autoreset=mode, **vectors)) as env:
            assert check_env(env, raises=False) == ()
            assert check_env(VectorWrapper(env), raises=False) == ()


@pytest.mark.slow  # proofs have asked the same of every task
@pytest.mark.parametrize("name", TASKS)
def test_every_task_of_the_library_is_what_its_scene_has(name):
    with closing(parallel_env(name, **SMALL)) as env:
        compared = Compared(env, env)
        play_ends(compared, 0, list(islice(random_actions(env, 0), 6)))
        turns = Compared(TurnBased(parallel_to_aec(env)), env)
        play_ends(turns, 1, list(islice(random_actions(env, 1), 2)))
    with closing(JointEnv(name, **SMALL)) as env:
        joint = Compared(SingleAgent(env), env.parallel)
        play_ends(joint, 2, [{"agent": env.action_space.sample()}])
    for played in (compared, turns, joint):
        assert not any(played.wrong.values()), played.wrong


# --- what wrappers change on purpose


CHANGED = {
    "observations": "observations are late",
    "rewards": "the reward is doubled",
    "actions": "an action is halved",
    "ends": "ends are exchanged",
}


@pytest.mark.parametrize("change", CHANGED)
def test_what_a_wrapper_changes_on_purpose_is_not_compared(change, pair):
    spoilt, _, _, options = PARALLEL[CHANGED[change]]
    with closing(parallel_env(pair, **options)) as env:
        assert check_env(spoilt(env), seeds=(0,), changes=[change], raises=False) == ()
        others = set(CHANGED) - {change}
        assert check_env(spoilt(env), seeds=(0,), changes=others, raises=False) != ()


def test_another_word_for_a_change_is_refused(pair):
    with (
        closing(parallel_env(pair)) as env,
        pytest.raises(UsageError, match='changes has "reward"; did you mean "rewards"'),
    ):
        check_env(env, changes=["reward"])


class Fewer(BaseParallelWrapper):
    """Observations of another size, with another space."""

    def __init__(self, env):
        super().__init__(env)
        spaces = {agent: env.observation_space(agent) for agent in env.possible_agents}
        self.spaces = {
            agent: gymnasium.spaces.Box(space.low[:3], space.high[:3])
            for agent, space in spaces.items()
        }

    def observation_space(self, agent):
        return self.spaces[agent]

    def reset(self, seed=None, options=None):
        seen, infos = super().reset(seed=seed, options=options)
        return {agent: values[:3] for agent, values in seen.items()}, infos

    def step(self, actions):
        seen, *rest = super().step(actions)
        return {agent: values[:3] for agent, values in seen.items()}, *rest


def test_observations_in_a_space_of_their_own_are_not_compared(pair):
    with closing(parallel_env(pair)) as env:
        assert check_env(Fewer(env), raises=False) == ()


class Twice(BaseParallelWrapper):
    """Repeats every action."""

    def step(self, actions):
        returned = super().step(actions)
        return super().step(actions) if self.agents else returned


def test_steps_that_are_left_out_are_found(pair):
    with closing(parallel_env(pair)) as env:
        assert_found(
            check_env(Twice(env), raises=False),
            "TB583",
            "after 1 steps of the environment, its episode has had 2",
        )
        assert check_env(Twice(env), changes=["actions"], raises=False) == ()


def test_wrappers_for_training_pass(pair):
    with closing(parallel_env(pair)) as env:
        env.reset(seed=3)
        actions = list(islice(random_actions(env, 0), 4))
        recorded = {agent: np.array([a[agent] for a in actions]) for agent in env.agents}
        prefixes = (StartPrefix(3, recorded),)
        wrappers = TrainingWrappers(start_prefixes=prefixes, start_share=0.5)
        assert check_env(wrappers(env), raises=False) == ()


# --- in validations: faults of the library itself


def exchange_ends(patch):
    truncated = Episode.truncated.fget
    terminated = Episode.terminated.fget
    patch.setattr(Episode, "terminated", property(lambda self: self.steps >= self.horizon))
    patch.setattr(Episode, "truncated", property(lambda self: terminated(self) or truncated(self)))


def keep_failed(patch):
    reset = Episode.reset

    def keeping(self, seed):
        failed = self.failed
        reset(self, seed)
        self.failed = self.failed or failed

    patch.setattr(Episode, "reset", keeping)


def halve_actions(patch):
    physical = RobotActions.physical
    patch.setattr(
        RobotActions, "physical", lambda self, values: physical(self, [0.5 * v for v in values])
    )


def exchange_actions(patch):
    split = JointEnv._split
    patch.setattr(JointEnv, "_split", lambda self, action: exchanged(split(self, action)))


def exchange_observations(patch):
    observe = Observer.observe

    patch.setattr(Observer, "observe", lambda self, episode: exchanged(observe(self, episode)))


def exchange_views(patch):
    made = Observer.__init__

    def spoilt(self, *arguments):
        made(self, *arguments)
        self._views = exchanged(self._views)

    patch.setattr(Observer, "__init__", spoilt)


def delay_observations(patch):
    observe = Observer.observe

    def late(self, episode):
        now = observe(self, episode)
        before = self.__dict__.get("before", now) if episode.steps else now
        self.before = deepcopy(now)
        return before

    patch.setattr(Observer, "observe", late)


def freeze_state(patch):
    state = Observer.state

    def frozen(self, episode):
        if not episode.steps:
            self.kept = state(self, episode)
        return self.kept.copy()

    patch.setattr(Observer, "state", frozen)


def freeze_pictures(patch):
    look = Observer._look

    def frozen(self, episode, cameras):
        self.__dict__.setdefault("first", look(self, episode, list(cameras)))
        return self.first

    patch.setattr(Observer, "_look", frozen)


def freeze_render(patch):
    render, kept = TaskEnv.render, []

    def frozen(self):
        kept.append(render(self))
        return kept[0]

    patch.setattr(TaskEnv, "render", frozen)


def double_reward(patch):
    patch.setattr(TaskEnv, "team_reward", lambda self: 2.0 * self.episode.outcome.team)


def exchange_rows(patch):
    write = StepView.write
    patch.setattr(StepView, "write", lambda self, row, *values: write(self, 1 - row, *values))


LIBRARY_FAULTS = {
    exchange_ends: "TB581",
    keep_failed: "TB582",
    halve_actions: "TB583",
    exchange_actions: "TB583",
    exchange_observations: "TB577",
    exchange_views: "TB577",
    delay_observations: "TB577 TB578",
    freeze_state: "TB577",
    freeze_pictures: "TB578",
    freeze_render: "TB578",
    double_reward: "TB579",
    exchange_rows: "TB584",
}


@pytest.mark.parametrize("fault", LIBRARY_FAULTS, ids=lambda fault: fault.__name__)
def test_validate_finds_a_fault_of_the_library(fault, prove, monkeypatch):
    fault(monkeypatch)
    report = prove((LAMP, LAMP + CAMERAS), only=("contract",))
    assert {f.code for f in report.findings} == {*LIBRARY_FAULTS[fault].split()}, report.findings


def test_validate_passes_without_one(prove):
    report = prove((LAMP, LAMP + CAMERAS), only=("contract",))
    assert report.findings == ()
    assert {check.code for family in report.families for check in family.checks} >= set(CHECKS)
