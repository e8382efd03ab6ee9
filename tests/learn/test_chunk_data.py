"""Chunks of recorded actions: what they contain, and what of them lies within the episode."""

from __future__ import annotations

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from taskbuilder.learn.chunk_data import ChunkData  # noqa: E402  # needs PyTorch
from taskbuilder.learn.recordings import Demonstrations  # noqa: E402


@pytest.fixture
def data():
    """Episodes of three steps and of two; the arm's actions count up, the hand's down."""
    column = np.arange(5.0, dtype=np.float32)[:, None]
    own = {name: np.array([True]) for name in ("arm", "hand")}
    return ChunkData(
        Demonstrations(
            {"arm": column, "hand": column},
            {"arm": np.concatenate([column, column + 10.0], 1), "hand": -column},
            np.array([3, 3, 3, 5, 5]),
            own,
        ),
        torch.device("cpu"),
    )


def test_a_chunk_repeats_the_last_action_of_its_episode_and_says_what_is_within(data):
    actions, within = data.chunks(torch.tensor([0, 1, 2, 4]), 3)
    assert actions.tolist() == [
        [0, 10, 1, 11, 2, 12, 0, -1, -2],
        [1, 11, 2, 12, 2, 12, -1, -2, -2],
        [2, 12, 2, 12, 2, 12, -2, -2, -2],
        [4, 14, 4, 14, 4, 14, -4, -4, -4],
    ]
    inside = [[True] * 3, [True, True, False], [True, False, False], [True, False, False]]
    assert within.tolist() == [[*np.repeat(row, 2).tolist(), *row] for row in inside]
