"""Make the corrections that findings carry, in the files that they are about."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import unified_diff
from pathlib import Path

from taskbuilder.errors import Fix, UsageError, display_path
from taskbuilder.files import write_whole


@dataclass(frozen=True)
class Correction:
    """A file with corrections.

    Attributes:
        file: The file.
        before: Its text.
        after: Its text with the corrections.
    """

    file: Path
    before: str
    after: str

    def diff(self) -> str:
        """The difference, as a unified diff with one line of context."""
        name = display_path(self.file)
        before, after = (text.splitlines(keepends=True) for text in (self.before, self.after))
        return "".join(unified_diff(before, after, fromfile=name, tofile=name, n=1))

    def write(self) -> None:
        """Write the corrected file.

        Raises:
            UsageError: The file is no longer the one that was corrected.
            OSError: It cannot be written.
        """
        if _read(self.file) != self.before:
            raise UsageError(f"{display_path(self.file)} has changed meanwhile; run it again")
        write_whole(self.file, self.after.encode("utf-8"))


def correct(fixes: Iterable[Fix]) -> tuple[Correction, ...]:
    """The files of some fixes, with these corrections in them.

    Of several fixes for one place, the first is made.

    Raises:
        UsageError: A file does not have the text that a fix is for; it has changed meanwhile.
        OSError: A file cannot be read.
    """
    by_file: dict[Path, dict[tuple[int, int], Fix]] = {}
    for fix in fixes:
        places = by_file.setdefault(fix.location.file, {})
        places.setdefault((fix.location.line, fix.location.column), fix)
    corrections = []
    for file, places in by_file.items():
        before = _read(file)
        lines = before.splitlines(keepends=True)
        for _, fix in sorted(places.items(), reverse=True):  # from the end, so that places stay
            _put(fix, lines)
        corrections.append(Correction(file, before, "".join(lines)))
    return tuple(corrections)


def _put(fix: Fix, lines: list[str]) -> None:
    """Make a correction in the lines of its file."""
    number, column = fix.location.line - 1, fix.location.column - 1
    line = lines[number] if number < len(lines) else ""
    start = column + line[column:].startswith(('"', "'"))
    if not line.startswith(fix.old, start):
        raise UsageError(f'{fix.location}: there is no "{fix.old}"; the file has changed meanwhile')
    lines[number] = line[:start] + fix.new + line[start + len(fix.old) :]


def _read(file: Path) -> str:
    """The text of a file, with its own ends of lines."""
    return file.read_bytes().decode("utf-8")
