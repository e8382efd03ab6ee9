"""What an interrupted validation has found, so that another one can go on from there.

After each family of checks, the results so far are written to a file in the user's cache folder:
``$XDG_CACHE_HOME/taskbuilder/validations``, or ``~/.cache/taskbuilder/validations``. The folder
belongs to this user alone, since whoever can write the file decides what the report says.
"""

from __future__ import annotations

import logging
import os
import stat
import sys
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path

from taskbuilder import __version__
from taskbuilder.errors import TaskbuilderError
from taskbuilder.files import cache_folder, write_whole
from taskbuilder.schema.proofs import checksum
from taskbuilder.validate.apart import Kept, ValidationConfig

_log = logging.getLogger(__name__)

_KIND = "partial validation"

_DAMAGED = (TaskbuilderError, OSError, ValueError, TypeError, LookupError, AttributeError)
"""What reading a damaged file may raise."""


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
            *(config.level, config.seeds, config.only, config.options),
            *(__version__, sys.version),
        )
        digest = blake2b(repr(asked).encode(), digest_size=8).hexdigest()
        self.path = cache_folder("validations") / f"{entry.file.stem}-{digest}.partial"

    def load(self) -> tuple[Kept | None, str]:
        """The results so far, if they are there and of use, and what is to be said about them."""
        from taskbuilder.arrays import read_arrays  # a static validation loads no NumPy
        from taskbuilder.validate.plain_data import from_plain

        if not self.path.exists():
            return None, "nothing was interrupted; starting from the beginning"
        if not _is_own(self.path.parent) or not _is_own(self.path):
            return None, f"{self.path} could be written by others; starting anew"
        try:
            arrays, about = read_arrays(self.path, _KIND)
            kept = Kept(*from_plain(about["kept"], arrays))
            families = [family.name for family in kept.report.families]
        except _DAMAGED:
            return None, f"{self.path} is damaged; starting anew"
        if about.get("checksum") != self._checksum:
            return None, "its files have changed since it was interrupted; starting anew"
        return kept, f"going on after {families[-1]}"

    def save(self, kept: Kept) -> None:
        """Keep the results so far; warns if they cannot be kept."""
        from taskbuilder.arrays import packed_arrays
        from taskbuilder.validate.plain_data import to_plain

        try:
            self.path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not _is_own(self.path.parent):
                _log.warning("%s could be written by others; nothing is kept", self.path.parent)
                return
            data, arrays = to_plain((kept.report, kept.state))
            about = {"kind": _KIND, "checksum": self._checksum, "kept": data}
            write_whole(self.path, packed_arrays(arrays, about))
            self.path.chmod(0o600)
        except (OSError, TypeError) as error:
            _log.warning("the results so far cannot be kept for --resume: %s", error)

    def remove(self) -> None:
        """Remove the file, if it is there."""
        with suppress(OSError):
            self.path.unlink()


def _is_own(path: Path) -> bool:
    """Whether a file or folder belongs to this user, and nobody else can write it."""
    found = path.lstat()
    if stat.S_ISLNK(found.st_mode):
        return False
    if not hasattr(os, "getuid"):
        return True
    return found.st_uid == os.getuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
