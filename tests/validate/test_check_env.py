"""Any environment is checked in one call, and what the checks are for is broken here."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from pettingzoo.utils import BaseParallelWrapper

import taskbuilder
from taskbuilder import JointEnv, TaskEnv, check_env
from taskbuilder.env.options import make_options
from taskbuilder.errors import UsageError
from taskbuilder.task import load_task
from taskbuilder.validate.environments import ContractError

pytestmark = pytest.mark.in_process  # environments are broken in this one


def codes(findings):
    return {finding.code for finding in findings}


@pytest.fixture
def make(write_pair):
    """An environment of the task for two arms, of some class."""
    made = []

    def make_env(sort=TaskEnv, **options):
        task = load_task(write_pair(("episode_steps: 30", "episode_steps: 24")))
        made.append(sort(task, make_options(**options), "rgb_array" if sort.pictured else None))
        return made[-1]

    yield make_env
    for env in made:
        env.close()


class Own(TaskEnv):
    pictured = False


class Reusing(Own):
    """Gives the same arrays at every step."""

    def observe(self):
        seen = super().observe()
        kept = self.__dict__.setdefault("kept", {a: s.copy() for a, s in seen.items()})
        for agent, array in kept.items():
            array[:] = seen[agent]
        return kept


class Seedless(Own):
    def reset(self, seed=None, options=None):
        return super().reset(options=options)


class Same(Own):
    def reset(self, seed=None, options=None):
        return super().reset(seed=3, options=options)


class UnseededLater(Own):
    def reset(self, seed=None, options=None):
        return super().reset(seed=np.random.randint(1000) if seed is None else seed)


class Infinite(Own):
    def _rewards(self):
        rewards = super()._rewards()
        return rewards | {"left": float("inf")} if self.episode.steps > 20 else rewards


class Keeping(Own):
    def reset(self, seed=None, options=None):
        found = super().reset(seed=seed, options=options)
        self.__dict__.setdefault("states", []).append(self.save_state())
        return found


class Hoarding(Own):
    def reset(self, seed=None, options=None):
        self.__dict__.setdefault("kept", []).append(np.ones(5_000_000))
        return super().reset(seed=seed, options=options)


class Endless(Own):
    def step(self, actions):
        if self.episode.steps == self.episode.horizon - 1:
            self.reset()
        return super().step(actions)


class Blind(Own):
    def observe(self):
        return {agent: seen for agent, seen in super().observe().items() if agent != "left"}


class Pictured(Own):
    pictured = True
    picture = None

    def render(self):
        return self.picture


class Floats(Pictured):
    picture = np.random.default_rng(0).random((4, 4, 3))


class Black(Pictured):
    picture = np.zeros((4, 4, 3), dtype=np.uint8)


@pytest.mark.parametrize(
    ("sort", "code", "said"),
    [
        (Reusing, "TB526", "what left has seen changes at the next step"),
        (Seedless, "TB575", "the same seed and actions give another episode"),
        (Same, "TB575", "every seed places all things alike"),
        (UnseededLater, "TB575", "begun without a seed, begins otherwise"),
        (Infinite, "TB576", r"left is paid inf \(seed 0, step 21\)"),
        (Keeping, "TB572", "each reset keeps 1 saved states"),
        pytest.param(
            Hoarding, "TB572", "KB that no other gives back", marks=pytest.mark.slow, id="Hoarding"
        ),
        (Endless, "TB573", "goes on after its 24 control steps"),
        (Blind, "TB574", r"left sees nothing \(seed 0, step 0\)"),
        (Pictured, "TB571", "render gives nothing"),
        (Floats, "TB571", r"render gives an array \(4, 4, 3\) of float64"),
        (Black, "TB571", "render gives one colour, black"),
    ],
)
def test_what_is_wrong_with_an_environment_is_found(sort, code, said, make):
    env = make(sort)
    with pytest.raises(ContractError, match=said) as caught:
        check_env(env)
    assert codes(caught.value.findings) == {code}
    assert codes(check_env(env, raises=False)) == {code}


def test_a_sound_environment_passes_however_it_is_wrapped(make):
    env = make(Own)
    assert check_env(env) == ()
    assert check_env(BaseParallelWrapper(env)) == ()


def test_one_agent_s_environment_passes(write_pair):
    env = JointEnv(write_pair(), render_mode=None)
    assert check_env(gymnasium.wrappers.TimeLimit(env, 10)) == ()
    env.close()


class Stranger(gymnasium.Env):
    """Has nothing to do with taskbuilder, and an end of its own."""

    observation_space = spaces.Box(-1, 1, (2,), np.float64)
    action_space = spaces.Discrete(2)
    length = 20

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.left = self.length
        return self.np_random.uniform(-1, 1, 2), {}

    def step(self, action):
        self.left -= 1
        return self.np_random.uniform(-1, 1, 2), float(action), self.left <= 0, False, {}


class Careless(Stranger):
    def step(self, action):
        _, *rest = super().step(action)
        return np.random.uniform(-1, 1, 2), *rest


class Longest(Stranger):
    length = 10**9


def test_environments_of_others_are_checked_too():
    assert check_env(Stranger()) == ()
    assert codes(check_env(Careless(), raises=False)) == {"TB575"}
    assert codes(check_env(Longest(), max_steps=50, raises=False)) == {"TB573"}


@pytest.mark.parametrize("what", [None, "handover", object()])
def test_what_is_no_environment_is_refused(what):
    with pytest.raises(UsageError, match="neither a PettingZoo ParallelEnv"):
        check_env(what)


def test_it_is_there_by_name():
    assert taskbuilder.check_env is check_env
    assert "check_env" in dir(taskbuilder)


# --- in validations


def test_an_agent_that_sees_nothing_is_found(prove):
    nothing = ("left: [self.tcp, cube.position]", "left: []")
    report = prove(nothing, only=("contract",))
    assert codes(report.findings) == {"TB574"}
    assert report.findings[0].location.line > 1


@pytest.mark.parametrize(
    ("name", "spoilt", "code"),
    [
        ("_rewards", lambda env, said: said | {"left": float("inf")}, "TB576"),
        ("render", lambda env, said: None, "TB571"),
        ("render", lambda env, said: said / 255.0, "TB571"),
        ("render", lambda env, said: 0 * said, "TB571"),
    ],
)
def test_the_contract_family_finds_it(name, spoilt, code, prove, monkeypatch):
    whole = getattr(TaskEnv, name)

    def spoil(env):
        said = whole(env)
        return spoilt(env, said) if name == "render" or env.episode.steps > 20 else said

    monkeypatch.setattr(TaskEnv, name, spoil)
    report = prove(("    lamp: {position: [0.05, 0.25, 0.2]}\n", LAMP), only=("contract",))
    assert codes(report.findings) == {code}


LAMP = """\
    lamp: {position: [0.05, 0.25, 0.2]}
  cameras:
    front: {position: [0, -2, 1], look_at: [0, 0, 0.3]}
"""


def test_an_episode_that_does_not_end_is_found_before_it_is_waited_for(prove, monkeypatch):
    monkeypatch.setattr("taskbuilder.env.episode.Episode.truncated", False)
    report = prove(only=("contract",))
    assert codes(report.findings) == {"TB573"}


def test_states_kept_at_resets_are_found(prove, monkeypatch):
    reset = TaskEnv.reset

    def keeping(env, seed=None, options=None):
        found = reset(env, seed, options)
        env.__dict__.setdefault("states", []).append(env.save_state())
        return found

    monkeypatch.setattr(TaskEnv, "reset", keeping)
    assert codes(prove(only=("contract",)).findings) == {"TB572"}
