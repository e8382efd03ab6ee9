"""Logging of a run to CSV tables and TensorBoard."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

BOARD = "tensorboard"
"""Folder of a run for TensorBoard."""

TABLES = ("episodes", "evaluations", "updates")


class RunLogger:
    """Appends rows to CSV files, and flushes each row.

    Args:
        folder: Folder of the run.
        lengths: Lengths of the tables in bytes at the checkpoint of a resumed run. Later rows are
            cut off, because their steps are repeated.
        step: Control step at which the run resumes.
    """

    def __init__(self, folder: Path, lengths: Mapping[str, int], step: int) -> None:
        self._folder = folder
        for name in TABLES:
            path = folder / f"{name}.csv"
            if path.exists():
                os.truncate(path, lengths.get(name, 0))
        self._board = _tensorboard(folder, step)

    def add(self, table: str, step: int, row: Mapping[str, float | int | str]) -> None:
        """Add a row; all rows of a table have the same keys.

        Raises:
            OSError: It cannot be written.
        """
        path = self._folder / f"{table}.csv"
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        if not path.exists() or not path.stat().st_size:
            writer.writerow(["step", *row])
        writer.writerow([step, *(_short(value) for value in row.values())])
        with path.open("a", encoding="utf-8") as file:
            file.write(text.getvalue())
        for name, value in row.items():
            if self._board is not None and not isinstance(value, str):
                self._board.add_scalar(f"{table}/{name}", value, step)

    def lengths(self) -> dict[str, int]:
        """Current lengths of the tables on disk, in bytes."""
        paths = {name: self._folder / f"{name}.csv" for name in TABLES}
        for path in paths.values():
            if path.exists():
                with path.open("rb") as file:
                    os.fsync(file.fileno())
        return {name: path.stat().st_size for name, path in paths.items() if path.exists()}

    def close(self) -> None:
        """Flush and close the TensorBoard log."""
        if self._board is not None:
            self._board.close()


def _short(value: float | int | str) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _tensorboard(folder: Path, step: int) -> Any:
    """A writer for TensorBoard, or None if it is not installed."""
    try:
        from torch.utils.tensorboard import SummaryWriter
    except ImportError:
        return None
    return SummaryWriter(str(folder / BOARD), purge_step=step or None)
