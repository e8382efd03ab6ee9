"""Arms in tasks that were written for others, and each arm in tasks of its own reach.

    python benchmarks/swaps.py
    python benchmarks/swaps.py --prove

plays Pick and Place and a handover in proportion to the reach of each arm (`reach_tasks.py`) for 20
seeds, and twelve tasks of the library for two arms, with both arms replaced, for 5 seeds. It writes
a line an episode to benchmarks/results/swaps.csv, where an interrupted run goes on. If an arm
cannot reach the home that a task gives it, nothing can be played, and the task has one line with
that finding.

The second form proves these tasks with those arms that succeeded in all episodes: it writes a line
a full proof to benchmarks/results/swap_proofs.csv, about two minutes each.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import closing
from pathlib import Path

from reach_tasks import KINDS, REACHES, write_task

from taskbuilder import load_task, parallel_env
from taskbuilder.errors import FileError
from taskbuilder.expert.script.player import Expert
from taskbuilder.task import Task
from taskbuilder.validate.runner import validate_task

RESULTS = Path(__file__).parent / "results" / "swaps.csv"
PROOFS = RESULTS.with_name("swap_proofs.csv")
FIELDS = ("task", "robot", "seed", "success", "cause", "message", "cpu_s")
PROOF_FIELDS = ("task", "robot", "proved", "success", "codes", "message", "seconds")
SEEDS, OWN_SEEDS = 5, 20
TASKS = (
    "handover",
    "collaborative_lift",
    "pick_push_place",
    "cup_handover",
    "double_door",
    "fill_bin",
    "gather_cubes",
    "lift_pot",
    "open_lid",
    "stack_together",
    "swap_places",
    "two_buttons",
)
OWN = "at its own reach: "

Row = dict[str, str | int | float]


def episodes(task: Task, seeds: int) -> Iterator[Row]:
    """Play the expert, a row an episode; one row if a home is out of reach."""
    try:
        env = parallel_env(task)
    except FileError as error:
        found = [finding for finding in error.findings if finding.code == "TB303"]
        if not found:
            raise
        yield {"seed": "", "success": 0, "cause": "home", "message": found[0].message}
        return
    with closing(env), closing(Expert(env)) as expert:
        for seed in range(seeds):
            began = time.process_time()
            done = expert.play(seed)
            cause, message = "", ""
            if not done.success:
                cause, message = "no success", "every stage was played, without success"
                if done.trouble is not None:
                    cause, message = done.trouble.cause, done.trouble.message
            yield {
                "seed": seed, "success": int(done.success), "cause": cause, "message": message,
                "cpu_s": round(time.process_time() - began, 2),
            }  # fmt: skip


def prove(file: Path, played: Path, tasks: Iterable[tuple[str, str, Task]]) -> None:
    """Prove each task with each arm that always succeeded in it, if that has not been done."""
    known = {(row["task"], row["robot"]) for row in rows_of(file)}
    failed = {(row["task"], row["robot"]) for row in rows_of(played) if row["success"] != "1"}
    with file.open("a", newline="", encoding="utf-8") as lines:
        writer = csv.DictWriter(lines, PROOF_FIELDS, lineterminator="\n")
        if not known:
            writer.writeheader()
        for name, robot, task in tasks:
            if (name, robot) in known | failed:
                continue
            report = validate_task(task)
            shares = [
                check.value
                for family in report.families
                for check in family.checks
                if check.code == "TB531" and check.value is not None
            ]
            errors = [found for found in report.findings if found.severity == "error"]
            result: Row = {
                "task": name, "robot": robot, "proved": int(report.ok),
                "success": min(shares, default=""),
                "codes": " ".join(sorted({found.code for found in errors})),
                "message": errors[0].message if errors else "",
                "seconds": round(report.making.seconds, 1) if report.making else "",
            }  # fmt: skip
            writer.writerow(result)
            lines.flush()
            print(f"{name} {robot}: {'proved' if report.ok else result['codes']}", flush=True)


def rows_of(file: Path) -> list[dict[str, str]]:
    """The lines written so far."""
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def own_tasks(folder: Path) -> Iterator[tuple[str, str, Task]]:
    """Tasks in proportion to the reach of each arm: name, robot and task."""
    for robot, reach in REACHES.items():
        for kind in KINDS:
            yield OWN + kind, robot, load_task(write_task(folder, kind, robot, reach))


def swapped() -> Iterator[tuple[str, str, Task]]:
    """Tasks of the library with both arms replaced: name, robot and task."""
    for name in TASKS:
        arms = load_task(name).file.scenes[0].robots
        for robot in REACHES:
            yield name, robot, load_task(name, robots=dict.fromkeys(arms, robot))


def main() -> None:
    """Play what has not been played."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--anew", action="store_true", help="forget the episodes played so far")
    parser.add_argument("--prove", action="store_true", help="prove those that always succeeded")
    parser.add_argument("--robot", nargs="+", choices=sorted(REACHES), default=sorted(REACHES))
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    file: Path = arguments.out
    if arguments.anew:
        file.unlink(missing_ok=True)
    if arguments.prove:
        with tempfile.TemporaryDirectory() as folder:
            prove(PROOFS, file, (*own_tasks(Path(folder)), *swapped()))
        return
    known = {(row["task"], row["robot"]) for row in rows_of(file)}
    with tempfile.TemporaryDirectory() as folder, file.open("a", newline="") as lines:
        writer = csv.DictWriter(lines, FIELDS, lineterminator="\n")
        if not known:
            writer.writeheader()
        for name, robot, task in (*own_tasks(Path(folder)), *swapped()):
            if (name, robot) in known or robot not in arguments.robot:
                continue
            # All episodes of a pair at once, so that an interrupted pair is played again.
            rows = list(episodes(task, OWN_SEEDS if name.startswith(OWN) else SEEDS))
            writer.writerows({"task": name, "robot": robot, **row} for row in rows)
            lines.flush()
            print(f"{name} {robot}: {sum(int(row['success']) for row in rows)} of {len(rows)}")


if __name__ == "__main__":
    main()
