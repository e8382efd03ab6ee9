"""A policy under disturbances, one by one, against its undisturbed episodes from the same seeds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import replace
from typing import Any

from taskbuilder.env.disturbing import inapplicable
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.evaluation.arms import SUBJECT
from taskbuilder.evaluation.comparison import Arms
from taskbuilder.evaluation.results import as_data, record
from taskbuilder.evaluation.subject import Subject
from taskbuilder.evaluation.summary import Disturbed
from taskbuilder.schema.disturbances import AXES


def applicable(subject: Subject, asked: Iterable[tuple[str, float]]) -> tuple[Disturbed, ...]:
    """The disturbances that are asked for, without results, and which of them do not apply.

    Args:
        subject: Who is evaluated, and where.
        asked: Axes and levels; see `each_disturbance`.

    Raises:
        UsageError: None of them applies.
    """
    with closing(subject.make_env()) as env:
        rows = tuple(Disturbed(*each, why_not(each[0], subject, env)) for each in asked)
    if rows and all(row.why_not for row in rows):
        reasons = "; ".join(f"{row}: {row.why_not}" for row in rows)
        raise UsageError(f"no disturbance applies to {subject.name}: {reasons}")
    return rows


def why_not(axis: str, subject: Subject, env: TaskEnv) -> str:
    """Why a disturbance does not apply to a policy in its environment, or "" if it does."""
    options = env.options
    return inapplicable(axis, options.applied(env.task), options.renderer) or _unread(
        axis, subject, env
    )


def _unread(axis: str, subject: Subject, env: TaskEnv) -> str:
    """Why a policy cannot notice a disturbance of what it observes, or ""."""
    player, reads = subject.player, AXES[axis].reads
    if reads is None:
        return ""
    if player.is_word:
        return f"{player.name} plays without observations"
    pictures = env.observed_pictures
    if reads == "pictures" and not pictures:
        return "the policy observes no pictures"
    if reads == "colours" and "rgb" not in pictures:
        return "the policy observes no colour images"
    if reads == "positions" and (player.kind == "served" or not env.observes_positions):
        return "the policy observes no positions"
    if reads == "words" and player.trained is not None:
        return "the policy reads no instruction"
    return ""


def under(subject: Subject, axis: str, level: float) -> Subject:
    """Who is evaluated, under a disturbance in addition to those of its environment."""
    now = dict(subject.options.get("disturbances", ()))
    levels = tuple({**now, axis: level}.items())
    options = {**subject.options, "disturbances": levels}
    pairs = {**dict(subject.make_env.options), "disturbances": levels}
    return replace(
        subject, options=options, make_env=replace(subject.make_env, options=tuple(pairs.items()))
    )


def worst(rows: Sequence[Disturbed]) -> Disturbed:
    """The disturbance with the least success; of those, with the least at the last step."""

    def success(row: Disturbed) -> tuple[float, float]:
        held = row.summary
        return (held.success_rate, held.success_at_end_rate) if held else (2.0, 2.0)

    return min(rows, key=success)


def row_as_data(row: Disturbed, arms: Arms | None, stages: Sequence[str]) -> dict[str, Any]:
    """The results under a disturbance as data, with the records of the episodes.

    Args:
        row: The disturbance.
        arms: The episodes; None if it does not apply.
        stages: Names of the task's stages, "" first.
    """
    about: dict[str, Any] = {"axis": row.axis, "level": row.level, "applies": arms is not None}
    if arms is None:
        return {**about, "why_not": row.why_not}
    records = [record(episode) for episode in arms[SUBJECT]]
    return {**about, **as_data(arms, stages), "episodes": records}
