"""Experts of the suite `seed`, and what they did: played once, for as many tests as like.

Every other task of the library is played once, in tests/library.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

from written_experts import Digest

from taskbuilder import load_suite
from taskbuilder.description.description import Outcome
from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import Rollout

TASKS = load_suite("seed").tasks
SCENES = [(name, k) for k, name in enumerate(TASKS)]
"""A variation of each task; proofs have played all of them."""

SEEDS = range(20_000, 20_002)


@dataclass
class Watching:
    """Keeps what the referee said, and whether any robot held anything, at reset and each step."""

    digest: Digest = field(default_factory=Digest)
    outcomes: list[Outcome] = field(default_factory=list)
    holding: list[bool] = field(default_factory=list)

    def __call__(self, env: TaskEnv) -> None:
        self.digest(env)
        self.outcomes.append(env.episode.outcome)
        self.holding.append(any(env.episode.holding(robot) for robot in env.possible_agents))


@dataclass(frozen=True)
class Played:
    """An expert's episode.

    Attributes:
        demonstration: What it did.
        digest: The hash of all that happened.
        outcomes: What the referee said, at reset and after each control step.
        holding: Whether any robot held anything then.
    """

    demonstration: Rollout
    digest: str
    outcomes: Sequence[Outcome]
    holding: Sequence[bool]


@cache
def expert_of(scene: tuple[str, int]) -> Expert:
    """An expert for a scene of a task."""
    name, variation = scene
    return Expert(parallel_env(name, variation=variation))


@cache
def played(scene: tuple[str, int], seed: int) -> Played:
    """What the expert did from a seed."""
    watch = Watching()
    demonstration = expert_of(scene).play(seed, watch=watch)
    return Played(demonstration, watch.digest.hex, watch.outcomes, watch.holding)
