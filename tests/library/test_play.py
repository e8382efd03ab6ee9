"""Every task of the library, played once by its expert: what comes of it, and what goes with it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from taskbuilder import TaskEnv, catalogue, load_task, parallel_env
from taskbuilder.expert import Expert, StageLadder
from taskbuilder.rollout import Rollout, play
from taskbuilder.rollout.players import HoldStill
from taskbuilder.validate.traces import digest, physical

pytestmark = pytest.mark.in_process

TASKS = sorted(name for name, entry in catalogue().tasks.items() if entry.trusted)
SEED = 20_000
SAVED_EVERY = 9

LARGEST_FALL = 0.02
"""By how much the ladder may be below its highest value before the expert's success."""

FROZEN = 0.1
"""What robots that hold still reach at most."""


@dataclass(frozen=True)
class Played:
    """An episode of a task's expert.

    Attributes:
        env: The environment, as it is after the episode.
        ladder: The ladder that is made from the expert's stages.
        episode: The episode.
        digests: Of the whole state, after the reset and after each control step.
        saved: Control step -> the state then.
        heights: Of the ladder, after the reset and after each control step.
        stages: The stage that the ladder was at then.
    """

    env: TaskEnv
    ladder: StageLadder
    episode: Rollout
    digests: list[str]
    saved: Mapping[int, Any]
    heights: list[float]
    stages: list[int]


def everything(env: TaskEnv) -> str:
    return digest((physical(env.episode.world), env.state(), env.episode.outcome))


def climb(env: TaskEnv, ladder: StageLadder) -> float:
    return ladder.advance() if env.episode.steps else ladder.begin()


@pytest.fixture(scope="module", params=TASKS)
def played(request: pytest.FixtureRequest) -> Iterator[Played]:
    digests, saved, heights, stages = [], {}, [], []

    def watch(env: TaskEnv) -> None:
        digests.append(everything(env))
        heights.append(climb(env, ladder))
        stages.append(ladder.position.stage)
        if not len(digests) % SAVED_EVERY:
            saved[env.episode.steps] = env.save_state()

    with closing(parallel_env(request.param)) as env, closing(Expert(env)) as expert:
        ladder = StageLadder(env)
        episode = expert.play(SEED, watch=watch)
        yield Played(env, ladder, episode, digests, saved, heights, stages)


def test_the_expert_succeeds_and_success_lasts(played):
    episode = played.episode
    assert episode.success, episode.trouble
    assert episode.success_at_end
    assert len(episode.stage_ends) == len(load_task(episode.task).file.spec.expert)


def test_saved_states_can_be_gone_back_to(played):
    """benchmarks/restoring.py goes back to every step."""
    episode = played.episode
    for first, state in reversed(played.saved.items()):
        played.env.load_state(state)
        for step in range(first, min(first + 2, episode.steps)):
            played.env.step({agent: values[step] for agent, values in episode.actions.items()})
            assert everything(played.env) == played.digests[step + 1], (first, step)


def test_the_ladder_climbs_as_the_expert_works(played):
    episode, climbed = played.episode, np.array(played.heights)
    assert climbed.min() >= 0.0
    until = climbed[: episode.first_success + 1]
    assert (np.maximum.accumulate(until) - until).max() <= LARGEST_FALL
    succeeded = np.flatnonzero(episode.conditions["success"])
    assert np.flatnonzero(climbed == 1.0).tolist() == succeeded.tolist()
    for number, end in enumerate(episode.stage_ends[:-1], start=1):
        assert played.stages[end] >= number, f"stage {number} is not done for the ladder"


def test_the_ladder_stays_low_if_nobody_moves(played):
    heights = []
    play(played.env, HoldStill(), SEED, watch=lambda env: heights.append(climb(env, played.ladder)))
    assert max(heights) <= FROZEN
