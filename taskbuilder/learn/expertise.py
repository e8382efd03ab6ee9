"""Expert episodes of a run: recorded once, kept in its folder, and turned into transitions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.options import Opening
from taskbuilder.env.vector import TaskVectorEnv
from taskbuilder.learn.collection import Collector
from taskbuilder.learn.shapes import Shapes
from taskbuilder.learn.signals import Signal
from taskbuilder.learn.store import read_arrays, write_arrays

EXPERT_FILE = "expert.npz"
SEEDS_FROM = 500_000
"""Seeds of expert episodes begin here, apart from those of evaluations."""

_KIND = "expert episodes"


@dataclass(frozen=True)
class Recorded:
    """An expert's episode, failed or not.

    Attributes:
        seed: Of its reset.
        actions: (steps, n) by agent, as the environments of the run take them.
        first_success: The control step at which success first held, or -1.
    """

    seed: int
    actions: dict[str, NDArray[np.float32]]
    first_success: int

    @property
    def opening(self) -> Opening:
        """The part of it before success, for other episodes to begin in."""
        end = self.first_success - 1 if self.first_success > 1 else None
        return Opening(self.seed, {agent: told[:end] for agent, told in self.actions.items()})


def save_episodes(folder: Path, episodes: Sequence[Recorded]) -> None:
    """Write expert episodes into a run's folder.

    Raises:
        OSError: They cannot be written.
    """
    arrays = {
        f"{number}/{agent}": told
        for number, episode in enumerate(episodes)
        for agent, told in episode.actions.items()
    }
    about: dict[str, Any] = {
        "kind": _KIND,
        "episodes": [[episode.seed, episode.first_success] for episode in episodes],
    }
    write_arrays(folder / EXPERT_FILE, arrays, about)


def load_episodes(folder: Path) -> tuple[Recorded, ...]:
    """Read the expert episodes of a run; none where it has no such file.

    Raises:
        StoreError: The file is damaged.
    """
    if not (folder / EXPERT_FILE).exists():
        return ()
    arrays, about = read_arrays(folder / EXPERT_FILE, _KIND)
    told: list[dict[str, NDArray[np.float32]]] = [{} for _ in about["episodes"]]
    for name, array in arrays.items():
        number, _, agent = name.partition("/")
        told[int(number)][agent] = array
    pairs = zip(about["episodes"], told, strict=True)
    return tuple(Recorded(seed, actions, first) for (seed, first), actions in pairs)


def transitions(
    episodes: Sequence[Recorded], env: TaskVectorEnv, signal: Signal, shapes: Shapes
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
