"""What happened in an episode, control step by control step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from taskbuilder.description.description import Outcome
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.demonstration import Demonstration, replay

AFTERWARDS_S = 1.0
"""How long an episode is of interest once it has succeeded."""


@dataclass(frozen=True)
class Chronicle:
    """The referee's words on an episode.

    Attributes:
        task: The task's name.
        seed: Of the reset.
        stages: The description's stages, in order.
        outcomes: After reset, and after each control step that the physics survived.
        control_hz: Control steps a second.
        horizon: Control steps of a whole episode.
    """

    task: str
    seed: int
    stages: tuple[str, ...]
    outcomes: tuple[Outcome, ...]
    control_hz: int
    horizon: int

    @property
    def steps(self) -> int:
        """Control steps that were judged."""
        return len(self.outcomes) - 1

    @property
    def first_success(self) -> int | None:
        """Control steps that had passed when success first held, or None."""
        return next((step for step, o in enumerate(self.outcomes) if o.success), None)

    @property
    def reached(self) -> Mapping[str, int]:
        """Control steps that had passed when each stage was first passed, in order of stages."""
        return {
            name: step
            for number, name in enumerate(self.stages, start=1)
            for step in [next((i for i, o in enumerate(self.outcomes) if o.stage >= number), None)]
            if step is not None
        }

    @property
    def end(self) -> int:
        """The control step after which nothing of interest happens."""
        if self.first_success is None:
            return self.steps
        return min(self.steps, self.first_success + round(AFTERWARDS_S * self.control_hz))

    def seconds(self, step: int) -> float:
        """Seconds since the episode began."""
        return step / self.control_hz


def chronicle(env: TaskEnv, demonstration: Demonstration) -> Chronicle:
    """What the referee says when a demonstration is played again.

    Args:
        env: As for `replay`.
        demonstration: The episode.

    Raises:
        UsageError: The environment is of another task.
    """
    outcomes: list[Outcome] = []

    def note(played: TaskEnv) -> None:
        if not played.episode.exploded:
            outcomes.append(played.episode.outcome)

    replay(env, demonstration, note)
    timing = env.task.file.spec.timing
    return Chronicle(
        task=env.task.name,
        seed=demonstration.seed,
        stages=tuple(env.task.description.stages),
        outcomes=tuple(outcomes),
        control_hz=env.options.control_hz or timing.control_hz,
        horizon=env.episode.horizon,
    )
