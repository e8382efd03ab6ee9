"""The manifest of what is shared: its kind, its name, and the SHA-256 of every file.

```text
tasks/handover.json           the manifest
tasks/handover/               the files, as they are used
datasets/demos.json
datasets/demos/
```
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskbuilder.arrays import StoreError
from taskbuilder.carried import digest_of_task
from taskbuilder.digests import digest_of
from taskbuilder.errors import UsageError
from taskbuilder.untrusted import parse_json, read_within
from taskbuilder.wording import excerpt

FOLDERS: Mapping[str, str] = {
    "task": "tasks",
    "data set": "datasets",
    "policy": "policies",
    "certificate": "certificates",
}
"""The folder of each kind."""

FORMAT = 1
LARGEST_MANIFEST = 32 << 20

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")
_DIGEST = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class Manifest:
    """What is shared.

    Attributes:
        kind: ``task``, ``data set``, ``policy`` or ``certificate``.
        name: Its name, which is that of its folder.
        about: Further properties: ``task``, ``task_version``; of a task, also ``file`` and
            ``folders``, as `CarriedTask` has them.
        files: SHA-256 of each file, by its path in the folder.
    """

    kind: str
    name: str
    about: Mapping[str, Any]
    files: Mapping[str, str]

    @property
    def folder(self) -> str:
        """Path of the folder of its files."""
        return f"{FOLDERS[self.kind]}/{self.name}"

    @property
    def file(self) -> str:
        """Path of the manifest itself."""
        return f"{self.folder}.json"

    @property
    def digest(self) -> str:
        """SHA-256 of all files; of a task, the one that it is trusted by in data sets, too."""
        if self.kind == "task":
            return digest_of_task(self.about["file"], self.about["folders"], self.files)
        return digest_of(dict(self.files))

    @property
    def label(self) -> str:
        """What it is, such as ``task handover, version 2``."""
        version = f", version {self.about['task_version']}" if self.kind == "task" else ""
        return f"{self.kind} {self.name}{version}"

    def content(self) -> bytes:
        """The content of its file."""
        data = {
            "kind": f"taskbuilder {self.kind}",
            "format": FORMAT,
            "name": self.name,
            "about": dict(self.about),
            "sha256": self.digest,
            "files": dict(sorted(self.files.items())),
        }
        return (json.dumps(data, indent=1) + "\n").encode()


def check_name(name: str) -> None:
    """Refuse a name that can be no folder everywhere.

    Raises:
        UsageError: So it is.
    """
    if not _NAME.fullmatch(name) or name.endswith((".json", ".")):
        raise UsageError(
            f'"{excerpt(name)}" is no name to share by; letters, digits, ".", "_" and "-", the '
            "first a letter or digit, and no .json at the end"
        )


def read_manifest(root: Path, kind: str, name: str) -> Manifest:
    """Read a manifest, without trusting its contents.

    Args:
        root: Where the folders of all kinds are.
        kind: The kind.
        name: The name.

    Raises:
        StoreError: It is damaged, or of another version.
        OSError: It cannot be read, or is a link.
    """
    file = f"{FOLDERS[kind]}/{name}.json"
    try:
        data = parse_json(read_within(root, file, LARGEST_MANIFEST))
    except ValueError as error:
        raise StoreError(f"{file} is damaged ({error})") from None
    if not isinstance(data, dict) or data.get("kind") != f"taskbuilder {kind}":
        raise StoreError(f"{file} is no manifest of a {kind}")
    if data.get("format") != FORMAT:
        raise StoreError(
            f"{file} has format {excerpt(data.get('format'))}; this version reads {FORMAT}"
        )
    if wrong := next(_problems(data, kind, name), None):
        raise StoreError(f"{file} is damaged: {wrong}")
    manifest = Manifest(kind, name, data["about"], data["files"])
    if data.get("sha256") != manifest.digest:
        raise StoreError(f"{file} is damaged: its sha256 is not that of its files")
    return manifest


def _problems(data: Mapping[str, Any], kind: str, name: str) -> Iterator[str]:
    """What is wrong with a manifest."""
    about, files = data.get("about"), data.get("files")
    if data.get("name") != name:
        yield f"its name is {excerpt(data.get('name'))}"
    if not isinstance(about, dict) or type(about.get("task_version", 1)) is not int:
        yield "it has no about"
    elif kind == "task" and not _is_task(about, files):
        yield "its about names no task file among its files"
    if not isinstance(files, dict) or not files:
        yield "it lists no files"
        return
    yield from (f"{excerpt(path)} leads to another folder" for path in files if not _within(path))
    for path, digest in files.items():
        if not isinstance(digest, str) or not _DIGEST.fullmatch(digest):
            yield f"{excerpt(path)} has no SHA-256"


def _is_task(about: Mapping[str, Any], files: Any) -> bool:
    folders = about.get("folders")
    named = isinstance(folders, list) and all(isinstance(each, str) for each in folders)
    return (
        named
        and all(each == "." or _within(each) for each in folders or ())
        and isinstance(files, dict)
        and isinstance(about.get("file"), str)
        and about["file"] in files
        and type(about.get("task_version")) is int
    )


def _within(path: str) -> bool:
    return not any(part in ("", ".", "..") for part in path.split("/")) and "\\" not in path
