"""Task files that tests write, and the names of those of the library."""

from __future__ import annotations

from pathlib import Path

from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import TaskFile, read_task

HEAD = "task: made\nsummary: A task made for a test.\n"
NAMES = ("handover", "pick_push_place", "collaborative_lift")


def read(folder: Path, text: str) -> TaskFile:
    """A task file of the given text, without its first two lines, in a folder."""
    path = folder / "made.yaml"
    path.write_text(HEAD + text, encoding="utf-8")
    catalogue = Catalogue.discover()
    return read_task(catalogue.task(str(path)), catalogue)
