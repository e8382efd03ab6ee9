"""What an import changed, and what it left out: a table that is printed and kept."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field

MOST_ROWS = 400


@dataclass(frozen=True)
class Change:
    """One row of the table.

    Attributes:
        subject: The part that it is about, such as ``link base``.
        what: What was changed, such as ``inertia``.
        before: What the source says, in a few words.
        after: What was written instead.
        reason: Why.
    """

    subject: str
    what: str
    before: str
    after: str
    reason: str

    def cells(self) -> list[str]:
        """The row as texts."""
        return [self.subject, self.what, self.before, self.after, self.reason]


HEADER = ["part", "what", "before", "after", "why"]


@dataclass
class Changes:
    """The rows of one import, in the order in which they arose; equal rows count once."""

    rows: list[Change] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)

    def copy(self) -> Changes:
        """The same so far, of which more rows are made."""
        return Changes(list(self.rows), list(self.left_out))

    def drop(self, subjects: Collection[str]) -> None:
        """Drop all rows about parts that are not there."""
        self.rows = [row for row in self.rows if row.subject not in subjects]

    def note(self, subject: str, what: str, before: str, after: str, reason: str) -> None:
        """Add a row."""
        row = Change(subject, what, before, after, reason)
        if row not in self.rows:
            self.rows.append(row)

    def forget(self, subject: str, what: str, beginning: str) -> None:
        """Drop rows that another row is about to replace."""
        self.rows = [
            row
            for row in self.rows
            if not (
                row.subject == subject and row.what == what and row.before.startswith(beginning)
            )
        ]

    def leave_out(self, what: str) -> None:
        """Note something of the source that has no counterpart."""
        if what not in self.left_out:
            self.left_out.append(what)

    def lines(self) -> list[str]:
        """The table as lines of text, for the comment of a file."""
        rows = [HEADER, *(row.cells() for row in self.rows[:MOST_ROWS])]
        lines = list(_aligned(rows)) if self.rows else ["nothing was changed"]
        if len(self.rows) > MOST_ROWS:
            lines.append(f"and {len(self.rows) - MOST_ROWS} more changes")
        if self.left_out:
            lines.append("left out: " + "; ".join(self.left_out))
        return lines


def _aligned(rows: Sequence[Sequence[str]]) -> Iterable[str]:
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEADER) - 1)]
    for row in rows:
        padded = (cell.ljust(width) for cell, width in zip(row, widths, strict=False))
        yield " | ".join([*padded, row[-1]]).rstrip()
