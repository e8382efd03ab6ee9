"""Writing the index of a folder of packaged tasks, which `summaries` reads."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.suites import suites_of
from taskbuilder.schema.summaries import checksum, read_summary


def index_text(folder: Path) -> str:
    """What the index of a folder of packaged tasks should hold."""
    catalogue = Catalogue()
    index = {
        entry.file.stem: {
            "checksum": checksum(entry.file),
            **asdict(read_summary(entry, catalogue)),
            "suites": suites_of(entry, catalogue),
        }
        for entry in catalogue.tasks.values()
        if entry.root == folder
    }
    return json.dumps(index, indent=2, ensure_ascii=False) + "\n"
