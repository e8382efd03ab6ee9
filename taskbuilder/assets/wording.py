"""Suggestions for names that were not found."""

from __future__ import annotations

from collections.abc import Iterable


def did_you_mean(name: str, known: Iterable[str], otherwise: str) -> str:
    """A question that names the known name closest to another, or other advice.

    Upper and lower case count as the same: the commonest slip is FINGER.STL for finger.stl.
    """
    from difflib import get_close_matches  # slow to import, and needed only to explain a failure

    by_lower = {candidate.lower(): candidate for candidate in known}
    close = get_close_matches(name.lower(), by_lower, n=1)
    return f"did you mean {by_lower[close[0]]!r}?" if close else otherwise
