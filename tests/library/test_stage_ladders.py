"""The ladder that is made from the expert's stages, along the expert's own episodes."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from taskbuilder import catalogue, load_task, parallel_env
from taskbuilder.expert import Expert, StageLadder
from taskbuilder.rollout import play
from taskbuilder.rollout.players import HoldStill

pytestmark = pytest.mark.in_process

TASKS = sorted(
    name
    for name, entry in catalogue().tasks.items()
    if entry.trusted and load_task(name).file.spec.expert
)
SEED = 20_000

LARGEST_FALL = 0.02
"""By how much the ladder may be below its highest value before the expert's success."""

FROZEN = 0.1
"""What robots that hold still reach at most."""


@pytest.mark.parametrize("name", TASKS)
def test_it_climbs_as_the_expert_works_and_stays_low_if_nobody_moves(name):
    values, stages = [], []

    def climb(env):
        values.append(ladder.advance() if env.episode.steps else ladder.begin())
        stages.append(ladder.position.stage)

    with closing(parallel_env(name)) as env, closing(Expert(env)) as expert:
        ladder = StageLadder(env)
        played = expert.play(SEED, watch=climb)
        climbed, reached = np.array(values), list(stages)
        values.clear()
        play(env, HoldStill(), SEED, watch=climb)
    assert played.success_at_end
    assert climbed.min() >= 0.0
    until = climbed[: played.first_success + 1]
    assert (np.maximum.accumulate(until) - until).max() <= LARGEST_FALL
    assert (
        np.flatnonzero(climbed == 1.0).tolist()
        == np.flatnonzero(played.conditions["success"]).tolist()
    )
    for number, end in enumerate(played.stage_ends[:-1], start=1):
        assert reached[end] >= number, f"stage {number} is not done for the ladder"
    assert max(values) <= FROZEN
