"""A policy beside its baselines, on the same seeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean

from taskbuilder.evaluation.arms import BASELINES, SUBJECT
from taskbuilder.expert.baselines import EXPERT, RANDOM, Baseline, BaselineKind
from taskbuilder.rollout.record import Rollout

Arms = Mapping[Baseline, Sequence[Rollout]]
"""Episodes by arm; the baselines play the first seeds of the policy."""


@dataclass(frozen=True)
class Beside:
    """A baseline compared with the policy, on the seeds that both played.

    Attributes:
        arm: The arm of the baseline.
        episodes: Number of common seeds.
        success_rate: Success rate of the baseline at some step.
        success_at_end_rate: Success rate of the baseline at the last step.
        mean_return: Mean return of the baseline.
        policy_return: Mean return of the policy, on the same seeds.
    """

    arm: Baseline
    episodes: int
    success_rate: float
    success_at_end_rate: float
    mean_return: float
    policy_return: float


@dataclass(frozen=True)
class Comparison:
    """The comparison of a policy with its baselines.

    Attributes:
        controls: The expert, random actions and holding still, if they played.
        best_stall: The stall with the highest return in episodes without success, or None.
    """

    controls: tuple[Beside, ...]
    best_stall: Beside | None

    @property
    def normalized_return(self) -> float | None:
        """The return on a scale from random actions (0) to the expert (1)."""
        by_arm = {beside.arm: beside for beside in self.controls}
        if EXPERT not in by_arm or RANDOM not in by_arm:
            return None
        low, high = by_arm[RANDOM].mean_return, by_arm[EXPERT].mean_return
        if not high > low:
            return None
        return (by_arm[EXPERT].policy_return - low) / (high - low)


def compare(arms: Arms) -> Comparison:
    """Compare the policy of a trial with its baselines."""
    own = {rollout.seed: rollout for rollout in arms[SUBJECT]}
    controls = tuple(
        _beside(baseline, arms[baseline], own) for baseline in BASELINES if arms.get(baseline)
    )
    stalls = []
    for baseline, played in arms.items():
        failed = [rollout for rollout in played if not rollout.success]
        if baseline.kind is BaselineKind.STALL and failed:
            stalls.append(_beside(baseline, failed, own))
    best = max(stalls, key=lambda beside: beside.mean_return, default=None)
    return Comparison(controls, best)


def _beside(baseline: Baseline, played: Sequence[Rollout], own: Mapping[int, Rollout]) -> Beside:
    return Beside(
        arm=baseline,
        episodes=len(played),
        success_rate=fmean(rollout.success for rollout in played),
        success_at_end_rate=fmean(rollout.success_at_end for rollout in played),
        mean_return=fmean(rollout.team_return for rollout in played),
        policy_return=fmean(own[rollout.seed].team_return for rollout in played),
    )
