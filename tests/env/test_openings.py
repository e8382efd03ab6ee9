"""Episodes that begin where recorded ones went, and those that end early: for training."""

from __future__ import annotations

import numpy as np
import pytest
from env_tasks import TWO, digest, facing, moment, physical, play, random_actions, still

from taskbuilder.env.options import Opening
from taskbuilder.errors import UsageError

STEPS = 6
TEXT = facing("left: [self.tcp, block.pose, time_left]", "right: [self.tcp, time_left]")


@pytest.fixture
def opening(make):
    """A recorded beginning of six steps."""
    env = make(TEXT)
    actions = random_actions(env, 1, STEPS)
    return Opening(40, {a: np.array([step[a] for step in actions]) for a in env.possible_agents})


@pytest.fixture
def moments(make, opening):
    """Hashes of all that moves after each step of the recorded beginning."""
    env = make(TEXT)
    env.reset(seed=opening.seed)
    seen = []
    for step in range(opening.steps):
        env.step({agent: actions[step] for agent, actions in opening.actions.items()})
        seen.append(digest(physical(env)))
    return seen


def test_an_episode_goes_on_from_a_step_of_a_recorded_one_with_the_time_that_is_left(
    make, opening, moments
):
    env = make(TEXT, openings=(opening,), opening_share=1.0)
    begun = set()
    for seed in range(12):
        views, infos = env.reset(seed=seed)
        steps = moments.index(digest(physical(env))) + 1
        assert env.episode.steps == infos["left"]["step"] == steps
        assert views["left"][-1] == pytest.approx(1.0 - steps / 50)
        begun.add(steps)
    assert len(begun) > 3


def test_it_repeats_with_its_seed_and_goes_on_like_any_other(make, opening):
    envs = [make(TEXT, openings=(opening,), opening_share=0.5) for _ in range(2)]
    envs[1].reset(seed=99)
    for seed in range(4):
        first = [digest(*env.reset(seed=seed)) for env in envs]
        assert first[0] == first[1]
        played = [play(env, random_actions(env, seed, 3)) for env in envs]
        assert played[0] == played[1]
    env = envs[0]
    env.reset(seed=0)
    while env.agents:
        *_, truncations, _ = env.step(still(env))
    assert env.episode.steps == env.episode.horizon
    assert set(truncations.values()) == {True}


def test_as_many_episodes_as_are_asked_for_take_one_and_the_others_are_as_they_were(make, opening):
    env, plain = make(TEXT, openings=(opening,), opening_share=0.3), make(TEXT)
    begun = 0
    for seed in range(40):
        env.reset(seed=seed)
        if env.episode.steps:
            begun += 1
        else:
            plain.reset(seed=seed)
            assert digest(physical(env)) == digest(physical(plain))
    assert 6 <= begun <= 19


def test_a_share_of_nothing_changes_nothing(make, opening):
    envs = [make(TEXT, openings=(opening,), opening_share=0.0), make(TEXT)]
    for env in envs:
        env.reset(seed=3)
    assert digest(moment(envs[0])) == digest(moment(envs[1]))


def test_a_recording_that_is_over_too_soon_is_left_out(make, opening):
    env = make(TEXT, openings=(opening,), opening_share=1.0, horizon=1)
    plain = make(TEXT, horizon=1)
    for seed in range(3):
        env.reset(seed=seed)
        plain.reset(seed=seed)
        assert env.agents
        assert env.episode.steps == 0
        assert digest(physical(env)) == digest(physical(plain))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"opening_share": 1.5}, "opening_share is 1.5; 0 to 1"),
        ({"patience": 0.0}, "patience is 0.0; seconds, more than 0"),
        ({"opening_share": -0.1}, "opening_share is -0.1"),
        ({"variation": "random"}, "openings belong to one variation"),
    ],
)
def test_a_number_or_a_variation_that_does_not_fit_is_refused(make, opening, options, message):
    with pytest.raises(UsageError, match=message):
        make(TEXT, openings=(opening,), **options)


@pytest.mark.parametrize("asked", [True, False])
def test_a_setback_is_told_and_ends_an_episode_where_that_is_asked_for(make, asked):
    thrown = TWO + '    setback = Below("block", height=0.3)\n'
    env = make(facing(), thrown, end_on_setback=asked)
    _, infos = env.reset(seed=0)
    assert infos["left"]["condition/setback"] == 0.0
    body = env.episode.world.objects["block"].body
    body.place(body.pose().moved((0.3, 0.0, -0.11)))
    _, _, terminations, truncations, infos = env.step(still(env))
    assert infos["left"]["condition/setback"] == 1.0
    assert infos["left"]["failure"] == 0.0
    assert set(terminations.values()) == {asked}
    assert set(truncations.values()) == {False}
    assert env.agents == ([] if asked else ["left", "right"])


RISING = TWO.replace("import ", "import Height, ") + "    progress = 10.0 * Height('block')\n"


def raise_block(env, by):
    body = env.episode.world.objects["block"].body
    body.place(body.pose().moved((0.0, 0.0, by)))


def idle_steps(env, rises):
    """Steps after reset until the end, the block raised by so much before each."""
    _, infos = env.reset(seed=0)
    idle = [infos["left"]["idle"]]
    for rise in rises:
        raise_block(env, rise)
        _, _, terminations, truncations, infos = env.step(still(env))
        idle.append(infos["left"]["idle"])
        if not env.agents:
            assert set(terminations.values()) == {False}
            assert set(truncations.values()) == {True}
            break
    return idle


def test_an_episode_ends_when_progress_has_not_risen_for_as_long_as_patience_lasts(make):
    env = make(facing(), RISING, patience=0.3)
    assert idle_steps(env, [0.0] * 9) == [0, 1, 2, 3]
    assert env.episode.steps == 3


def test_a_rise_makes_patience_begin_again_and_a_small_one_does_not(make):
    env = make(facing(), RISING, patience=0.3)
    assert idle_steps(env, [0.0, 0.2, 0.0, 0.001, 0.0, 0.0])[:6] == [0, 1, 0, 1, 2, 3]


def test_without_patience_idleness_is_only_told(make):
    env = make(facing(), RISING)
    assert idle_steps(env, [0.0] * 12) == list(range(13))


def test_idleness_goes_back_with_a_saved_state(make):
    env = make(facing(), RISING, patience=0.5)
    env.reset(seed=0)
    env.step(still(env))
    state = env.save_state()
    seen = []
    for _ in range(2):
        count = 0
        while env.agents:
            env.step(still(env))
            count += 1
        seen.append(count)
        env.load_state(state)
    assert seen == [4, 4]
