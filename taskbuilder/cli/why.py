"""Why an episode was no success, for people."""

from __future__ import annotations

from collections.abc import Iterator

from taskbuilder.rollout.record import Rollout

ASIDE = " " * 8
"""Before lines that belong to the one above."""


def reasons_of(episode: Rollout) -> Iterator[str]:
    """Why success does not hold at the end, a line each, and a stage that failed after success."""
    lost = "lost at the end: " if episode.success else ""
    yield from (f"{lost}{reason}" for reason in episode.why)
    trouble = episode.trouble
    if episode.success and trouble is not None:
        yield f"after success stage {trouble.stage} failed ({trouble.order}): {trouble.message}"
