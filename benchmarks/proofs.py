"""Prove the tasks of the library at full level, and keep what was measured.

    python benchmarks/proofs.py [TASK ...]

A task whose two files are those of its last proof is left out, unless it is named. Each proof is
written to benchmarks/results/proofs/TASK.json as soon as it is made, with the command that makes it
again; tasks/proofs.json, which `taskbuilder list` shows, has a record of those that passed.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from machine import describe_machine

import taskbuilder
from taskbuilder._library import folder
from taskbuilder.jobs import cores
from taskbuilder.schema.proofs import PROOFS, checksum, proof_of
from taskbuilder.validate.report import as_data
from taskbuilder.validate.runner import SEEDS, validate_task

RESULTS = Path(__file__).parent / "results" / "proofs"
RECORDS = folder("tasks") / PROOFS


def write(file: Path, data: Any) -> None:
    """Write data as JSON."""
    text = json.dumps(data, indent=1, ensure_ascii=False, sort_keys=True)
    file.write_text(text + "\n", encoding="utf-8")


def prove(name: str, jobs: int) -> bool:
    """Prove a task, and keep the result."""
    entry = taskbuilder.catalogue().tasks[name]
    summed = checksum(entry)
    report = validate_task(name, seeds=SEEDS, jobs=jobs)
    assert report.making is not None
    (data,) = as_data([report])["tasks"]
    command = f"taskbuilder validate {name}"
    making = {**asdict(report.making), "command": command, "machine": describe_machine()}
    write(RESULTS / f"{name}.json", {**data, "making": making, "checksum": summed})
    records = json.loads(RECORDS.read_text(encoding="utf-8")) if RECORDS.exists() else {}
    records.pop(name, None)
    if report.ok and not report.skipped:
        records[name] = {
            "date": report.making.date,
            "version": taskbuilder.__version__,
            "seeds": report.making.seeds,
            "checksum": summed,
        }
    write(RECORDS, records)
    for finding in report.findings:
        print(finding)
    return report.ok


def main() -> int:
    """Prove what is asked for, or what has changed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", metavar="TASK")
    parser.add_argument("--jobs", type=int, default=cores())
    asked = parser.parse_args()
    RESULTS.mkdir(parents=True, exist_ok=True)
    entries = taskbuilder.catalogue().tasks
    proofs = {name: proof_of(entry) for name, entry in entries.items() if entry.trusted}
    changed = [name for name, proof in proofs.items() if proof is None or not proof.current]
    failed = 0
    for name in asked.tasks or changed:
        ok = prove(name, asked.jobs)
        print(f"{name}: {'proved' if ok else 'NOT proved'}", flush=True)
        failed += not ok
    return min(failed, 1)


if __name__ == "__main__":
    raise SystemExit(main())
