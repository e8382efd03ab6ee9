"""Which packaged tasks have been proved, and whether their files have changed since.

``proofs.json`` beside packaged task files has a record of the full proof of each, with a checksum
of the task file and its description.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any
from zlib import crc32  # SHA-256 would take longer to import than all tasks to read

from taskbuilder.schema.catalogue import CatalogueEntry

PROOFS = "proofs.json"


@dataclass(frozen=True)
class Proof:
    """A full proof of a task.

    Attributes:
        date: When it was made, in UTC.
        version: Version of taskbuilder.
        seeds: Seeds per variation.
        checksum: Checksum of the task file and the description that were proved.
        current: Whether these files are still the same.
    """

    date: str
    version: str
    seeds: int
    checksum: str
    current: bool


def proof_of(entry: CatalogueEntry) -> Proof | None:
    """The proof of a packaged task, or None if there is none."""
    record = _read(entry.root).get(entry.file.stem) if entry.trusted else None
    return Proof(**record, current=record["checksum"] == checksum(entry)) if record else None


def checksum(entry: CatalogueEntry) -> str:
    """Checksum of a task's two files."""
    text = b"".join(
        file.read_bytes() for file in (entry.file, entry.description_file) if file.is_file()
    )
    return f"{crc32(text):08x}"


@cache
def _read(folder: Path) -> Mapping[str, Any]:
    try:
        proofs: Mapping[str, Any] = json.loads((folder / PROOFS).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return proofs
