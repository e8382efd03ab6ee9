"""Records of episodes that were never played."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from taskbuilder.env.options import Options
from taskbuilder.rollout import Rollout


def made_rollout(
    stage: Sequence[int] = (0, 0, 0, 0, 0),
    *,
    seed: int = 0,
    task: str = "made_up",
    stages: tuple[str, ...] = ("one", "two", "three"),
    success: Sequence[int] = (),
    failure: Sequence[int] = (),
    terms: Mapping[str, Sequence[float]] | None = None,
    agents: tuple[str, ...] = ("arm",),
    **more: Any,
) -> Rollout:
    """An episode in which so many stages were reached after reset and after each step.

    Args:
        stage: The furthest stage of each state.
        seed: Of the reset.
        task: Its name.
        stages: The names of all.
        success: The states in which success holds.
        failure: The states in which failure holds.
        terms: Each term's value at each step; by default there is one that is always 0.
        agents: The robots, which hold still.
        more: Other fields.
    """
    states, steps = len(stage), len(stage) - 1
    rows = {label: np.array(values, float) for label, values in (terms or {}).items()}
    rows = rows or {"nothing": np.zeros(steps)}
    held, lost = (np.isin(np.arange(states), steps_) for steps_ in (success, failure))
    team = np.sum(list(rows.values()), axis=0)
    return Rollout(
        **{
            "task": task,
            "seed": seed,
            "variation": 0,
            "options": Options(),
            "control_hz": 10,
            "horizon": max(1, steps),
            "stages": stages,
            "actions": {agent: np.zeros((steps, 5), dtype=np.float32) for agent in agents},
            "rewards": team,
            "agent_rewards": dict.fromkeys(agents, team),
            "terms": rows,
            "conditions": {"success": held, "failure": lost},
            "stage": np.array(stage),
            "progress": np.zeros(states),
            "succeeded": np.logical_or.accumulate(held & ~np.logical_or.accumulate(lost)),
            **more,
        }
    )
