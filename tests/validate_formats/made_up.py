"""Episodes and texts as they might be, made up."""

from __future__ import annotations

from made_rollouts import made_rollout

from taskbuilder.rollout import Rollout, ScriptLog, Trouble

NASTY = "<script>&\"'\x1b[31m\udc80"
"""What would be markup, or what no document can hold."""


def played(seed: int, *, success: bool, trouble: Trouble | None = None) -> Rollout:
    """An episode of the handover in which everyone holds still."""
    return made_rollout(
        seed=seed,
        task="handover",
        stages=(),
        agents=("left", "right"),
        success=(3, 4) if success else (),
        log=ScriptLog((1, 2) if success else (), trouble),
    )
