"""How messages name what is wrong, and what was probably meant."""

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


def suggestion(
    wrong: str, known: Iterable[str], *, what: str = "known keys", otherwise: str = ""
) -> str:
    """What would be right in place of a wrong word.

    Args:
        wrong: The word.
        known: The words that would be right.
        what: What these are, before a list of them, where none is close.
        otherwise: Advice in place of that list.
    """
    names = list(known)
    if close := closest(wrong, names):
        return f'did you mean "{close}"?'
    if otherwise:
        return otherwise
    return f"{what}: {', '.join(names)}" if names else "there are none"


def duration(seconds: float) -> str:
    """A time in round numbers: ``80 s``, ``12 min``, ``1.5 h``."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


def printable(text: str) -> str:
    """A text with escapes in place of control characters other than new lines and tabs.

    Messages quote files that may come from anybody, and a terminal obeys control characters.
    """
    return "".join(c if c.isprintable() or c in "\n\t" else _escaped(c) for c in text)


MOST_QUOTED = 200
"""Characters of a stranger's text that a message shows at most."""


def excerpt(text: object) -> str:
    """The beginning of a text of somebody else's, on one line, as a message may quote it."""
    line = printable(" ".join(str(text)[: 2 * MOST_QUOTED].split()))
    return line if len(line) <= MOST_QUOTED else f"{line[: MOST_QUOTED - 1]}…"


def _escaped(character: str) -> str:
    return character.encode("unicode_escape").decode()


def quoted(text: str) -> str:
    """A name as messages show it: in double quotes, with what cannot be seen escaped."""
    import json  # `list` and `--version` start without it

    return json.dumps(text, ensure_ascii=False)
