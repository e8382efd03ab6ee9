"""Transitions over several control steps, so that rewards reach the values sooner."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskbuilder.learn.shapes import Layout, Rows


class NStepTransitions:
    """Joins the transitions of each environment to transitions over n control steps.

    The reward becomes r₀ + γ r₁ + … + γⁿ⁻¹ rₙ₋₁, and the next observations, the next state and the
    flags are those after the n-th step (Sutton 1988; for replay buffers, Hessel et al. 2018).
    Near the end of an episode, transitions are over fewer steps. Each row says over how many.

    The exploring policy chose the actions after the first, which is not corrected.

    Args:
        layout: The layout of a row.
        envs: Number of parallel environments.
        steps: n; with 1, transitions stay as they are.
        discount: γ.
    """

    def __init__(self, layout: Layout, envs: int, steps: int, discount: float) -> None:
        self._layout, self._steps, self._discount = layout, steps, discount
        self._open: list[list[Rows]] = [[] for _ in range(envs)]

    def begin(self) -> None:
        """Forget the transitions that are not complete; all environments are reset."""
        for rows in self._open:
            rows.clear()

    def add(self, rows: Rows, lost: NDArray[np.bool_]) -> Rows:
        """Add a step of every environment.

        Args:
            rows: The transitions of the step: (envs, width).
            lost: Where the transition was lost with its worker: (envs,).

        Returns:
            The transitions that are complete now: (any number, width).
        """
        complete: list[Rows] = []
        for unfinished, row, is_lost in zip(self._open, rows, lost, strict=True):
            if not is_lost:
                for age, earlier in zip(range(len(unfinished), 0, -1), unfinished, strict=True):
                    self._extend(earlier, row, age)
                unfinished.append(row.copy())
            if is_lost or row[self._layout.ended.start] > 0.0:
                complete += unfinished
                unfinished.clear()
            elif len(unfinished) == self._steps:
                complete.append(unfinished.pop(0))
        return np.stack(complete) if complete else rows[:0]

    def _extend(self, earlier: Rows, row: Rows, age: int) -> None:
        """Extend a transition by the one that is ``age`` control steps later."""
        layout = self._layout
        earlier[layout.rewards] += self._discount**age * row[layout.rewards]
        earlier[layout.extra_steps] = age
        for part in (layout.ended, layout.terminated, layout.next_critic_input):
            earlier[part] = row[part]
