"""The experts of the library's tasks: they do them, repeat to the bit, and need each other."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from written_experts import Digest, same

from taskbuilder.env.parallel import parallel_env
from taskbuilder.expert.demonstration import replay
from taskbuilder.expert.player import Expert
from taskbuilder.spec.catalogue import Catalogue
from taskbuilder.task import load_task

TASKS = tuple(Catalogue.discover().tasks)
SCENES = [(name, k) for name in TASKS for k in range(len(load_task(name).file.scenes))]
SEEDS = range(20_000, 20_004)
MARGIN_STEPS = 5


@cache
def expert_of(scene):
    """An expert for a scene of a task."""
    name, variation = scene
    return Expert(parallel_env(name, variation=variation))


@cache
def played(scene, seed):
    """What the expert did from a seed, and the hash of all that happened."""
    digest = Digest()
    return expert_of(scene).play(seed, watch=digest), digest.hex


@pytest.mark.parametrize("scene", SCENES)
class TestExpert:
    def test_does_the_task_with_steps_to_spare(self, scene):
        for seed in SEEDS:
            demonstration, _ = played(scene, seed)
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
            ends = played(scene, seed)[0].stage_ends
            assert len(ends) == len(stages)
            assert list(ends) == sorted(set(ends))

    def test_is_replayed_to_the_bit_in_another_environment(self, scene):
        name, variation = scene
        other = parallel_env(name, variation=variation)
        for seed in SEEDS[:2]:
            digest = Digest()
            demonstration, first = played(scene, seed)
            replay(other, demonstration, digest)
            assert digest.hex == first
        other.close()

    def test_plays_a_seed_alike_whatever_it_played_before(self, scene):
        again = expert_of(scene).play(SEEDS[0])
        assert same(again, played(scene, SEEDS[0])[0])

    @pytest.mark.parametrize("robot", ["left", "right"])
    def test_fails_when_a_robot_stays_home(self, scene, robot):
        demonstration = expert_of(scene).play(SEEDS[0], without={robot}, persist=True)
        assert not demonstration.success
        moved = np.abs(demonstration.actions[robot]).max()
        assert moved < 1e-6
