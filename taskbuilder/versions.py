"""Versions of packaged tasks: a changed scene, reward or success needs a new number.

``versions.json`` beside packaged task files has, for every version of each task, the digest of what
an episode follows from: what the task file says but for its summary and its expert, the code of the
description, and the files of the objects. Comments and docstrings do not count. Robots do not count
either, because they belong to no task; results name the digests of their files.
"""

from __future__ import annotations

import ast
import json
from collections.abc import Mapping
from pathlib import Path

from taskbuilder.digests import digest_of
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import TaskFile, read_task
from taskbuilder.sources import digests_of_objects

VERSIONS = "versions.json"

_APART = ("version", "summary", "cooperation", "expert")
"""Keys of a task file that change neither scene, reward nor success."""

Versions = Mapping[str, Mapping[str, str]]
"""The digest of every version of each task: ``{"handover": {"1": "9f86…"}}``."""


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


def versions_text(folder: Path, catalogue: Catalogue | None = None) -> str:
    """What the file should hold: versions that are new are added, and none is changed.

    Args:
        folder: The folder of the tasks.
        catalogue: Where they are looked up; by default among the installed packages.
    """
    catalogue = catalogue or Catalogue()
    versions = {name: dict(each) for name, each in read_versions(folder).items()}
    for entry in catalogue.tasks.values():
        if entry.root == folder:
            file = read_task(entry, catalogue)
            number = str(file.spec.version)
            versions.setdefault(file.spec.task, {}).setdefault(number, content_digest(file))
    return json.dumps(versions, indent=1, sort_keys=True) + "\n"
