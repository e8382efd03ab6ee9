"""Rewards, observations and digests are the same in all versions of Python.

The built-in ``sum`` of floats rounds otherwise from Python 3.12 on.
"""

from __future__ import annotations

import builtins
import sys
from contextlib import closing

import pytest

from taskbuilder.env.parallel import parallel_env
from taskbuilder.expert import Expert
from taskbuilder.rollout import play
from taskbuilder.rollout.coordination import CoordinationMeter

SUM = builtins.sum


@pytest.fixture
def float_sums(monkeypatch):
    """The places in the library where the built-in sum has added floats."""
    places = set()

    def watched(items, /, start=0):
        items = [*items]
        if any(isinstance(item, float) for item in items):
            frame = sys._getframe(1)
            if "taskbuilder" in frame.f_code.co_filename:
                places.add(f"{frame.f_code.co_filename}:{frame.f_lineno}")
        return SUM(items, start)

    monkeypatch.setattr(builtins, "sum", watched)
    return places


@pytest.mark.parametrize("task", ["handover", "suction_sort"])
def test_no_sum_of_floats_is_left_to_python(task, float_sums):
    with closing(parallel_env(task)) as env, closing(Expert(env)) as expert:
        meter, felt = CoordinationMeter(), []

        def watch(env):
            meter(env)
            felt.append([env.episode.forces(robot) for robot in env.episode.world.robots])

        rollout = play(env, expert, 0, observations=True, forces=True, watch=watch)
        meter.coordination(rollout.steps)
    assert rollout.success
    assert max(max(force) for forces in felt for force in forces) > 1.0
    assert not float_sums
