"""Expert episodes of a run: recorded once, kept in its folder, and turned into transitions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.vector import TaskVectorEnv
from taskbuilder.learn.collection import Collector
from taskbuilder.learn.shapes import Shapes
from taskbuilder.learn.signals import Signal
from taskbuilder.rollout.files import load_rollouts
from taskbuilder.rollout.record import Rollout

EXPERT_FILE = "expert.npz"
SEEDS_FROM = 500_000
"""Seeds of expert episodes begin here, apart from those of evaluations."""


def load_episodes(folder: Path) -> tuple[Rollout, ...]:
    """Read the expert episodes of a run; none where it has no such file.

    Raises:
        StoreError: The file is damaged.
    """
    file = folder / EXPERT_FILE
    return load_rollouts(file) if file.exists() else ()


def transitions(
    episodes: Sequence[Rollout], env: TaskVectorEnv, signal: Signal, shapes: Shapes
) -> NDArray[np.float32]:
    """What happened in expert episodes, played again: (steps, width) rows, marked as shown.

    Args:
        episodes: What the experts did.
        env: One environment, with the options of the run.
        signal: What is paid, for one environment.
        shapes: What agents and critics see.
    """
    collector = Collector(env, signal, shapes)
    parts = []
    for episode in episodes:
        collector.begin(episode.seed)
        steps = min(len(told) for told in episode.actions.values())
        for step in range(steps):
            told = {agent: values[step : step + 1] for agent, values in episode.actions.items()}
            collector.step_async(told)
            rows, finished = collector.step_wait()
            parts.append(rows)
            if finished:  # what the expert did afterwards would be of another episode
                break
    rows = np.concatenate(parts)
    rows[:, shapes.layout.demonstrated] = 1.0
    return rows
