"""Wrappers for training: episodes that begin where recorded ones went, and that end early."""

from __future__ import annotations

import numpy as np
import pytest
from env_tasks import TWO, digest, facing, moment, physical, play, random_actions, still

from taskbuilder.env.errors import EpisodeOverError
from taskbuilder.env.vector import make_vec
from taskbuilder.errors import UsageError
from taskbuilder.learn.wrappers import NoProgressTimeout, StartPrefix, TrainingWrappers

STEPS = 6
TEXT = facing("left: [self.tcp, block.pose, time_left]", "right: [self.tcp, time_left]")


@pytest.fixture
def prefix(make):
    """A recorded beginning of six steps."""
    env = make(TEXT)
    actions = random_actions(env, 1, STEPS)
    return StartPrefix(
        40, {a: np.array([step[a] for step in actions]) for a in env.possible_agents}
    )


def started(make, prefix, share, **options):
    """An environment of which a share of the episodes go on from the recorded beginning."""
    wrappers = TrainingWrappers(start_prefixes=(prefix,), start_share=share)
    return wrappers(make(TEXT, **options))


@pytest.fixture
def moments(make, prefix):
    """Hashes of all that moves after each step of the recorded beginning."""
    env = make(TEXT)
    env.reset(seed=prefix.seed)
    seen = []
    for step in range(prefix.steps):
        env.step({agent: actions[step] for agent, actions in prefix.actions.items()})
        seen.append(digest(physical(env)))
    return seen


def test_an_episode_goes_on_from_a_step_of_a_recorded_one_with_the_time_that_is_left(
    make, prefix, moments
):
    env = started(make, prefix, 1.0)
    begun = set()
    for seed in range(12):
        views, infos = env.reset(seed=seed)
        steps = moments.index(digest(physical(env))) + 1
        assert env.episode.steps == infos["left"]["step"] == steps
        assert views["left"][-1] == pytest.approx(1.0 - steps / 50)
        begun.add(steps)
    assert len(begun) > 3


def test_it_repeats_with_its_seed_and_goes_on_like_any_other(make, prefix):
    envs = [started(make, prefix, 0.5) for _ in range(2)]
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


def test_as_many_episodes_as_are_asked_for_take_one_and_the_others_are_as_they_were(make, prefix):
    env, plain = started(make, prefix, 0.3), make(TEXT)
    begun = 0
    for seed in range(40):
        env.reset(seed=seed)
        if env.episode.steps:
            begun += 1
        else:
            plain.reset(seed=seed)
            assert digest(physical(env)) == digest(physical(plain))
    assert 6 <= begun <= 19


def test_a_share_of_nothing_changes_nothing(make, prefix):
    envs = [started(make, prefix, 0.0), make(TEXT)]
    for env in envs:
        env.reset(seed=3)
    assert digest(moment(envs[0])) == digest(moment(envs[1]))


def test_a_recording_that_is_over_too_soon_is_left_out(make, prefix):
    env = started(make, prefix, 1.0, horizon=1)
    plain = make(TEXT, horizon=1)
    for seed in range(3):
        env.reset(seed=seed)
        plain.reset(seed=seed)
        assert env.agents
        assert env.episode.steps == 0
        assert digest(physical(env)) == digest(physical(plain))


@pytest.mark.parametrize(
    ("share", "options", "message"),
    [
        (1.5, {}, "start_share is 1.5; 0 to 1"),
        (-0.1, {}, "start_share is -0.1"),
        (0.5, {"variation": "random"}, "start_prefixes belong to one variation"),
    ],
)
def test_a_share_or_a_variation_that_does_not_fit_is_refused(make, prefix, share, options, message):
    with pytest.raises(UsageError, match=message):
        started(make, prefix, share, **options)


def test_no_time_at_all_is_refused(make):
    with pytest.raises(UsageError, match=r"no_progress_timeout_s is 0\.0; seconds, more than 0"):
        TrainingWrappers(no_progress_timeout_s=0.0)(make(TEXT))


@pytest.mark.parametrize(
    ("option", "wrapper"),
    [
        ("end_on_setback", "EndOnSetback"),
        ("patience", "NoProgressTimeout"),
        ("openings", "StartPrefixes"),
        ("opening_share", "StartPrefixes"),
    ],
)
def test_what_was_an_option_says_which_wrapper_took_its_place(make, option, wrapper):
    with pytest.raises(UsageError, match=rf"{option} is no option .*learn\.wrappers\.{wrapper}"):
        make(TEXT, **{option: 1})


