"""Disturbances: their axes, and what is left of policies under each of them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from taskbuilder.reference.markdown import table
from taskbuilder.schema.disturbances import AXES, disturbance_text

FILE = Path(__file__).parents[2] / "benchmarks" / "results" / "disturbances.json"

READS = {
    None: "every policy and every baseline",
    "pictures": "policies that observe images",
    "colours": "policies that observe colour images",
    "positions": "policies that observe positions",
    "words": "policies that may read the instruction: those of servers, and your own",
}


def axes(_: str) -> str:
    """Every axis, with its levels and those to whom it applies."""
    rows = [
        [
            f"`{name}`",
            axis.help,
            f"{axis.level:g}{axis.measure}" if axis.has_levels else "none",
            f"{axis.bounds[0]:g} to {axis.bounds[1]:g}" if axis.has_levels else "",
            READS[axis.reads],
        ]
        for name, axis in AXES.items()
    ]
    return table(["axis", "what differs", "N by default", "N", "applies to"], rows)


def measured(_: str) -> str:
    """Success of each measured policy, without and with each disturbance."""
    found: Mapping[str, Any] = json.loads(FILE.read_text())["policies"]
    rows = [["none", *(_rate(each["undisturbed"]) for each in found.values())]]
    for axis in AXES:
        results = [each["disturbances"][axis] for each in found.values()]
        if any("success_rate" in result for result in results):
            name = f"`{disturbance_text(axis, results[0]['level'])}`"
            rows.append([name, *map(_rate, results)])
    return table(["disturbance", *(f"`{name}`" for name in found)], rows)


def _rate(result: Mapping[str, Any]) -> str:
    if "success_rate" not in result:
        return "does not apply"
    successes = round(result["success_rate"] * result["episodes"])
    low, high = (f"{100 * bound:.0f}" for bound in result["interval"])
    return f"{successes} of {result['episodes']} ({low}–{high} %)"
