"""Ways of playing a task that take no plan, and what playing it comes to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.demonstration import Demonstration
from taskbuilder.expert.driving import Actions, Driver
from taskbuilder.validate.studio import Start, Studio

DISCOUNT = 0.95
LARGEST = 1e6
"""What a reward term may pay at most in a control step, in size: single precision, in which
learners count, still tells it from a tenth more or less."""

SWING_STEPS = 6
"""Control steps of a throw; the gripper opens half-way."""


@dataclass(frozen=True)
class Play:
    """What an episode came to, however it was played.

    Attributes:
        earned: The team's undiscounted return.
        discounted: The same at `DISCOUNT`.
        steps: Control steps that it lasted.
        success: Success held at some control step.
        wild: What reward terms paid that was not finite or beyond `LARGEST`, by label.
    """

    earned: float
    discounted: float
    steps: int
    success: bool
    wild: Mapping[str, float]


class Account:
    """Counts what is earned in an episode that has begun.

    Args:
        env: The environment.
        rewards: What the team was paid at the control steps so far.
    """

    def __init__(self, env: TaskEnv, rewards: Sequence[float] = ()) -> None:
        self.env = env
        self._rewards = list(rewards)
        self._wild: dict[str, float] = {}

    def step(self, actions: Mapping[str, NDArray[np.float32]]) -> None:
        """Take a control step."""
        self.env.step(actions)
        self._rewards.append(self.env.team_reward())
        self._wild |= {k: v for k, v in self.env.episode.outcome.terms.items() if is_wild(v)}

    def hold(self) -> None:
        """Hold still until the episode is over."""
        driver = Driver(self.env)
        while self.env.agents:
            self.step(driver.hold())

    def closed(self) -> Play:
        """What it has come to."""
        success = self.env.episode.succeeded
        return made(np.array(self._rewards, dtype=np.float64), success=success, wild=self._wild)


def is_wild(pay: float) -> bool:
    """Whether a reward term's pay is not finite, or huge."""
    return not abs(pay) <= LARGEST  # which is so for what is not a number, too


def made(rewards: NDArray[np.float64], *, success: bool, wild: Mapping[str, float]) -> Play:
    """The play of an episode with such rewards."""
    weights = DISCOUNT ** np.arange(len(rewards))
    steps = len(rewards)
    return Play(float(rewards.sum()), float(rewards @ weights), steps, success, dict(wild))


def of_demonstration(demonstration: Demonstration) -> Play:
    """What a demonstration came to."""
    wild = {
        label: float(pay)
        for label, pays in demonstration.terms.items()
        for pay in pays
        if is_wild(float(pay))
    }
    return made(demonstration.rewards, success=demonstration.success, wild=wild)


def play_expert(studio: Studio, start: Start) -> Demonstration:
    """The expert's own way, up to the end of the episode.

    From starts that only show whether it succeeds, no farther than to the end of its stages if
    that is known by then.
    """
    expert = studio.expert(start.variation)
    if start.seed % len(studio.task.file.scenes) != start.variation:
        played = expert.play(start.seed, finish=False)
        if played.success or played.trouble:
            return played
    return expert.play(start.seed)


def play_nothing(env: TaskEnv, seed: int) -> Play:
    """Everyone holds still from the start."""
    env.reset(seed=seed)
    account = Account(env)
    account.hold()
    return account.closed()


def play_random(env: TaskEnv, seed: int) -> Play:
    """Everyone acts at random, as the seed decides."""
    env.reset(seed=seed)
    account = Account(env)
    for actions in random_actions(env, seed):
        account.step(actions)
        if not env.agents:
            break
    return account.closed()


def random_actions(env: TaskEnv, seed: int) -> Iterator[Actions]:
    """An episode's actions, drawn evenly from the action spaces."""
    rng = np.random.default_rng([seed, 2])
    sizes = {agent: modes.size for agent, modes in env.episode.actions.items()}
    for _ in range(env.episode.horizon):
        yield {agent: rng.uniform(-1.0, 1.0, n).astype(np.float32) for agent, n in sizes.items()}


def drop(account: Account) -> None:
    """All grippers open, and nobody moves any more."""
    env = account.env
    if env.agents:
        account.step(Driver(env).actions(openings=dict.fromkeys(env.possible_agents, 1.0)))
    account.hold()


def throw(account: Account) -> None:
    """All arms swing sideways at full speed and open their grippers half-way; then they hold."""
    env = account.env
    driver = Driver(env)
    for step in range(SWING_STEPS):
        if not env.agents:
            break
        opening = 1.0 if step >= SWING_STEPS // 2 else None
        joints = {agent: _swung(env, agent) for agent in env.possible_agents}
        openings = {} if opening is None else dict.fromkeys(env.possible_agents, opening)
        account.step(driver.actions(joints, openings))
    account.hold()


def _swung(env: TaskEnv, agent: str) -> list[float]:
    """An arm's commanded joints with the first one as far on as a control step takes it."""
    arm = env.episode.actions[agent].arm
    first, *rest = arm.commanded()
    return [min(first + arm.longest[0], arm.stepper.upper[0]), *rest]
