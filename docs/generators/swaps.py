"""The tables of arms in tasks of their own reach, and in tasks that were written for others."""

from __future__ import annotations

import csv
import re
from collections import Counter
from pathlib import Path

from taskbuilder.reference.markdown import table

RESULTS = Path(__file__).parents[2] / "benchmarks" / "results" / "swaps.csv"
PROOFS = RESULTS.with_name("swap_proofs.csv")
OWN = "at its own reach: "
KINDS = ("pick_place", "handover")
_SHORT = re.compile(r"(?:within|off by) ([\d.]+) cm and (\d+)°")

Rows = list[dict[str, str]]


def own(_: str) -> str:
    """How often each arm succeeds in a task in proportion to its reach, and its proof."""
    rows, proofs = _rows(RESULTS), _proofs()
    head = ["robot", "Pick and Place", "Handover with itself"]
    lines = [
        [f"`{robot}`", *(_share(rows, proofs, OWN + kind, robot) for kind in KINDS)]
        for robot in sorted({row["robot"] for row in rows})
    ]
    return table(head, lines)


def swaps(_: str) -> str:
    """How often each arm succeeds in tasks of the library, and what it lacks."""
    rows = [row for row in _rows(RESULTS) if not row["task"].startswith(OWN)]
    proofs = _proofs()
    robots = sorted({row["robot"] for row in rows})
    lines = [
        [
            f"`{task}`",
            *(
                _cell(
                    [r for r in rows if (r["task"], r["robot"]) == (task, n)],
                    proofs.get((task, n)),
                )
                for n in robots
            ),
        ]
        for task in dict.fromkeys(row["task"] for row in rows)
    ]
    return table(["task", *(f"`{robot}`" for robot in robots)], lines)


def _rows(file: Path) -> Rows:
    with file.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def _proofs() -> dict[tuple[str, str], dict[str, str]]:
    """The proof of each task with each arm."""
    return {(row["task"], row["robot"]): row for row in _rows(PROOFS)}


def _share(rows: Rows, proofs: dict[tuple[str, str], dict[str, str]], task: str, robot: str) -> str:
    played = [row for row in rows if (row["task"], row["robot"]) == (task, robot)]
    solved = sum(row["success"] == "1" for row in played)
    return f"{solved} of {len(played)}{_proved(proofs.get((task, robot)))}"


def _proved(proof: dict[str, str] | None) -> str:
    """What follows the number of successes: proved, or the codes of what the proof found."""
    if proof is None:
        return ""
    return ", proved" if proof["proved"] == "1" else f", {proof['codes']}"


def _cell(rows: Rows, proof: dict[str, str] | None) -> str:
    """Successes, and why there are not more: what most episodes lack, and the most they lack."""
    if not rows:
        return "–"
    failed = [row for row in rows if row["success"] != "1"]
    solved = str(len(rows) - len(failed))
    if not failed:
        return f"{solved}{_proved(proof)}"
    cause = Counter(row["cause"] for row in failed).most_common(1)[0][0]
    if cause not in ("home", "out of reach"):
        return f"{solved}: {cause}"
    messages = [row["message"] for row in failed if row["cause"] == cause]
    found = [match.groups() for message in messages if (match := _SHORT.search(message))]
    off, angle = max((float(cm), int(degrees)) for cm, degrees in found)
    lack = f"{off:.0f} cm" if off >= 1.0 else f"{off:.1f} cm" if off else f"{angle}°"
    return f"{solved}: {'home ' if cause == 'home' else ''}{lack}"
