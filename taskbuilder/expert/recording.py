"""Record an episode while it is played."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.expert.demonstration import Demonstration, Trouble, Watch
from taskbuilder.expert.driving import Actions


class EpisodeOver(Exception):  # noqa: N818  # the end of an episode is no error
    """No control step is left."""


class Recording:
    """An episode under way: steps the environment and keeps what was done and earned.

    Args:
        env: The environment, whose variation is fixed.
        seed: Of the reset, which happens at once.
        watch: Called after reset and after each control step.

    Attributes:
        seen: What every agent observes now.

    Raises:
        UsageError: The environment draws its variation.
    """

    def __init__(self, env: TaskEnv, seed: int, watch: Watch = lambda _: None) -> None:
        if env.options.variation == "random":
            raise UsageError("a demonstration is of one variation; make the environment with it")
        self.env = env
        self._seed = seed
        self._watch = watch
        self._actions: list[Actions] = []
        self._rewards: list[float] = []
        self._terms: list[dict[str, float]] = []
        self._first_success: int | None = None
        self.seen, _ = env.reset(seed=seed)
        watch(env)

    @property
    def steps(self) -> int:
        """Control steps so far."""
        return len(self._rewards)

    @property
    def over(self) -> bool:
        """Whether the episode has ended."""
        return not self.env.agents

    def step(self, actions: Actions) -> None:
        """Take a control step.

        Raises:
            EpisodeOver: There is none left.
        """
        if self.over:
            raise EpisodeOver
        self.seen, *_ = self.env.step(actions)
        self._actions.append(actions)
        self._rewards.append(self.env.team_reward())
        self._terms.append(dict(self.env.episode.outcome.terms))
        if self._first_success is None and self.env.episode.succeeded:
            self._first_success = self.steps
        self._watch(self.env)

    def demonstration(
        self,
        *,
        stage_ends: tuple[int, ...] = (),
        trouble: Trouble | None = None,
        planning_s: float = 0.0,
    ) -> Demonstration:
        """What has been played so far."""
        env = self.env
        stages = tuple(env.task.description.stages)
        reached = env.episode.outcome.stage
        labels = [term.label for term in env.task.description.reward]
        variation = env.options.variation
        return Demonstration(
            task=env.task.name,
            seed=self._seed,
            variation=variation if isinstance(variation, int) else 0,
            actions={agent: self._actions_of(agent) for agent in env.possible_agents},
            rewards=np.array(self._rewards, dtype=np.float64),
            terms={
                label: np.array([terms[label] for terms in self._terms], dtype=np.float64)
                for label in labels
            },
            success=self._first_success is not None,
            first_success=self._first_success,
            milestone=stages[reached - 1] if reached else "",
            stage_ends=stage_ends,
            trouble=trouble,
            planning_s=planning_s,
        )

    def _actions_of(self, agent: str) -> NDArray[np.float32]:
        size = self.env.episode.actions[agent].size
        return np.array([a[agent] for a in self._actions], dtype=np.float32).reshape(-1, size)
