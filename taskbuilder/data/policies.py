"""Who plays the episodes of a data set: the expert, the expert with noise, chance, or others."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.expert.named import POLICIES, policy_named
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout.play import Policy
from taskbuilder.rollout.record import ScriptLog

MakeOther = Callable[[str, TaskEnv], Policy]
"""Makes a policy of another kind, such as a trained one, by its name."""

_NOISY = "noisy:"
_LARGEST = 2.0


@dataclass(frozen=True)
class PolicyShare:
    """A policy of a mixture.

    Attributes:
        name: Its name: ``expert``, ``noisy:0.3``, ``random``, ``nothing``, or another.
        weight: Its attempts in every round of the mixture.
    """

    name: str
    weight: int = 1

    def __str__(self) -> str:
        return self.name if self.weight == 1 else f"{self.name}*{self.weight}"


def read_share(text: str) -> PolicyShare:
    """Read a policy and its weight: ``expert*3``.

    Raises:
        UsageError: The weight is no whole number of at least 1, or the noise no number.
    """
    name, star, weight = text.rpartition("*")
    if not star:
        name, weight = text, "1"
    if not weight.isdecimal() or not 1 <= int(weight) <= 1000:
        raise UsageError(f'"{text}": the weight after * is a whole number from 1 to 1000')
    if name.startswith(_NOISY):
        noise_of(name)
    return PolicyShare(name, int(weight))


def noise_of(name: str) -> float | None:
    """The standard deviation of ``noisy:0.3``; None of another policy.

    Raises:
        UsageError: It is not a number from 0 to 2.
    """
    if not name.startswith(_NOISY):
        return None
    try:
        spread = float(name.removeprefix(_NOISY))
    except ValueError:
        spread = math.nan
    if not 0.0 <= spread <= _LARGEST:
        raise UsageError(f'"{name}": the noise is a number from 0 to {_LARGEST:g}')
    return spread


def needs_expert(name: str) -> bool:
    """Whether a policy plays the expert of the task file."""
    return name == "expert" or noise_of(name) is not None


def is_named(name: str) -> bool:
    """Whether a policy is one of those that are made here, not a trained one."""
    return name in POLICIES or noise_of(name) is not None


def policy_of(shares: Sequence[PolicyShare], attempt: int) -> str:
    """The policy of an attempt: the shares take turns, each as often as its weight."""
    turn = attempt % round_of(shares)
    for share in shares:
        if turn < share.weight:
            return share.name
        turn -= share.weight
    raise ValueError("there are no policies")


def round_of(shares: Sequence[PolicyShare]) -> int:
    """Attempts in a round of the mixture."""
    return sum(share.weight for share in shares)


def make_policy(name: str, env: TaskEnv, stack: ExitStack, other: MakeOther) -> Policy:
    """Make a policy for an environment.

    Args:
        name: Its name.
        env: The environment.
        stack: Frees what the policy holds.
        other: Makes it if it is none of those made here.
    """
    if not is_named(name):
        return other(name, env)
    spread = noise_of(name)
    made = policy_named("expert" if spread is not None else name)(env)
    if isinstance(made, Expert):
        stack.callback(made.close)
        return NoisyExpert(made, spread) if spread is not None else made
    return made


class NoisyExpert:
    """The expert with Gaussian noise on the numbers of the arms; grippers have none.

    The expert continues from where the noise has led it, as far as its stages allow.

    Args:
        expert: The expert.
        spread: Standard deviation, where actions are from -1 to 1.
    """

    def __init__(self, expert: Expert, spread: float) -> None:
        self._expert, self._spread = expert, spread

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode; the seed determines the noise."""
        self._expert.reset(env, seed)
        # Apart from the generators of the episode and of random actions.
        self._rng = np.random.default_rng([seed, 3])

    def act(self, observations: Mapping[str, Any]) -> Actions | None:
        """The expert's actions with noise, from -1 to 1."""
        actions = self._expert.act(observations)
        if actions is None:
            return None
        noisy = {}
        for agent, action in actions.items():
            noise = self._rng.normal(0.0, self._spread, len(action))
            noise[self._expert.env.episode.actions[agent].arm_size :] = 0.0
            noisy[agent] = np.clip(action + noise, -1.0, 1.0).astype(np.float32)
        return noisy

    def log(self) -> ScriptLog:
        """The log of the expert's stages."""
        return self._expert.log()
