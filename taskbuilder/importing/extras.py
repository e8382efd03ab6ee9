"""Packages that only imports need, and what to install where they are missing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from taskbuilder.errors import UsageError


@contextmanager
def extra_needed(purpose: str) -> Iterator[None]:
    """Import packages of the extra ``import`` within this block.

    Args:
        purpose: What they are needed for, as the beginning of a sentence.

    Raises:
        UsageError: One of them is not installed.
    """
    try:
        yield
    except ImportError as error:
        raise UsageError(
            f'{purpose} needs {error.name}; install the extra: pip install "taskbuilder[import]"'
        ) from None
