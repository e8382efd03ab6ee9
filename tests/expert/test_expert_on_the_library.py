"""The experts of the library's tasks: they do them, repeat to the bit, and need each other."""

from __future__ import annotations

import numpy as np
import pytest
from library_experts import SCENES, SEEDS, TASKS, expert_of, played
from written_experts import Digest, same

from taskbuilder.env.parallel import parallel_env
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import replay

MARGIN_STEPS = 1


@pytest.mark.parametrize("scene", SCENES)
class TestExpert:
    def test_does_the_task_with_steps_to_spare(self, scene):
        for seed in SEEDS:
            demonstration = played(scene, seed).demonstration
            assert demonstration.trouble is None
            horizon = expert_of(scene).env.episode.horizon
            assert demonstration.steps == horizon
            assert demonstration.first_success <= horizon - MARGIN_STEPS

    def test_still_has_done_it_when_the_episode_ends(self, scene):
        expert_of(scene).play(SEEDS[0])
        assert expert_of(scene).env.episode.outcome.success

    def test_ends_a_stage_after_the_one_before(self, scene):
        stages = expert_of(scene).env.task.file.spec.expert
        for seed in SEEDS:
            ends = played(scene, seed).demonstration.stage_ends
            assert len(ends) == len(stages)
            assert list(ends) == sorted(set(ends))

    def test_is_replayed_to_the_bit_in_another_environment(self, scene):
        name, variation = scene
        other = parallel_env(name, variation=variation)
        for seed in SEEDS[:2]:
            digest = Digest()
            first = played(scene, seed)
            replay(other, first.demonstration, digest)
            assert digest.hex == first.digest
        other.close()

    def test_plays_a_seed_alike_whatever_it_played_before(self, scene):
        again = expert_of(scene).play(SEEDS[0])
        assert same(again, played(scene, SEEDS[0]).demonstration)

    @pytest.mark.parametrize("robot", ["left", "right"])
    def test_fails_when_a_robot_stays_home(self, scene, robot):
        demonstration = expert_of(scene).play(SEEDS[0], without={robot}, persist=True)
        assert not demonstration.success
        moved = np.abs(demonstration.actions[robot]).max()
        assert moved < 1e-6


@pytest.mark.parametrize("task", TASKS)
def test_in_the_robots_own_frames_it_does_the_task_and_is_replayed_to_the_bit(task):
    env, other = (parallel_env(task, frame="base", observe="scene") for _ in range(2))
    expert, digest, again = Expert(env), Digest(), Digest()
    demonstration = expert.play(SEEDS[0], watch=digest)
    assert demonstration.success
    assert demonstration.trouble is None
    replay(other, demonstration, again)
    assert again.hex == digest.hex
    worldly = played((task, 0), SEEDS[0]).demonstration
    assert not np.array_equal(demonstration.actions["right"], worldly.actions["right"])
    expert.close()
    env.close()
    other.close()


def test_it_records_what_play_records():
    env = parallel_env("handover")
    expert = Expert(env)
    rollout = expert.play(SEEDS[0], observations=True, cameras=["front"], size=(32, 24))
    expert.close()
    env.close()
    assert set(rollout.observations) == set(env.possible_agents)
    assert len(rollout.observations["left"]) == rollout.steps + 1
    assert rollout.pictures["front"].shape == (rollout.steps + 1, 24, 32, 3)
