"""CPU-seconds of a full proof by families of checks, today and in an earlier checkout.

    git worktree add /tmp/earlier 00acfa82~1
    python benchmarks/proof_times.py --before /tmp/earlier [TASK ...]

The tasks are proved one after the other, each in a process of its own, first with the earlier
checkout and then with this one. The time is that of the processor and not of the clock, and
includes the processes that replay episodes. It includes loading, but not the start of Python.
Results go to benchmarks/results/proof_times.json, a task at a time, and from there to
docs/validation.md (`make docs`).
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "benchmarks" / "results" / "proof_times.json"
TASKS = ("reach", "pick_push_place", "collaborative_lift", "handover")
"""Tasks that are proved by default: the library's shortest, and the paper's three."""

PROOF = """
import json, os, sys
from unittest import mock
import taskbuilder.validate.runner as runner
def spent():  # by this process, and by those that it has started and waited for
    return sum(os.times()[:4])
with mock.patch.object(runner.time, "perf_counter", spent):
    report = runner.validate_task(sys.argv[1], apart=False)
families = {family.name: round(family.seconds, 1) for family in report.families}
print(json.dumps({"ok": report.ok, "families": families}))
"""


def proved(task: str, checkout: Path) -> dict[str, Any]:
    """Prove a task with the modules of a checkout."""
    alone = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", PROOF, task],
        cwd=checkout,
        env={**os.environ, **alone, "PYTHONPATH": str(checkout)},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return json.loads(done.stdout.splitlines()[-1])


def revision(checkout: Path) -> str:
    """The commit of a checkout."""
    asked = ["git", "-C", str(checkout), "rev-parse", "--short=8", "HEAD"]
    return subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()


def main() -> None:
    """Prove the tasks, and write what each family took."""
    from machine import describe_machine

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", metavar="TASK")
    parser.add_argument("--before", type=Path, required=True, help="the earlier checkout")
    asked = parser.parse_args()
    kept: dict[str, Any] = json.loads(OUT.read_text("utf-8")) if OUT.exists() else {"tasks": {}}
    for task in asked.tasks or TASKS:
        before, now = (proved(task, checkout) for checkout in (asked.before.resolve(), ROOT))
        kept["tasks"][task] = {"before": before, "now": now}
        times = (sum(side["families"].values()) for side in (before, now))
        print(task, *(f"{seconds:.0f} s" for seconds in times), flush=True)
        kept |= {
            "command": "python benchmarks/proof_times.py --before EARLIER",
            "before": revision(asked.before),
            "machine": describe_machine(),
        }
        OUT.write_text(json.dumps(kept, indent=1, sort_keys=True) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
