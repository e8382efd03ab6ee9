"""Suggestions for names that were not found."""

from __future__ import annotations

from collections.abc import Iterable


def closest(name: str, known: Iterable[str]) -> str | None:
    """The known name that another is most like, if any is.

    Upper and lower case count as the same: the commonest slip is FINGER.STL for finger.stl.
    """
    from difflib import get_close_matches  # slow to import, and needed only to explain a failure

    by_lower = {candidate.lower(): candidate for candidate in known}
    close = get_close_matches(name.lower(), by_lower, n=1)
    return by_lower[close[0]] if close else None


def did_you_mean(name: str, known: Iterable[str], otherwise: str) -> str:
    """A question that names the known name closest to another, or other advice."""
    close = closest(name, known)
    return f"did you mean {close!r}?" if close else otherwise
