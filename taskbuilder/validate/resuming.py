"""What an interrupted validation has found, so that another one can go on from there.

After each family of checks, the results so far are written to a file in the user's cache folder:
``$XDG_CACHE_HOME/taskbuilder/validations``, or ``~/.cache/taskbuilder/validations``. The folder
belongs to this user alone, since the file is a pickle, and reading one may run what it contains.
"""

from __future__ import annotations

import logging
import os
import pickle
import stat
import sys
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path

from taskbuilder import __version__
from taskbuilder.files import write_whole
from taskbuilder.schema.proofs import checksum
from taskbuilder.validate.apart import Kept, ValidationConfig

_log = logging.getLogger(__name__)

_DAMAGED = (OSError, EOFError, ValueError, TypeError, LookupError, AttributeError, ImportError)
"""What reading a damaged file, or one of another version, may raise, besides `PickleError`."""


class PartialResult:
    """The file of the results of a validation that is not finished.

    Validations of the same task file with the same arguments share a file.

    Args:
        config: The arguments of the validation.

    Raises:
        FileError: The task cannot be found.
        OSError: Its files cannot be read.
    """

    def __init__(self, config: ValidationConfig) -> None:
        entry = config.catalogue.task(config.reference)
        self._checksum = checksum(entry)
        asked = (
            str(entry.file.resolve()),
            *(config.level, config.seeds, config.only, config.robots, config.grasp),
            *(__version__, sys.version),
        )
        digest = blake2b(repr(asked).encode(), digest_size=8).hexdigest()
        self.path = _folder() / f"{entry.file.stem}-{digest}.partial"

    def load(self) -> tuple[Kept | None, str]:
        """The results so far, if they are there and of use, and what is to be said about them."""
        if not self.path.exists():
            return None, "nothing was interrupted; starting from the beginning"
        if not _is_own(self.path.parent) or not _is_own(self.path):
            return None, f"{self.path} could be written by others; starting anew"
        try:
            summed, kept = pickle.loads(self.path.read_bytes())  # noqa: S301  # this user's own
            families = [family.name for family in kept.report.families]
        except (*_DAMAGED, pickle.PickleError):
            return None, f"{self.path} is damaged; starting anew"
        if summed != self._checksum:
            return None, "its files have changed since it was interrupted; starting anew"
        return kept, f"going on after {families[-1]}"

    def save(self, kept: Kept) -> None:
        """Keep the results so far; warns if they cannot be kept."""
        try:
            self.path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not _is_own(self.path.parent):
                _log.warning("%s could be written by others; nothing is kept", self.path.parent)
                return
            write_whole(self.path, pickle.dumps((self._checksum, kept)))
            self.path.chmod(0o600)
        except OSError as error:
            _log.warning("the results so far cannot be kept for --resume: %s", error)

    def remove(self) -> None:
        """Remove the file, if it is there."""
        with suppress(OSError):
            self.path.unlink()


def _folder() -> Path:
    configured = os.environ.get("XDG_CACHE_HOME", "")
    # The specification has relative paths ignored.
    if Path(configured).is_absolute():
        base = Path(configured)
    else:
        base = Path(os.path.expanduser("~")) / ".cache"  # noqa: PTH111 - Path.home() may raise
    return base / "taskbuilder" / "validations"


def _is_own(path: Path) -> bool:
    """Whether a file or folder belongs to this user, and nobody else can write it."""
    found = path.lstat()
    if stat.S_ISLNK(found.st_mode):
        return False
    if not hasattr(os, "getuid"):
        return True
    return found.st_uid == os.getuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
