"""Coordination: what robots do at the same time in an episode."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from taskbuilder import parallel_env, play
from taskbuilder.expert import Expert
from taskbuilder.rollout import HoldStill
from taskbuilder.rollout.coordination import CoordinationMeter


def measured(task, policy):
    meter = CoordinationMeter()
    with closing(parallel_env(task)) as env:
        play(env, policy, seed=0, watch=meter)
    return meter.coordination()


def test_robots_that_hold_still_neither_move_nor_wait():
    found = measured("handover", HoldStill())
    assert (found.moving, found.touching) == (0.0, 0.0)
    assert found.waiting == {"left": 0.0, "right": 0.0}
    assert max(found.path.values()) < 0.01


def test_a_robot_that_holds_still_waits_for_the_one_that_moves():
    up = {"left": np.array([0, 0, 0.5, 0, 1], np.float32), "right": np.zeros(5, np.float32)}
    found = measured("handover", lambda _: up)
    assert found.moving == 0.0
    assert found.waiting["right"] > 0.1
    assert found.waiting["left"] == 0.0
    assert found.balance < 0.1


def test_two_robots_that_lift_a_tray_move_and_touch_it_together():
    meter = CoordinationMeter()
    with closing(parallel_env("collaborative_lift")) as env, closing(Expert(env)) as expert:
        rollout = expert.play(0, watch=meter)
    lifting = meter.coordination(rollout.first_success)
    assert lifting.moving > 0.5
    assert lifting.touching > 0.5
    assert lifting.balance > 0.8
    whole = meter.coordination()
    assert whole.moving < lifting.moving  # after success both hold still


def test_without_a_step_there_is_nothing_to_measure():
    with pytest.raises(ValueError, match="as watch"):
        CoordinationMeter().coordination()
