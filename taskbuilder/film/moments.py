"""The moments of an episode that tell its story."""

from __future__ import annotations

from itertools import pairwise

from taskbuilder.film.chronicle import Chronicle

MOMENTS = 8

_A_LITTLE_S = 0.5


def key_moments(chronicle: Chronicle, count: int = MOMENTS) -> tuple[int, ...]:
    """Control steps that show what happened, in order; 0 is the moment after reset.

    The beginning, the end (a little after success, if there was one), each step at which a stage
    was reached, and between them, where the gaps are widest, as many as are still missing.

    Args:
        chronicle: The episode.
        count: How many at most; there are fewer where the episode has fewer steps.
    """
    end = chronicle.end
    turns = dict.fromkeys(chronicle.reached.values())
    if chronicle.first_success is not None:
        end = min(end, chronicle.first_success + round(_A_LITTLE_S * chronicle.control_hz))
        turns[chronicle.first_success] = None
    inner = [step for step in turns if 0 < step < end]
    chosen = {0, end, *inner[max(0, len(inner) - (count - 2)) :]}
    while len(chosen) < count:
        gaps = [(after - before, before) for before, after in pairwise(sorted(chosen))]
        widest, start = max(gaps, key=lambda gap: gap[0], default=(0, 0))
        if widest < 2:
            break
        chosen.add(start + widest // 2)
    return tuple(sorted(chosen))


def caption(chronicle: Chronicle, step: int) -> tuple[str, ...]:
    """What was achieved with a control step: stages and success."""
    said = [name for name, at in chronicle.reached.items() if at == step]
    if step == chronicle.first_success:
        said.append("success")
    return tuple(said)
