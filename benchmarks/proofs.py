"""Prove the tasks of the library at full level, and keep what was measured.

    python benchmarks/proofs.py [TASK ...]
    taskbuilder validate --all --json > all.json && python benchmarks/proofs.py --from all.json
    python benchmarks/proofs.py --compare all.json

A task whose two files are those of its last proof is left out, unless it is named. The second form
keeps what a validation of whole suites has measured, of tasks whose files have not changed since.
The third compares the verdicts of such a validation, made on another machine, with those of the
proofs that are kept; it writes benchmarks/results/proofs_compared.json.
Each proof is written to benchmarks/results/proofs/TASK.json as soon as it is made, with the command
that makes it again, and with how the expert does the task; tasks/proofs.json, which `taskbuilder
list` shows, has a record of those that passed.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from statistics import median
from typing import Any

from machine import describe_machine

import taskbuilder
from taskbuilder import parallel_env
from taskbuilder._library import folder
from taskbuilder.expert import Expert
from taskbuilder.processes import cores
from taskbuilder.rollout.coordination import CoordinationMeter
from taskbuilder.schema.proofs import PROOFS, checksum, proof_of
from taskbuilder.validate.report import Progress, as_data
from taskbuilder.validate.runner import SEEDS, validate_task

RESULTS = Path(__file__).parent / "results" / "proofs"
COMPARED = RESULTS.with_name("proofs_compared.json")
RECORDS = folder("tasks") / PROOFS
_NUMBERS = re.compile(r"\[\s+(?:(?:-?[0-9][-+.e0-9]*|null),?\s+)+\]")
FIRST_SEED, EPISODES = 3_300_000, 10
"""Episodes of the expert for the figures on how the task is done."""

LEAST_SUCCESS = 0.98
"""Success rate of the expert in the worst variation that the library asks for."""


def write(file: Path, data: Any) -> None:
    """Write data as JSON, lists of numbers in one line."""
    text = json.dumps(data, indent=1, ensure_ascii=False, sort_keys=True)
    text = _NUMBERS.sub(lambda found: " ".join(found[0].split()), text)
    file.write_text(text + "\n", encoding="utf-8")


def told(name: str) -> Progress:
    """Prints what is being checked: a proof takes minutes."""

    def show(seeds: Iterable[int], label: str) -> Iterable[int]:
        print(f"{name}: {label}", flush=True)
        return seeds

    return show


def how_it_is_done(name: str) -> dict[str, Any]:
    """Medians over episodes of the expert, up to success: its steps, and coordination."""
    with closing(parallel_env(name)) as env, closing(Expert(env)) as expert:
        played = []
        for seed in range(FIRST_SEED, FIRST_SEED + EPISODES):
            meter = CoordinationMeter()
            rollout = expert.play(seed, watch=meter)
            played.append((rollout, meter.coordination(rollout.first_success)))
        robots = env.possible_agents
    figures = [coordination for _, coordination in played]

    def middle(values: Iterable[float]) -> float:
        return round(median(values), 3)

    return {
        "episodes": EPISODES,
        "stages": len(env.task.file.spec.expert),
        "steps": middle(rollout.first_success or rollout.steps for rollout, _ in played),
        "moving_together": middle(one.moving for one in figures),
        "touching_together": middle(one.touching for one in figures),
        "waiting": {robot: middle(one.waiting[robot] for one in figures) for robot in robots},
        "path_m": {robot: middle(one.path[robot] for one in figures) for robot in robots},
    }


def prove(name: str, jobs: int) -> bool:
    """Prove a task, and keep the result."""
    report = validate_task(name, seeds=SEEDS, jobs=jobs, progress=told(name))
    (data,) = as_data([report])["tasks"]
    data["making"]["command"] = f"taskbuilder validate {name}"
    return keep(data)


def keep(data: dict[str, Any]) -> bool:
    """Keep a proof, given as the task's part of ``--json``."""
    name, making = data["task"], dict(data["making"])
    whole = making["level"] == "full" and not making.get("only") and making["seeds"] >= SEEDS
    assert whole, f"{name}: a proof has all families of checks, with {SEEDS} seeds"
    summed = making.pop("checksum")
    if summed != checksum(taskbuilder.catalogue().tasks[name]):
        print(f"{name}: its files have changed since; the proof is not kept")
        return False
    file = RESULTS / f"{name}.json"
    about = {"making": {**making, "machine": describe_machine()}, "checksum": summed}
    before = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    known = before.get("expert") if before.get("checksum") == summed else None
    about |= {"expert": known or how_it_is_done(name)} if data["ok"] else {}
    write(file, {**data, **about})
    records = json.loads(RECORDS.read_text(encoding="utf-8")) if RECORDS.exists() else {}
    records.pop(name, None)
    if data["ok"]:
        records[name] = {
            "date": making["date"],
            "version": making["versions"]["taskbuilder"],
            "seeds": making["seeds"],
            "checksum": summed,
        }
    write(RECORDS, records)
    for finding in data["findings"]:
        print(finding)
    rates = [check["value"] for check in data["checks"] if check["code"] == "TB531"]
    short = [rate for rate in rates if rate is not None and rate < LEAST_SUCCESS]
    for rate in short:
        print(
            f"{name}: its expert succeeds in {rate:.0%}; the library asks for {LEAST_SUCCESS:.0%}"
        )
    return data["ok"] and not short


def compare(tasks: list[dict[str, Any]]) -> int:
    """Compare verdicts with those of the proofs that are kept, of the same files."""
    checks, differ, other_returns = 0, [], 0
    for data in tasks:
        stored = json.loads((RESULTS / f"{data['task']}.json").read_text(encoding="utf-8"))
        assert stored["checksum"] == data["making"]["checksum"], f"{data['task']} has changed"
        verdicts, others = verdicts_of(stored), verdicts_of(data)
        checks += len(stored["checks"])
        differ += [f"{data['task']}: {'; '.join(each)}" for each in sorted(verdicts ^ others)]
        other_returns += stored["probes"] != data["probes"]
    found = {
        "command": "python benchmarks/proofs.py --compare all.json",
        "machine": describe_machine(),
        "tasks": len(tasks),
        "checks": checks,
        "differ": differ,
        "other_returns": other_returns,
    }
    write(COMPARED, found)
    print(f"{checks} checks of {len(tasks)} tasks: {len(differ)} differ")
    return int(bool(differ))


def verdicts_of(data: dict[str, Any]) -> set[tuple[str, ...]]:
    """Each check with its verdict, and each finding with its place."""
    checks = {(c["family"], c["code"], c["name"], str(c["ok"])) for c in data["checks"]}
    return checks | {("finding", f["code"], f["severity"], f["path"]) for f in data["findings"]}


def main() -> int:
    """Prove the tasks named on the command line, or those whose files have changed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", metavar="TASK")
    parser.add_argument("--from", type=Path, dest="file", help="what validate --json has printed")
    parser.add_argument("--compare", type=Path, help="compare what it has printed elsewhere")
    parser.add_argument("--jobs", type=int, default=cores())
    asked = parser.parse_args()
    RESULTS.mkdir(parents=True, exist_ok=True)
    if asked.compare:
        return compare(json.loads(asked.compare.read_text(encoding="utf-8"))["tasks"])
    entries = taskbuilder.catalogue().tasks
    if asked.file:
        tasks = json.loads(asked.file.read_text(encoding="utf-8"))["tasks"]
        kept = [keep(data) for data in tasks]
        return int(not all(kept))
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
