"""The results of an evaluation, and the records of its episodes, as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from taskbuilder.digests import digest
from taskbuilder.evaluation.arms import SUBJECT
from taskbuilder.evaluation.comparison import Arms, Beside, compare
from taskbuilder.evaluation.summary import EvaluationSummary, summarise
from taskbuilder.expert.baselines import BaselineKind
from taskbuilder.rollout.record import Rollout


def record(rollout: Rollout) -> dict[str, Any]:
    """The data of an episode, with a digest of its actions, rewards and conditions.

    What it drew for disturbances is ``disturbed``, where there are any.
    """
    return {
        "seed": rollout.seed,
        "variation": rollout.variation,
        "success": rollout.success,
        "success_at_end": rollout.success_at_end,
        "first_success": rollout.first_success,
        "success_held_s": rollout.success_held_s,
        "failed_at": rollout.failed_at,
        "return": rollout.team_return,
        "steps": rollout.first_success or rollout.steps,
        "stage": rollout.furthest_stage,
        "peak_robot_force": rollout.peak_robot_force,
        "why": [asdict(reason) for reason in rollout.why],
        "digest": digest_of_rollout(rollout),
        **({"disturbed": dict(rollout.disturbed)} if rollout.disturbed else {}),
    }


def digest_of_rollout(rollout: Rollout) -> str:
    """A digest of an episode: its actions, its rewards and all its conditions, bit for bit."""
    parts = [f"{rollout.task} {rollout.seed} {rollout.variation} {rollout.exploded}".encode()]
    for values in (rollout.actions, rollout.agent_rewards, rollout.terms, rollout.conditions):
        for name in sorted(values):
            array = np.ascontiguousarray(values[name])
            parts += [f"{name} {array.dtype.str} {array.shape}".encode(), array.tobytes()]
    parts += [rollout.rewards.tobytes(), rollout.progress.tobytes(), rollout.stage.tobytes()]
    return digest(b"\n".join(parts))


def as_data(arms: Arms, stages: Sequence[str]) -> dict[str, Any]:
    """The results of a trial as data, without its episodes.

    Args:
        arms: All episodes.
        stages: Names of the task's stages, "" first.
    """
    summary = summarise(arms[SUBJECT], len(stages) - 1)
    comparison = compare(arms)
    held, peak = summary.success_held_s, summary.peak_robot_force
    return {
        "success_rate": summary.success_rate,
        "interval": list(summary.interval),
        "success_at_end_rate": summary.success_at_end_rate,
        "interval_at_end": list(summary.interval_at_end),
        "success_held_s": dict(zip(("mean", "median"), held, strict=True)) if held else None,
        "peak_robot_force": dict(zip(("median", "max"), peak, strict=True)) if peak else None,
        "return": summary.mean_return,
        "return_iqm": summary.iqm_return,
        "normalized_return": comparison.normalized_return,
        "steps_to_success": summary.steps_to_success,
        "stages": dict(zip(stages, summary.stages, strict=True)),
        "terms": dict(summary.terms),
        "seeds": roles(summary),
        "controls": {str(beside.arm): _as_data(beside, arms) for beside in comparison.controls},
        "best_stall": _as_data(comparison.best_stall, arms) if comparison.best_stall else None,
    }


def _as_data(beside: Beside, arms: Arms) -> dict[str, Any]:
    data = {
        "episodes": beside.episodes,
        "return": beside.mean_return,
        "policy_return": beside.policy_return,
        "success_rate": beside.success_rate,
        "success_at_end_rate": beside.success_at_end_rate,
    }
    if beside.arm.kind is BaselineKind.STALL:
        return {"after_stage": beside.arm.stage, **data}
    played = arms[beside.arm]
    summary = summarise(played, len(played[0].stages))
    return {
        **data,
        "interval": list(summary.interval),
        "interval_at_end": list(summary.interval_at_end),
    }


def roles(summary: EvaluationSummary) -> dict[str, int | None]:
    """Seeds of the best, the median and a failed episode."""
    return {"best": summary.best, "median": summary.median, "failed": summary.failed}
