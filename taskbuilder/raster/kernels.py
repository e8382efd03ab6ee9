"""Compiling the loops of the rasteriser, and keeping what was compiled.

Compiling takes some seconds, so Numba keeps the result: in the folder of environment variable
``NUMBA_CACHE_DIR``, beside the source file, or in the user's cache folder. Where none of these can
be written, as in a container with a read-only file system, it is kept in a temporary folder.
"""

from __future__ import annotations

import logging
import os
import stat
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from numba import config, njit

Loop = TypeVar("Loop", bound=Callable[..., Any])

_log = logging.getLogger(__name__)


class _Kept:
    """Whether it was said that nothing is kept."""

    said = False


def kernel(**options: Any) -> Callable[[Loop], Loop]:
    """Compile a function by Numba when it is first called, and keep the result.

    Args:
        options: Further options of `numba.njit`.
    """

    def compiled(function: Loop) -> Loop:
        made: Loop | None = _with_cache(function, options)
        if made is None and (folder := _temporary_folder()):
            settings = vars(config)  # for all that Numba compiles in this process
            before, settings["CACHE_DIR"] = settings["CACHE_DIR"], str(folder)
            try:
                made = _with_cache(function, options)
            finally:
                settings["CACHE_DIR"] = before
        if made is not None:
            return made
        if not _Kept.said:
            _Kept.said = True
            _log.warning(
                "no folder can be written, so every process compiles the renderer anew, which "
                "takes seconds; set NUMBA_CACHE_DIR to a folder that can be written"
            )
        found: Loop = njit(nogil=True, **options)(function)
        return found

    return compiled


def _with_cache(function: Loop, options: dict[str, Any]) -> Loop | None:
    try:
        found: Loop = njit(cache=True, nogil=True, **options)(function)
    except RuntimeError as error:
        if "cannot cache function" not in str(error):
            raise
        return None
    return found


def _temporary_folder() -> Path | None:
    """A folder of this user alone, as Numba runs what it finds there; None if there can be none."""
    try:
        user = os.getuid() if hasattr(os, "getuid") else ""
        folder = Path(tempfile.gettempdir(), f"taskbuilder-kernels-{user}")
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
    except OSError:
        return None
    own = not hasattr(os, "getuid") or (
        found.st_uid == os.getuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    )
    return folder if own and stat.S_ISDIR(found.st_mode) else None
