"""The moments of an episode that tell its story."""

from __future__ import annotations

from itertools import pairwise

from taskbuilder.rollout.record import Rollout

KEYFRAMES = 8


def keyframes(rollout: Rollout, count: int = KEYFRAMES) -> tuple[int, ...]:
    """Control steps that show what happened, in order; 0 is the moment after reset.

    The beginning, the end, each step at which a stage or success was reached, and between them,
    where the gaps are widest, as many as are still missing.

    Args:
        rollout: The episode.
        count: How many at most; there are fewer where the episode has fewer steps.
    """
    end = rollout.steps
    turns = dict.fromkeys(sorted(rollout.reached.values()))
    if rollout.first_success is not None:
        turns[rollout.first_success] = None
    inner = [step for step in turns if 0 < step < end]
    chosen = {0, end, *inner[max(0, len(inner) - (count - 2)) :]}
    while len(chosen) < count:
        gaps = [(after - before, before) for before, after in pairwise(sorted(chosen))]
        widest, start = max(gaps, key=lambda gap: gap[0], default=(0, 0))
        if widest < 2:
            break
        chosen.add(start + widest // 2)
    return tuple(sorted(chosen))


def caption(rollout: Rollout, step: int) -> tuple[str, ...]:
    """What was achieved with a control step: stages and success."""
    said = [name for name, at in rollout.reached.items() if at == step]
    if step == rollout.first_success:
        said.append("success")
    return tuple(said)
