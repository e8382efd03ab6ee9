"""The record of a played episode: what it says, its parts, and its file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_rollouts import made_rollout

from taskbuilder.arrays import StoreError
from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import UsageError
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import (
    HoldStill,
    RandomActions,
    load_rollouts,
    play,
    replay,
    replaying,
    resume,
    save_rollouts,
)


@pytest.fixture(scope="module")
def env():
    made = parallel_env("handover", horizon=12, variation=1, reward="local")
    yield made
    made.close()


@pytest.fixture(scope="module")
def rollout(env):
    return play(env, RandomActions(), 5, observations=True, cameras=["front"], size=(16, 12))


def test_it_holds_what_the_environment_returned(env, rollout):
    steps = list(replaying(env, rollout))
    assert len(steps) == rollout.steps + 1 == 13
    for number, step in enumerate(steps):
        for agent, seen in step.observations.items():
            assert np.array_equal(rollout.observations[agent][number], seen)
        info = step.infos["left"]
        assert rollout.stage[number] == info["stage"]
        assert rollout.progress[number] == info["progress"]
        assert rollout.succeeded[number] == info["succeeded"]
        told = {name: info[f"condition/{name}"] for name in rollout.conditions}
        assert told == {name: float(held[number]) for name, held in rollout.conditions.items()}
    for number, step in enumerate(steps[1:]):
        assert {a: v[number] for a, v in rollout.agent_rewards.items()} == step.rewards
        assert rollout.rewards[number] == step.infos["left"]["team_reward"]
        for label, values in rollout.terms.items():
            assert values[number] == step.infos["left"][f"reward/{label}"]
    assert rollout.team_return == pytest.approx(sum(rollout.term_returns.values()))
    assert rollout.discounted(1.0) == pytest.approx(rollout.team_return)
    assert rollout.pictures["front"].shape == (13, 12, 16, 3)
    assert (rollout.variation, rollout.horizon, rollout.control_hz) == (1, 12, 10)


def test_what_is_not_asked_for_is_not_kept(env):
    plain = play(env, HoldStill(), 5)
    assert not plain.observations
    assert not plain.pictures


def test_recording_more_changes_nothing(env, rollout):
    plain = play(env, RandomActions(), 5)
    assert plain.equals(replace(rollout, observations={}, pictures={}))
    assert not plain.equals(play(env, RandomActions(), 6))


def test_an_episode_is_resumed_where_its_record_ends(env, rollout):
    whole = replay(env, rollout)
    begun = replay(env, rollout.until(7))
    assert begun.steps == 7
    rest = {agent: actions[7:] for agent, actions in rollout.actions.items()}

    class Rest:
        step = 0

        def reset(self, env, seed):
            self.step = 0

        def act(self, observations):
            self.step += 1
            return {agent: actions[self.step - 1] for agent, actions in rest.items()}

    assert resume(env, Rest(), begun).equals(whole)


def test_a_policy_ends_the_record_by_giving_no_action(env):
    assert play(env, lambda _: None, 3).steps == 0


def test_success_counts_from_where_it_is_reached_and_never_after_failure():
    kept = made_rollout([0, 1, 2, 3, 3, 3], success=[2, 3, 5])
    assert (kept.success, kept.first_success, kept.success_at_end) == (True, 2, True)
    assert kept.success_held_s == pytest.approx(0.3)
    lost = made_rollout([0, 1, 2, 3], success=[1, 2])
    assert (lost.success, lost.success_at_end) == (True, False)
    failed = made_rollout([0, 1, 2, 3], success=[2, 3], failure=[1])
    assert (failed.success, failed.first_success, failed.success_at_end) == (False, None, False)
    assert failed.success_held_s == 0.0


def test_stages_are_reached_when_they_are_first_passed():
    rollout = made_rollout([0, 0, 2, 2])
    assert rollout.reached == {"one": 2, "two": 2}
    assert rollout.furthest_stage == "two"
    assert made_rollout([0, 0]).furthest_stage == ""


def test_a_file_gives_rollouts_back_to_the_bit(env, rollout, tmp_path):
    whole = parallel_env("handover")
    expert = Expert(whole)
    failed = expert.play(3, without={"left"})
    expert.close()
    whole.close()
    assert failed.trouble is not None
    save_rollouts(tmp_path / "some.npz", [rollout, failed])
    first, second = load_rollouts(tmp_path / "some.npz")
    assert first.equals(rollout)
    assert second.equals(failed)
    assert second.log == failed.log
    assert replay(env, first).equals(replace(rollout, observations={}, pictures={}))


def test_a_file_of_another_kind_or_a_damaged_one_is_refused(rollout, tmp_path):
    file = tmp_path / "some.npz"
    save_rollouts(file, [rollout])
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(bytes(content))
    with pytest.raises(StoreError, match=r"some\.npz"):
        load_rollouts(file)


def test_a_rollout_of_another_task_is_not_replayed(rollout):
    other = parallel_env("pick_push_place")
    with pytest.raises(UsageError, match="a rollout of handover cannot be replayed in pick_push"):
        replay(other, rollout)
    with pytest.raises(UsageError, match="a rollout of handover"):
        next(replaying(other, rollout))
    other.close()


def test_dictionary_actions_are_refused(tmp_path):
    env = parallel_env("handover", flat=False)
    with pytest.raises(UsageError, match="make the environment with flat=True"):
        play(env, HoldStill(), 0)
    env.close()


def test_the_force_between_robots_is_metered_where_it_is_asked_for(env, rollout):
    assert rollout.peak_robot_force is None
    metered = play(env, RandomActions(), 5, forces=True)
    assert metered.robot_force.shape == (13,)
    assert metered.peak_robot_force == metered.robot_force.max()
    bare = replace(metered, robot_force=np.zeros(0))
    assert bare.equals(replace(rollout, observations={}, pictures={}))
    assert replay(env, metered).equals(metered)
    begun = replay(env, metered.until(4))
    assert resume(env, HoldStill(), begun).robot_force.shape == (13,)


def test_an_episode_without_success_says_why(env, tmp_path):
    said = play(env, HoldStill(), 5, explain=True)
    told = [str(reason) for reason in said.why]
    assert told[0] == "Held(stick, by=right): right does not hold it (from the start)"
    assert told[1].startswith("Near(stick, goal): ")
    assert told[1].endswith(" cm, within 5 cm is needed (from the start)")
    assert replay(env, said).equals(said)
    assert said.until(5).why == ()
    save_rollouts(tmp_path / "said.npz", [said])
    (back,) = load_rollouts(tmp_path / "said.npz")
    assert back.equals(said)
    assert play(env, HoldStill(), 5).why == ()
