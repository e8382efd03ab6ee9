"""What `taskbuilder list` says of a task, and the index that saves reading every file for it.

``index.json`` beside packaged task files holds what each said when the index was written, with the
checksum that the file had then. A file that has changed since is read instead.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any
from zlib import crc32  # SHA-256 would take longer to import than all tasks to read

from taskbuilder.errors import FileError
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry

INDEX = "index.json"


@dataclass(frozen=True)
class TaskSummary:
    """A task in a line.

    Attributes:
        robots: The model of each robot by its name; none where the file has errors.
        objects: The names of its objects, furniture included.
        episode_steps: Control steps of an episode, or None where the file has errors.
        summary: What the task file says of itself.
        version: The number of its version.
    """

    robots: Mapping[str, str] = field(default_factory=dict)
    objects: tuple[str, ...] = ()
    episode_steps: int | None = None
    summary: str = "(has errors)"
    version: int = 1


def summarize(entry: CatalogueEntry, catalogue: Catalogue) -> TaskSummary:
    """What is said of a task: from the index beside it, or else from its file."""
    indexed = _read_index(entry.root).get(entry.file.stem)
    if entry.trusted and indexed and indexed["checksum"] == checksum(entry.file):
        keys = ("robots", "episode_steps", "summary", "version")
        known = {key: indexed[key] for key in keys if key in indexed}
        return TaskSummary(objects=tuple(indexed["objects"]), **known)
    return read_summary(entry, catalogue)


def indexed_suites(entry: CatalogueEntry) -> list[str] | None:
    """The names of the suites that a packaged task is in; None if there is no index."""
    indexed = _read_index(entry.root).get(entry.file.stem) if entry.trusted else None
    return list(indexed["suites"]) if indexed else None


def read_summary(entry: CatalogueEntry, catalogue: Catalogue) -> TaskSummary:
    """What the file of a task says, whatever the index has."""
    from taskbuilder.schema.load import read_task  # takes longer than all else that `list` does

    try:
        spec = read_task(entry, catalogue).spec
    except FileError:
        return TaskSummary()
    robots = {name: robot.model for name, robot in spec.scene.robots.items()}
    return TaskSummary(
        robots, tuple(spec.scene.objects), spec.timing.episode_steps, spec.summary, spec.version
    )


@cache
def _read_index(folder: Path) -> Mapping[str, Any]:
    try:
        index: Mapping[str, Any] = json.loads((folder / INDEX).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return index


def checksum(file: Path) -> str:
    """The checksum by which the index knows whether a file has changed."""
    return f"{crc32(file.read_bytes()):08x}"
