"""Checkpoints of a training run that survive a crash at any moment.

A checkpoint is one file that is written under a temporary name, synced and renamed. Transitions of
the replay buffer are in separate files, each with those added since the previous checkpoint. So a
checkpoint is as fast at the end of a run as at its beginning. Each names the files that it needs.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskbuilder.arrays import Arrays, StoreError, read_arrays, write_arrays
from taskbuilder.learn.replay import Replay
from taskbuilder.policies.zoo import CHECKPOINTS

FOLDER = CHECKPOINTS
KEPT = 2
"""Number of checkpoints to keep; if the last one is damaged, the one before it is used."""

_KIND, _ROWS_KIND = "checkpoint", "transitions"
_NAME = re.compile(r"step-(\d{9})\.npz")


@dataclass(frozen=True)
class Checkpoint:
    """The state that a run resumes from.

    Attributes:
        step: Control steps so far.
        arrays: The state of the learner.
        counters: Everything else: states of generators, lengths of logs, ...
    """

    step: int
    arrays: Arrays
    counters: Mapping[str, Any]


class Checkpoints:
    """The checkpoints of a run.

    Args:
        run: The run's folder.
    """

    def __init__(self, run: Path) -> None:
        self._folder = run / FOLDER
        self._files: list[tuple[str, int, int]] = []  # name, rows added before it and after it
        self._needed: list[set[str]] = []  # by the last checkpoints, each

    def save(self, checkpoint: Checkpoint, memories: Mapping[str, Replay]) -> None:
        """Write a checkpoint, and remove files that are no longer needed.

        Raises:
            OSError: It cannot be written; earlier checkpoints are still there.
        """
        self._folder.mkdir(exist_ok=True)
        files = {name: self._save_rows(name, memory) for name, memory in memories.items()}
        about = {
            "kind": _KIND,
            "step": checkpoint.step,
            "counters": dict(checkpoint.counters),
            "rows": files,
        }
        name = self._folder / f"step-{checkpoint.step:09d}.npz"
        write_arrays(name, checkpoint.arrays, about)
        self._tidy({str(entry[0]) for parts in files.values() for entry in parts})

    def _tidy(self, needed: set[str]) -> None:
        """Remove files that no kept checkpoint needs."""
        for _, path in self._files_by_step()[KEPT:]:
            path.unlink()
        self._needed = [*self._needed, needed][-KEPT:]
        if len(self._needed) == KEPT:  # else there may be one from before that needs more
            for name, _, _ in self._files:
                if not any(name in names for names in self._needed):
                    (self._folder / name).unlink(missing_ok=True)

    def _save_rows(self, name: str, memory: Replay) -> list[list[Any]]:
        """Write rows that are in no file yet; return all files whose rows are still in memory."""
        stored = [entry for entry in self._files if entry[0].startswith(f"{name}-")]
        saved = max((entry[2] for entry in stored), default=0)
        if memory.added > saved:
            file = f"{name}-{saved:09d}-{memory.added:09d}.npz"
            write_arrays(self._folder / file, {"rows": memory.since(saved)}, {"kind": _ROWS_KIND})
            stored.append((file, saved, memory.added))
            self._files.append(stored[-1])
        return [list(entry) for entry in stored if entry[2] > memory.added - memory.capacity]

    def load(self, memories: Mapping[str, Replay]) -> Checkpoint | None:
        """Read the newest undamaged checkpoint, and its transitions into the memories.

        Returns:
            The checkpoint, or None if there is none.

        Raises:
            StoreError: There are checkpoints, and all of them are damaged.

        Warns:
            UserWarning: Newer ones are damaged.
        """
        troubles = []
        for _, path in self._files_by_step():
            try:
                arrays, about = read_arrays(path, _KIND)
                rows = {name: self._read_rows(about["rows"][name]) for name in memories}
            except (StoreError, OSError) as error:
                troubles.append(str(error))
                continue
            for name, memory in memories.items():
                self._fill(memory, rows[name], about["rows"][name])
            if troubles:
                what = f"{'; '.join(troubles)}; training goes on from step {about['step']}"
                warnings.warn(what, stacklevel=2)
            return Checkpoint(about["step"], arrays, about["counters"])
        if troubles:
            raise StoreError(f"no checkpoint is whole: {'; '.join(troubles)}")
        return None

    def _read_rows(self, files: list[list[Any]]) -> list[Any]:
        return [read_arrays(self._folder / name, _ROWS_KIND)[0]["rows"] for name, *_ in files]

    def _fill(self, memory: Replay, parts: list[Any], files: list[list[Any]]) -> None:
        memory.added = files[0][1] if files else 0
        for rows in parts:
            memory.add(rows)
        self._files += [(str(name), int(first), int(last)) for name, first, last in files]

    def _files_by_step(self) -> list[tuple[int, Path]]:
        """Checkpoints by step, the newest first, without unfinished ones."""
        if not self._folder.is_dir():
            return []
        matches = [(_NAME.fullmatch(path.name), path) for path in self._folder.iterdir()]
        return sorted(((int(m[1]), path) for m, path in matches if m), reverse=True)