def test_nothing_is_put_around_where_nothing_is_asked_for(make):
    env = make(TEXT)
    assert TrainingWrappers()(env) is env


@pytest.mark.parametrize("asked", [True, False])
def test_a_setback_is_told_and_ends_an_episode_where_that_is_asked_for(make, asked):
    thrown = TWO + '    setback = Below("block", height=0.3)\n'
    env = TrainingWrappers(end_on_setback=asked)(make(facing(), thrown))
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


def steps_without_progress(env, rises):
    """Steps after reset until the end, the block raised by so much before each."""
    _, infos = env.reset(seed=0)
    counts = [infos["left"]["steps_without_progress"]]
    for rise in rises:
        raise_block(env, rise)
        _, _, terminations, truncations, infos = env.step(still(env))
        counts.append(infos["left"]["steps_without_progress"])
        if not env.agents:
            assert set(terminations.values()) == {False}
            assert set(truncations.values()) == {True}
            break
    return counts


def test_an_episode_ends_when_progress_has_not_risen_for_so_long(make):
    env = TrainingWrappers(no_progress_timeout_s=0.3)(make(facing(), RISING))
    assert steps_without_progress(env, [0.0] * 9) == [0, 1, 2, 3]
    assert env.episode.steps == 3


def test_a_rise_makes_the_time_begin_again_and_a_small_one_does_not(make):
    env = TrainingWrappers(no_progress_timeout_s=0.3)(make(facing(), RISING))
    assert steps_without_progress(env, [0.0, 0.2, 0.0, 0.001, 0.0, 0.0])[:6] == [0, 1, 0, 1, 2, 3]


def test_the_time_without_progress_goes_back_with_a_saved_state(make):
    env = TrainingWrappers(no_progress_timeout_s=0.5)(make(facing(), RISING))
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


def test_a_prefix_counts_towards_the_time_without_progress(make, prefix):
    wrappers = TrainingWrappers(
        no_progress_timeout_s=9.0, start_prefixes=(prefix,), start_share=1.0
    )
    env = wrappers(make(TEXT, RISING))
    _, infos = env.reset(seed=1)
    assert infos["left"]["steps_without_progress"] == env.episode.steps > 0


def test_a_stopped_episode_takes_no_further_step(make):
    env = TrainingWrappers(no_progress_timeout_s=0.1)(make(facing(), RISING))
    env.reset(seed=0)
    actions = still(env)
    env.step(actions)
    with pytest.raises(EpisodeOverError):
        env.step(actions)


def test_wrapped_environments_run_the_same_in_workers():
    wrappers = TrainingWrappers(end_on_setback=True, no_progress_timeout_s=0.3)
    found = []
    for workers in (0, 2):
        envs = make_vec("handover", 2, workers, wrap=wrappers)
        try:
            envs.reset(seed=3)
            actions = {a: np.zeros((2, n.shape[0])) for a, n in envs.single_action_space.items()}
            steps = [envs.step(actions) for _ in range(5)]
            found.append([digest(rewards, ends, cuts) for _, rewards, ends, cuts, _ in steps])
            assert "steps_without_progress" in steps[0][4]
            assert steps[2][3].all()
        finally:
            envs.close()
    assert found[0] == found[1]


class Scripted:
    """An environment whose progress and success are given for each step."""

    def __init__(self, *steps):
        self.metadata, self.info_keys = {"render_fps": 10}, ()
        self._steps = iter(steps)

    def _infos(self, progress, success):
        return {"arm": {"progress": progress, "success": float(success), "exploded": 0.0}}

    def reset(self, seed=None, options=None):
        return {}, self._infos(0.0, False)

    def step(self, actions):
        flags = {"arm": False}
        return {}, {"arm": 0.0}, flags, flags, self._infos(*next(self._steps))


def test_success_at_less_progress_than_before_does_not_make_later_progress_a_rise():
    steps = ((0.5, False), (0.2, True), (0.3, False), (0.54, False), (0.55, False))
    env = NoProgressTimeout(Scripted(*steps), 1.0)
    env.reset()
    counts = [env.step({})[4]["arm"]["steps_without_progress"] for _ in steps]
    assert counts == [0.0, 0.0, 1.0, 2.0, 0.0]
