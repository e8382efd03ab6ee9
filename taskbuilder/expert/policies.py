"""Who can play an episode: the expert, two that set it off, and any function of what is seen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UnknownNameError
from taskbuilder.expert.demonstration import Demonstration, Watch
from taskbuilder.expert.driving import Actions, Driver
from taskbuilder.expert.player import Expert
from taskbuilder.expert.recording import Recording
from taskbuilder.wording import suggestion

Act = Callable[[Mapping[str, Any]], Mapping[str, NDArray[np.floating]]]
"""Every agent's action, given what each sees."""


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

        return _play(self.env, seed, lambda _: draw(), watch)

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
        driver = Driver(self.env)
        return _play(self.env, seed, lambda _: driver.hold(), watch)

    def close(self) -> None:
        """Nothing is kept."""


class Acting:
    """Does what a function of the observations says, such as a trained policy.

    Args:
        env: Any environment of a task, its actions flat and its variation fixed.
        act: Every agent's action, as the environment takes it, given what each sees. What it
            remembers from step to step is its own affair.
    """

    def __init__(self, env: TaskEnv, act: Act) -> None:
        self.env = env
        self._act = act

    def play(self, seed: int, *, watch: Watch = lambda _: None) -> Demonstration:
        """Play one episode; see `Expert.play`."""

        def act(seen: Mapping[str, Any]) -> Actions:
            # What is kept is what was done, to the bit.
            return {a: np.asarray(n, dtype=np.float32) for a, n in self._act(seen).items()}

        return _play(self.env, seed, act, watch)

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


def _play(
    env: TaskEnv, seed: int, act: Callable[[Mapping[str, Any]], Actions], watch: Watch
) -> Demonstration:
    recording = Recording(env, seed, watch)
    while not recording.over:
        recording.step(act(recording.seen))
    return recording.demonstration()
