"""The table of imported files of others."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from taskbuilder.reference.markdown import table

RESULTS = Path(__file__).parents[2] / "benchmarks" / "results" / "imports.json"


def files(_: str) -> str:
    """Each file before and after, and how many of them are imported."""
    data = json.loads(RESULTS.read_text(encoding="utf-8"))
    head = ["robot", "`robots check` of the file", "`robots import`", "arm", "gripper", "seconds"]
    rows = [_row(row) for row in data["files"]]
    said = f"{data['imported']} of {data['of']} files are imported and can be loaded."
    return f"{said}\n\n{table(head, rows)}"


def _row(row: dict[str, Any]) -> list[str]:
    stroke = row.get("stroke_mm")
    good = row["result"] == "ok"
    return [
        row["name"],
        _plain(row["before"]) or "–",
        "ok" if good else _plain(row["result"]),
        _arms(row) if row.get("arm") else "–",
        f"{row['fingers']} fingers, {stroke} mm" if stroke else "–",
        f"{row['cpu_seconds']:g}" if "cpu_seconds" in row else "–",
    ]


def _arms(row: dict[str, Any]) -> str:
    several = f"{row['arms']} × " if row.get("arms", 1) > 1 else ""
    return f"{several}{row['arm']} joints"


def _plain(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")
