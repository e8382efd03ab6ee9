"""Training rewards: what learners get for the same steps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from taskbuilder.env.vector import make_vec
from taskbuilder.learn.training_rewards import RAW_REWARDS, TRAINING_REWARDS, reads_progress

EVERYWHERE = np.ones(1, dtype=np.bool_)
progresses = st.lists(st.floats(0.0, 1.0), min_size=2, max_size=20)


def infos(progress, success=0.0, failure=0.0, setback=0.0, idle=0.0):
    many = np.zeros_like(np.asarray(progress, float))
    numbers = {
        "training_progress": progress,
        "success": success,
        "failure": failure,
        "steps_without_progress": many + idle,
    }
    numbers["condition/setback"] = setback
    return {name: np.atleast_1d(np.asarray(value, float)) for name, value in numbers.items()}


def paid(made, ladder, reward=0.0, **outcome):
    """What each of two agents is paid at each step of an episode with this progress."""
    made.begin(infos(ladder[0]), EVERYWHERE)
    rewards = np.full((1, 2), reward)
    pays = [made.compute(rewards, infos(now, **outcome)) for now in ladder[1:]]
    assert all(pay.shape == (1, 2) for pay in pays)
    return np.array(pays)[:, 0]


# --- team and local


@pytest.mark.parametrize("name", ["team", "local", "sparse"])
def test_the_environments_own_rewards_are_passed_on(name):
    made = TRAINING_REWARDS[name](1, 0.97)
    rewards = np.array([[1.5, -2.0]])
    made.begin(infos(0.0), EVERYWHERE)
    assert made.compute(rewards, infos(3.0)).tolist() == rewards.tolist()
    assert made.critic_features().shape == (1, made.feature_count) == (1, 0)


def test_local_pay_of_an_environment_adds_up_to_the_teams_reward():
    envs = make_vec("handover", 2, 0, reward=TRAINING_REWARDS["local"].sharing)
    try:
        envs.reset(seed=3)
        envs.action_space.seed(3)
        for _ in range(4):
            _, rewards, _, _, seen = envs.step(envs.action_space.sample())
            own = np.stack([rewards[agent] for agent in envs.agents], 1)
            assert own.sum(1).tolist() == seen["team_reward"].tolist()
            assert (own[:, 0] != own[:, 1]).all()
    finally:
        envs.close()


def test_only_local_pay_differs_between_agents():
    assert {name for name, reward in TRAINING_REWARDS.items() if not reward.shared} == {"local"}
    assert {name for name, made in TRAINING_REWARDS.items() if made.sharing == "local"} == {"local"}


# --- shaped


@given(progresses, st.floats(0.5, 1.0))
def test_shaping_adds_up_to_the_discounted_gain_from_beginning_to_end(ladder, discount):
    made = TRAINING_REWARDS["shaped"](1, discount)
    pays = paid(made, ladder)
    total = (pays.T * discount ** np.arange(len(pays))).sum(1)
    expected = 45.0 * (discount ** len(pays) * ladder[-1] - ladder[0])
    assert total == pytest.approx([expected] * 2, abs=1e-6)


def test_shaping_comes_upon_the_teams_reward():
    pays = paid(TRAINING_REWARDS["shaped"](1, 0.9), [0.1, 0.2, 0.05], reward=-4.0)
    assert pays[:, 0] == pytest.approx([-4.0 + 45.0 * (0.18 - 0.1), -4.0 + 45.0 * (0.045 - 0.2)])


# --- ratchet


@given(progresses)
def test_the_ratchet_pays_for_the_best_progress_and_costs_where_it_is_below(ladder):
    pays = paid(TRAINING_REWARDS["ratchet"](1, 0.97), ladder)
    gained = max(ladder) - ladder[0]
    below = sum(max(ladder[: n + 2]) - now for n, now in enumerate(ladder[1:]))
    assert pays.sum(0) == pytest.approx([0.3 * (150.0 * gained - 3.75 * below)] * 2, abs=1e-6)


@given(progresses)
@example([0.1300777743834516, 0.35916106811385444, 0.35916106811385444])  # a + (b - a) is not b
def test_the_ratchet_pays_only_where_progress_goes_beyond_the_best_so_far(ladder):
    pays = paid(TRAINING_REWARDS["ratchet"](1, 0.97), ladder)[:, 0]
    beyond = [now > max(ladder[: n + 1]) for n, now in enumerate(ladder[1:])]
    assert (pays > 0.0).tolist() == beyond


def test_the_ratchet_takes_nothing_for_staying_where_it_has_paid():
    pays = paid(TRAINING_REWARDS["ratchet"](1, 0.97), [0.1, 0.3, 0.3, 0.2])
    assert pays[:, 0] == pytest.approx([0.3 * 30.0, 0.0, -0.3 * 0.375])


@pytest.mark.parametrize(
    ("outcome", "pay"),
    [
        ({"success": 1.0}, 1.2),
        ({"failure": 1.0}, -0.6),
        ({"setback": 1.0}, -0.6),
        ({"failure": 1.0, "setback": 1.0}, -0.6),
    ],
)
def test_the_ratchet_pays_for_success_at_every_step_and_takes_for_what_is_lost(outcome, pay):
    pays = paid(TRAINING_REWARDS["ratchet"](1, 0.97), [0.2, 0.2, 0.2], **outcome)
    assert pays == pytest.approx(np.full((2, 2), pay))


def test_the_ratchet_leaves_the_teams_reward_out():
    ladder = [0.0, 1.0, 0.5]
    one, other = (
        paid(TRAINING_REWARDS["ratchet"](1, 0.97), ladder, reward=r) for r in (0.0, -50.0)
    )
    assert one.tolist() == other.tolist()


def test_critics_see_the_best_progress_so_far_and_how_long_it_has_not_risen():
    made = TRAINING_REWARDS["ratchet"](1, 0.97)
    made.begin(infos(0.1), EVERYWHERE)
    best = []
    for now, idle in ((0.05, 1.0), (0.2, 0.0), (0.15, 1.0)):
        made.compute(np.zeros((1, 2)), infos(now, idle=idle))
        best.append(made.critic_features())
    assert np.concatenate(best) == pytest.approx(np.array([[0.1, 1.0], [0.2, 0.0], [0.2, 1.0]]))
    assert made.critic_features().dtype == np.float32
    assert made.feature_count == 2


# --- many environments


@pytest.mark.parametrize("name", ["shaped", "ratchet"])
def test_environments_have_nothing_to_do_with_each_other(name):
    draws = np.random.default_rng(0)
    ladders = draws.uniform(0.0, 1.0, (3, 6))
    many = TRAINING_REWARDS[name](3, 0.9)
    many.begin(infos(ladders[:, 0]), np.ones(3, dtype=np.bool_))
    together = [many.compute(np.zeros((3, 2)), infos(ladders[:, n])) for n in range(1, 6)]
    for number, ladder in enumerate(ladders):
        alone = paid(TRAINING_REWARDS[name](1, 0.9), ladder)
        assert np.array(together)[:, number] == pytest.approx(alone)


@pytest.mark.parametrize("name", ["shaped", "ratchet"])
def test_an_episode_that_begins_starts_afresh_and_leaves_the_others(name):
    made = TRAINING_REWARDS[name](2, 1.0)
    made.begin(infos([0.0, 0.0]), np.array([True, True]))
    made.compute(np.zeros((2, 1)), infos([0.4, 0.4]))
    made.begin(infos([0.1, 0.1]), np.array([True, False]))
    pay = made.compute(np.zeros((2, 1)), infos([0.2, 0.5]))
    assert pay[:, 0] == pytest.approx([4.5, 4.5])  # a tenth more than 0.1, and than 0.4


# --- runs of earlier versions


@pytest.mark.parametrize("name", ["shaped", "ratchet"])
def test_runs_of_earlier_versions_keep_the_scale_of_the_descriptions_progress(name):
    ladder = np.array([0.0, 0.2, 0.7, 0.5, 1.0])
    raw = RAW_REWARDS[name](1, 0.97)
    many = [{**infos(0.0), "progress": np.array([15.0 * now])} for now in ladder]
    raw.begin(many[0], EVERYWHERE)
    pays = [raw.compute(np.zeros((1, 2)), now)[0] for now in many[1:]]
    normalized = paid(TRAINING_REWARDS[name](1, 0.97), ladder)
    assert np.array(pays) == pytest.approx(normalized)  # tops of 15 are paid as they were


def test_only_rewards_that_read_the_progress_differ_for_earlier_runs():
    changed = {name for name in TRAINING_REWARDS if RAW_REWARDS[name] is not TRAINING_REWARDS[name]}
    assert changed == {name for name in TRAINING_REWARDS if reads_progress(name)}
