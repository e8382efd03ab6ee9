"""Demonstrations: what an expert did in an episode, as actions that repeat it to the bit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError

Watch = Callable[[TaskEnv], None]
"""Looks at an environment after its reset and after each control step."""


@dataclass(frozen=True)
class Trouble:
    """Why a stage could not be done.

    Attributes:
        stage: Number of the stage, from 1, in the order of the task file.
        order: What was to be done, as ``right: grasp stick.right_end``.
        robot: Who could not do it; "" where it was none in particular.
        cause: One of `CAUSES`.
        message: Which robot, which pose and why, in a sentence.
        step: Control steps that had passed.
    """

    stage: int
    order: str
    robot: str
    cause: str
    message: str
    step: int


CAUSES = (
    "out of reach",
    "in collision",
    "no way",
    "grasp missed",
    "lost on the way",
    "not arrived",
    "still held",
    "waited in vain",
    "no time left",
    "physics diverged",
)
"""What keeps experts from doing a stage."""


@dataclass(frozen=True)
class Demonstration:
    """An episode as an expert, or another policy, played it.

    Attributes:
        task: The task's name.
        seed: Of the reset.
        variation: Which scene of the task.
        actions: (steps, n) float32 of each agent, as `TaskEnv.step` takes them.
        rewards: (steps,) the team's reward at each control step.
        terms: (steps,) each reward term by its label.
        success: Success held at some control step.
        first_success: The first such step, counted from 1, or None.
        milestone: The last of the description's stages that was reached, or "".
        stage_ends: Control steps that had passed when each stage of the expert was done.
        trouble: Why the expert stopped, or None if it did all its stages.
        planning_s: Wall time that planning took, in seconds.
    """

    task: str
    seed: int
    variation: int
    actions: Mapping[str, NDArray[np.float32]]
    rewards: NDArray[np.float64]
    terms: Mapping[str, NDArray[np.float64]]
    success: bool
    first_success: int | None
    milestone: str
    stage_ends: tuple[int, ...] = ()
    trouble: Trouble | None = None
    planning_s: float = 0.0

    @property
    def steps(self) -> int:
        """Control steps of the episode."""
        return len(self.rewards)

    def discounted(self, discount: float = 1.0) -> float:
        """The team's return, each reward weighed by the discount to the power of its step."""
        return float(self.rewards @ discount ** np.arange(self.steps))


def replay(env: TaskEnv, demonstration: Demonstration, watch: Watch = lambda _: None) -> None:
    """Play a demonstration's actions again; it goes as it went, to the bit.

    Args:
        env: Of the demonstration's task and variation, with options that it was made with.
        demonstration: What to play.
        watch: Called after reset and after each control step.

    Raises:
        UsageError: The environment is of another task.
    """
    if env.task.name != demonstration.task:
        raise UsageError(f"a demonstration of {demonstration.task}, not of {env.task.name}")
    env.reset(seed=demonstration.seed)
    watch(env)
    for step in range(demonstration.steps):
        env.step({agent: actions[step] for agent, actions in demonstration.actions.items()})
        watch(env)
