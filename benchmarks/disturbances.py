"""What is left of policies of the zoo under each disturbance, one by one.

    python benchmarks/disturbances.py [POLICY...] [--axis AXIS]

Plays each policy in 50 episodes without a disturbance, and in the same 50 under each axis at its
level by default, or under one axis, and writes what came of it to
benchmarks/results/disturbances.json. Policies and axes that are not named stay as they are there.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from machine import describe_machine

from taskbuilder.schema.disturbances import AXES

RESULTS = Path(__file__).parent / "results" / "disturbances.json"
POLICIES = ("zoo:handover/demos", "zoo:handover/cloned", "expert:handover")
COMMAND = "taskbuilder evaluate POLICY --disturb AXIS --seed 3000000 --episodes 50 --json"
KEPT = ("success_rate", "interval", "success_at_end_rate", "return")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("policies", nargs="*", metavar="POLICY", default=POLICIES)
    parser.add_argument("--axis", choices=(*AXES, "all"), default="all")
    arguments = parser.parse_args()
    for policy in arguments.policies:
        known = json.loads(RESULTS.read_text())["policies"] if RESULTS.exists() else {}
        plain, rows = measured(policy, arguments.axis)
        rows = {**known.get(policy, {}).get("disturbances", {}), **rows}
        ordered = {axis: rows[axis] for axis in AXES if axis in rows}
        known[policy] = {"undisturbed": plain, "disturbances": ordered}
        content = {"command": COMMAND, **describe_machine(), "policies": known}
        RESULTS.write_text(json.dumps(content, indent=1) + "\n")
        print(f"{policy}: {', '.join(rows)}", flush=True)
    return 0


def measured(policy: str, axis: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """What is kept of an evaluation: without a disturbance, and by axis."""
    words = COMMAND.replace("POLICY", policy).replace("AXIS", axis).split()
    ran = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, check=True)
    found = json.loads(ran.stdout)
    rows = {
        row["axis"]: {
            "level": row["level"],
            **(kept(row) if row["applies"] else {"why_not": row["why_not"]}),
        }
        for row in found["disturbances"]
    }
    return kept(found["undisturbed"]), rows


def kept(results: dict[str, Any]) -> dict[str, Any]:
    """The figures of an evaluation, and the seeds of the episodes without success."""
    failed = [each["seed"] for each in results["episodes"] if not each["success"]]
    return {
        "episodes": len(results["episodes"]),
        **{name: results[name] for name in KEPT},
        "failed_seeds": failed,
    }


if __name__ == "__main__":
    sys.exit(main())
