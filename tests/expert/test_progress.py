"""The progress that the library's tasks declare: it climbs as an expert works, and for no other."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from library_experts import SCENES, SEEDS, TASKS, played

from taskbuilder.description import Ladder
from taskbuilder.description.bounds import bounds_of
from taskbuilder.description.measures import Measure
from taskbuilder.description.node import walk
from taskbuilder.env.parallel import parallel_env
from taskbuilder.rollout import RandomActions, play
from taskbuilder.task import load_task

LARGEST_RISE = 0.35
"""Fraction of the whole climb that one control step may bring at most."""

CLIMBING = [task for task in TASKS if load_task(task).description.progress is not None]
SEEN = [(scene, seed) for scene in SCENES if scene[0] in CLIMBING for seed in SEEDS[:2]]


def wandered(task, seed):
    """The progress of an episode of random actions, and whether anything was held at each step."""
    env = parallel_env(task)
    progress, holding = [], []

    def watch(env):
        progress.append(env.episode.outcome.progress)
        holding.append(any(env.episode.holding(robot) for robot in env.possible_agents))

    play(env, RandomActions(), seed, watch=watch)
    env.close()
    return progress, holding


def test_every_task_of_the_library_declares_progress():
    assert list(TASKS) == CLIMBING


def steps(ladder: Ladder) -> list[Measure]:
    """The ground and the rungs of a ladder."""
    return [ladder.ground, *(value for _, value in ladder.rungs)]


@pytest.mark.parametrize("task", CLIMBING)
def test_every_rung_begins_where_the_one_before_ends_or_above(task):
    spans = list(map(bounds_of, steps(load_task(task).description.progress)))
    for (_, highest), (lowest, _) in itertools.pairwise(spans):
        assert lowest >= highest


@pytest.mark.parametrize("task", CLIMBING)
def test_nobody_is_paid_for_progress(task):
    description = load_task(task).description
    assert description.progress not in set(walk(description.reward))


@pytest.mark.parametrize(("scene", "seed"), SEEN)
class TestExpert:
    def test_ends_higher_than_it_began(self, scene, seed):
        outcomes = played(scene, seed).outcomes
        assert outcomes[-1].progress > outcomes[0].progress

    def test_is_at_its_highest_where_success_holds_and_only_there(self, scene, seed):
        outcomes = played(scene, seed).outcomes
        won = {outcome.progress for outcome in outcomes if outcome.success}
        before = max(outcome.progress for outcome in outcomes if not outcome.success)
        assert len(won) == 1
        assert won.pop() > before + 0.5

    def test_climbs_by_no_leap(self, scene, seed):
        progress = [outcome.progress for outcome in played(scene, seed).outcomes]
        best = list(itertools.accumulate(progress, max))
        rises = np.diff(best)
        assert rises.max() <= LARGEST_RISE * (best[-1] - best[0])
        assert np.count_nonzero(rises > 1e-3) > 12

    def test_stands_higher_with_any_grasp_than_before_the_first(self, scene, seed):
        episode = played(scene, seed)
        progress = [outcome.progress for outcome in episode.outcomes]
        first = episode.holding.index(True)
        held = [now for now, holds in zip(progress, episode.holding, strict=True) if holds]
        assert max(progress[:first]) < min(held) - 0.3

    def test_is_never_thrown_back(self, scene, seed):
        outcomes = played(scene, seed).outcomes
        assert not any(outcome.conditions["setback"] for outcome in outcomes)


@pytest.mark.parametrize("task", CLIMBING)
def test_chance_makes_little_progress_and_all_of_it_is_a_number(task):
    for seed in range(3):
        progress, holding = wandered(task, seed)
        assert all(map(math.isfinite, progress))
        assert min(progress) >= 0.0
        if not any(holding):
            assert max(progress) < 1.0
