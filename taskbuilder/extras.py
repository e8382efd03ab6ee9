"""Packages that only some parts need, and what to install where they are missing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from taskbuilder.errors import UsageError


@contextmanager
def extra_needed(extra: str, purpose: str) -> Iterator[None]:
    """Import packages of an extra within this block.

    Args:
        extra: Name of the extra, such as ``data``.
        purpose: What its packages are needed for, as the beginning of a sentence.

    Raises:
        UsageError: One of them is not installed.
    """
    try:
        yield
    except ImportError as error:
        raise UsageError(
            f'{purpose} needs {error.name}; install the extra: pip install "taskbuilder[{extra}]"'
        ) from None
