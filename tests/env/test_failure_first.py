"""An episode in which failure held before success is no success, wherever that is said."""

from __future__ import annotations

import numpy as np
import pytest
from env_tasks import PLAIN, arm, towards

from taskbuilder.env.infos import make_info
from taskbuilder.errors import ExplosionError
from taskbuilder.learn.collector import Tally
from taskbuilder.rollout import play, replay

SPOT, HIGH = (0.45, 0.1, 0.4), (0.45, 0.1, 0.5)
STEPS = 10

TOO_HIGH = PLAIN.replace("Description,", "Above, Description,").replace(
    "    reward", '    failure = Above("arm.tcp", height=0.45)\n    reward'
)
AT_ONCE = TOO_HIGH.replace('Near("arm.tcp", "spot", within=0.01)', 'Above("arm.tcp", height=0.45)')


def way(env, goals):
    """Actions that bring the tool to each goal in turn, to be drawn one by one."""
    for goal in goals:
        yield towards(env, {"arm": goal}, {})


# Where the tool is sent at each control step; too high is a blow.
BLOW_FIRST = [HIGH] * 4 + [SPOT] * 6
BLOW_AFTER = [SPOT] * 5 + [HIGH] * 5
NO_BLOW = [SPOT] * STEPS


@pytest.mark.parametrize(
    ("goals", "succeeded", "failed"),
    [(BLOW_FIRST, 0.0, 1.0), (BLOW_AFTER, 1.0, 1.0), (NO_BLOW, 1.0, 0.0)],
)
def test_only_success_that_no_failure_went_before_counts(make, goals, succeeded, failed):
    env = make(arm(steps=STEPS), TOO_HIGH)
    _, infos = env.reset(seed=0)
    assert (infos["arm"]["succeeded"], infos["arm"]["failed"]) == (0.0, 0.0)
    told = []
    for action in way(env, goals):
        *_, infos = env.step(action)
        told.append(infos["arm"])
    assert any(info["success"] for info in told)
    assert (told[-1]["succeeded"], told[-1]["failed"]) == (succeeded, failed)
    assert [info["failed"] for info in told] == sorted(info["failed"] for info in told)
    env.reset(seed=0)
    assert not env.episode.failed


def test_success_and_failure_at_the_same_step_is_no_success(make):
    env = make(arm(steps=STEPS), AT_ONCE)
    env.reset(seed=0)
    for action in way(env, BLOW_FIRST):
        *_, infos = env.step(action)
        assert infos["arm"]["success"] == infos["arm"]["failure"]
    assert (infos["arm"]["succeeded"], infos["arm"]["failed"]) == (0.0, 1.0)


def test_an_episode_that_begins_in_failure_has_failed(make):
    env = make(arm(steps=STEPS), TOO_HIGH.replace("height=0.45", "height=0.1"))
    _, infos = env.reset(seed=0)
    assert infos["arm"]["failed"] == 1.0
    for action in way(env, NO_BLOW):
        *_, infos = env.step(action)
    assert infos["arm"]["success"] == 1.0
    assert infos["arm"]["succeeded"] == 0.0


def test_a_saved_state_knows_of_failure(make):
    env = make(arm(steps=STEPS), TOO_HIGH)
    env.reset(seed=0)
    before = env.save_state()
    for action in way(env, BLOW_FIRST[:6]):
        env.step(action)
    after = env.save_state()
    for state, failed in ((before, False), (after, True), (before, False)):
        env.load_state(state)
        assert env.episode.failed is failed
        for action in way(env, [SPOT] * 4):
            env.step(action)
        assert env.episode.outcome.success
        assert env.episode.succeeded is not failed


@pytest.mark.parametrize(
    ("goals", "first"), [(BLOW_FIRST, None), (BLOW_AFTER, True), (NO_BLOW, True)]
)
def test_everything_that_tells_of_an_episode_says_the_same(make, goals, first):
    env = make(arm(steps=STEPS), TOO_HIGH)
    tally = Tally(1)
    tally.begin(np.array([True]))

    def note(env):
        if env.episode.steps:
            infos = make_info(env.episode)
            tally.add({key: np.array([value]) for key, value in infos.items()}, np.zeros((1, 1)))

    actions = way(env, goals)
    told = play(env, lambda _: next(actions, None), 0, watch=note)
    assert told.success is (first is not None)
    assert told.success is env.episode.succeeded
    (finished,) = tally.finished(np.array([True]))
    assert finished.success is told.success
    assert replay(env, told).first_success == told.first_success


def test_that_failure_came_first_is_said_with_its_figure_and_its_step(make):
    env = make(arm(steps=STEPS), TOO_HIGH)
    goals = iter(BLOW_FIRST)
    played = play(env, lambda _: towards(env, {"arm": next(goals)}, {}), 0, explain=True)
    (failed,) = [str(reason) for reason in played.why if reason.of == "failure"]
    assert failed.startswith(f"failure held at step {played.failed_at}: Above(arm.tcp): ")
    assert failed.endswith(" cm high, less than 45 cm is needed")
    assert (played.success, played.failed_at > 0) == (False, True)


def test_that_the_physics_diverged_is_said(make, monkeypatch):
    env = make(arm(steps=STEPS), TOO_HIGH)

    def explode(_):
        if env.episode.steps == 4:
            raise ExplosionError("it diverged")

    monkeypatch.setattr(type(env.episode.world), "_check", explode)
    played = play(env, lambda _: towards(env, {"arm": SPOT}, {}), 0, forces=True, explain=True)
    assert [str(reason) for reason in played.why] == ["the physics diverged at step 4"]
    assert played.robot_force.shape == (5,)
