"""When learners that replay make updates, and from which rows."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from taskbuilder.learn.off_policy import OffPolicy
from taskbuilder.learn.shapes import Layout, Shapes

LAYOUT = Layout.of(Shapes(observations={"arm": 3}, state=2, actions={"arm": 1}))


class Counting:
    """A learner that draws a batch at each update and learns nothing."""

    def __init__(self, update_every: float) -> None:
        self.settings = SimpleNamespace(
            n_step=1, discount=0.9, capacity=1000, warm_up=0, update_every=update_every
        )
        self.batches = []

    def begin(self, rows, rng):
        pass

    def update(self, practice, rng, step):
        self.batches.append(practice.sample(10, rng))
        return {}


def rows(count, value=0.0):
    return np.full((count, LAYOUT.width), value, np.float32)


def played(envs, steps, update_every, demonstrations=None, experience=True):
    """A learner after some steps of all environments together."""
    learner, rng = Counting(update_every), np.random.default_rng(0)
    practice = OffPolicy(learner, LAYOUT, envs, demonstrations)
    for step in range(0, steps, envs):
        practice.before_step(rng, step)
        if experience:
            practice.experience.add(rows(envs))
        practice.during_step(rng, step)
    return learner


@pytest.mark.parametrize("envs", [1, 2, 8])
@pytest.mark.parametrize("update_every", [1, 2, 5])
def test_updates_follow_control_steps_however_many_environments_share_them(envs, update_every):
    assert len(played(envs, 80, update_every).batches) == 80 // update_every


def test_batches_are_half_demonstrations_and_all_while_there_is_no_experience():
    shown = rows(20, 1.0)
    for batch in played(2, 8, 1, shown).batches:
        assert batch[:, 0].sum() == 5.0
    alone = played(2, 8, 1, shown, experience=False).batches
    assert len(alone) == 8
    assert all(batch[:, 0].sum() == 10.0 for batch in alone)
