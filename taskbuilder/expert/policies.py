"""Who can play an episode: the expert, and two that set it off."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UnknownNameError
from taskbuilder.expert.demonstration import Demonstration, Watch
from taskbuilder.expert.driving import Actions, Driver
from taskbuilder.expert.player import Expert
from taskbuilder.expert.recording import Recording
from taskbuilder.spec.explain import suggestion


class Player(Protocol):
    """Plays episodes of an environment; deterministic in the seed."""

    def play(self, seed: int, *, watch: Watch = ...) -> Demonstration:
        """Play one episode; see `Expert.play`."""

    def close(self) -> None:
        """Free what it keeps besides the environment."""


class Random:
    """Draws every number of every action evenly within its bounds.

    Args:
        env: Any environment of a task, its actions flat and its variation fixed.
    """

    def __init__(self, env: TaskEnv) -> None:
        self.env = env

    def play(self, seed: int, *, watch: Watch = lambda _: None) -> Demonstration:
        """Play one episode; see `Expert.play`."""
        rng = np.random.default_rng(seed)

        def draw() -> Actions:
            drawn = {}
            for agent, modes in self.env.episode.actions.items():
                numbers = rng.uniform(-1.0, 1.0, modes.size).tolist()
                if not self.env.options.normalize:
                    numbers = modes.physical(numbers)
                drawn[agent] = np.array(numbers, dtype=np.float32)
            return drawn

        return _play(self.env, seed, draw, watch)

    def close(self) -> None:
        """Nothing is kept."""


class Nothing:
    """Holds still.

    Args:
        env: Any environment of a task, its actions flat and its variation fixed.
    """

    def __init__(self, env: TaskEnv) -> None:
        self.env = env

    def play(self, seed: int, *, watch: Watch = lambda _: None) -> Demonstration:
        """Play one episode; see `Expert.play`."""
        return _play(self.env, seed, Driver(self.env).hold, watch)

    def close(self) -> None:
        """Nothing is kept."""


PLAYERS: Mapping[str, Callable[[TaskEnv], Player]] = {
    "expert": Expert,
    "random": Random,
    "nothing": Nothing,
}
"""Who can be asked to play, by name."""


def player_named(name: str) -> Callable[[TaskEnv], Player]:
    """What makes a player for an environment.

    Raises:
        UnknownNameError: There is none of that name.
    """
    if name not in PLAYERS:
        raise UnknownNameError(f'no policy "{name}"; {suggestion(name, PLAYERS, what="one of")}')
    return PLAYERS[name]


def _play(env: TaskEnv, seed: int, act: Callable[[], Actions], watch: Watch) -> Demonstration:
    recording = Recording(env, seed, watch)
    while not recording.over:
        recording.step(act())
    return recording.demonstration()
