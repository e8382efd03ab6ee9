"""Versions of packaged tasks: a changed scene, reward or success needs a new number.

``versions.json`` beside packaged task files has every version of each task: since when there is it,
what changed, and the digest of what an episode follows from. This is what the task file says but
for its summary and its expert, the code of the description, and the files of the objects. Comments
and docstrings do not count. Robots do not count either, because they belong to no task; results
name the digests of their files.
"""

from __future__ import annotations

import ast
import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import TypedDict

from taskbuilder.digests import digest_of
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import TaskFile, read_task
from taskbuilder.sources import digests_of_objects

VERSIONS = "versions.json"

_APART = ("version", "summary", "cooperation", "expert")
"""Keys of a task file that change neither scene, reward nor success."""


class TaskVersion(TypedDict):
    """A version of a task.

    Attributes:
        content: The digest of its content.
        since: The day on which it was recorded, such as ``2026-11-30``.
        change: What changed, in a line; empty until somebody has written it.
    """

    content: str
    since: str
    change: str


Versions = Mapping[str, Mapping[str, TaskVersion]]
"""Every version of each task, by its name and number: ``{"handover": {"1": …}}``."""

FIRST = "first version"


def content_digest(file: TaskFile) -> str:
    """SHA-256 of what the episodes of a task follow from, robots and library apart."""
    said = {key: value for key, value in file.source.data.items() if key not in _APART}
    code = file.entry.description_file.read_text(encoding="utf-8")
    parts = {"file": said, "code": _without_texts(code), "objects": digests_of_objects(file)}
    return digest_of(parts)


def _without_texts(code: str) -> str:
    """Python code without comments and docstrings, however it is laid out."""
    tree = ast.parse(code)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            node.body = [each for each in node.body if not _is_text(each)] or [ast.Pass()]
    return ast.unparse(tree)


def _is_text(node: ast.stmt) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def read_versions(folder: Path) -> Versions:
    """The versions that a folder of packaged tasks records; none if it records none.

    Raises:
        OSError: The file cannot be read.
        ValueError: It is no JSON.
    """
    file = folder / VERSIONS
    if not file.is_file():
        return {}
    versions: Versions = json.loads(file.read_text(encoding="utf-8"))
    return versions


def history(versions: Versions, task: str) -> list[tuple[int, TaskVersion]]:
    """The versions of a task, from the first to that of today.

    Raises:
        ValueError: Nobody has written what changed in a version.
    """
    ordered = sorted(
        ((int(number), version) for number, version in versions.get(task, {}).items()),
        key=lambda each: each[0],
    )
    for number, version in ordered:
        if not version["change"]:
            raise ValueError(
                f"tasks/{VERSIONS}: say what changed in version {number} of {task}, in one line "
                'as the value of "change"'
            )
    return ordered


def versions_text(folder: Path, catalogue: Catalogue | None = None) -> str:
    """What the file should hold: versions that are new are added, and none is changed.

    What changed in a version after the first is left empty, for somebody to write.

    Args:
        folder: The folder of the tasks.
        catalogue: Where they are looked up; by default among the installed packages.
    """
    catalogue = catalogue or Catalogue()
    versions = {name: dict(each) for name, each in read_versions(folder).items()}
    for entry in catalogue.tasks.values():
        if entry.root == folder:
            file = read_task(entry, catalogue)
            recorded, number = versions.setdefault(file.spec.task, {}), str(file.spec.version)
            if number not in recorded:
                recorded[number] = {
                    "content": content_digest(file),
                    "since": datetime.now(UTC).date().isoformat(),
                    "change": "" if recorded else FIRST,
                }
    return json.dumps(versions, indent=1, sort_keys=True) + "\n"
