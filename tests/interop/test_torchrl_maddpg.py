"""TorchRL's MADDPG, none of whose code is ours, finds something to learn in the handover."""

from __future__ import annotations

import math
from statistics import mean

import torchrl_maddpg


def test_maddpg_of_torchrl_learns_for_a_while():
    course = torchrl_maddpg.main(episodes=30, updates=20)
    assert len(course.returns) == 30
    assert len(course.losses) == 600
    assert all(map(math.isfinite, course.losses))
    # Untrained arms drift away from the stick; what pays first is to come near.
    assert mean(course.returns[-10:]) > mean(course.returns[:3]) + 5.0
