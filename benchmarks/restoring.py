"""Are saved states restored exactly, and at what price? Every step of the expert's episodes.

    nice python benchmarks/restoring.py [TASK ...]

In every task of the catalogue, from each of three seeds, the state is saved at every control step
of the expert's episode. Then the states are loaded in a random order. From each the expert's
actions go on for two steps, and from every twentieth to the end of the episode. Every twentieth is
also pickled, and loaded in another environment, which has played another episode. Everything is
compared to the bit after every step: observations, rewards, infos, the state, and positions and
velocities of all bodies.

Writes a line an episode to benchmarks/results/restoring.csv, where an interrupted run goes on, and
sums up in benchmarks/results/restoring.json.
"""

from __future__ import annotations

import argparse
import csv
import json
import pickle
import random
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from pathlib import Path
from statistics import fmean, median
from typing import Any

from machine import describe_machine

from taskbuilder import catalogue, parallel_env
from taskbuilder.env.parallel import EnvState, TaskEnv
from taskbuilder.expert import Expert
from taskbuilder.jobs import workers
from taskbuilder.processes import cores
from taskbuilder.validate.traces import Step, actions_of, difference, go_on, trace

RESULTS = Path(__file__).parent / "results"
FIRST_SEED = 3_300_000
AHEAD, EVERY = 2, 20
FIELDS = (
    *("task", "seed", "states", "with_snapshot", "differing", "elsewhere", "differing_elsewhere"),
    *("step_ms", "save_ms", "load_by_snapshot_ms", "load_by_actions_ms", "load_elsewhere_ms"),
    *("kilobytes_pickled",),
)


class Clock:
    """Times calls, in milliseconds of the processor, for other work may share it."""

    def __init__(self) -> None:
        self.times: dict[str, list[float]] = {}

    def __call__(self, what: str, call: Callable[[], Any]) -> Any:
        """Call something and note how long it took."""
        started = time.process_time()
        result = call()
        self.times.setdefault(what, []).append((time.process_time() - started) * 1e3)
        return result

    def mean(self, what: str) -> str:
        """The mean of what was timed, or nothing."""
        return f"{fmean(self.times[what]):.3f}" if what in self.times else ""


def restore_all(job: tuple[str, int]) -> dict[str, Any]:
    """Save and restore every state of an episode."""
    task, seed = job
    clock = Clock()
    with closing(parallel_env(task)) as env, closing(Expert(env)) as expert:
        actions = actions_of(expert.play(seed))
        steps = list(trace(env, seed, ()))
        states: list[EnvState] = []
        for action in actions:
            states.append(clock("save", env.save_state))
            steps += clock("step", lambda action=action: list(go_on(env, [action])))
        order = random.Random(seed).sample(range(len(states)), len(states))
        differing = 0
        for number in order:
            state = states[number]
            how = "actions" if state.episode.snapshot is None else "snapshot"
            clock(f"load by {how}", lambda state=state: env.load_state(state))
            end = len(actions) if number % EVERY == 0 else number + AHEAD
            differing += differs(env, steps, actions[:end], number)
        some = [number for number in order if number % EVERY == 0]
        with closing(parallel_env(task)) as other:
            trace(other, seed + 1, actions[::-1])
            differing_elsewhere = 0
            for number in some:
                state = pickle.loads(pickle.dumps(states[number]))  # made here
                clock("load elsewhere", lambda state=state: other.load_state(state))
                differing_elsewhere += differs(other, steps, actions[: number + AHEAD], number)
    return {
        "task": task,
        "seed": seed,
        "states": len(states),
        "with_snapshot": sum(state.episode.snapshot is not None for state in states),
        "differing": differing,
        "elsewhere": len(some),
        "differing_elsewhere": differing_elsewhere,
        "step_ms": clock.mean("step"),
        "save_ms": clock.mean("save"),
        "load_by_snapshot_ms": clock.mean("load by snapshot"),
        "load_by_actions_ms": clock.mean("load by actions"),
        "load_elsewhere_ms": clock.mean("load elsewhere"),
        "kilobytes_pickled": f"{len(pickle.dumps(states[-1])) / 1000:.1f}",
    }


def differs(env: TaskEnv, steps: Sequence[Step], actions: Sequence[Any], number: int) -> bool:
    """Whether an episode goes on otherwise than it did after a number of its control steps."""
    again = list(go_on(env, actions[number:]))
    return difference(steps[number + 1 : len(actions) + 1], again) is not None


def rows_of(file: Path) -> list[dict[str, str]]:
    """The episodes that have been played already."""
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as lines:
        return [row for row in csv.DictReader(lines) if None not in row.values()]


def summary(rows: Sequence[dict[str, str]]) -> dict[str, Any]:
    """Sums over all episodes, and the price of each way to restore, in control steps."""

    def total(column: str) -> int:
        return sum(int(row[column]) for row in rows)

    def in_steps(column: str) -> float:
        return price(float(row[column]) / float(row["step_ms"]) for row in rows if row[column])

    return {
        "tasks": len({row["task"] for row in rows}),
        "episodes": len(rows),
        "states": total("states"),
        "with_snapshot": total("with_snapshot"),
        "differing": total("differing"),
        "elsewhere": total("elsewhere"),
        "differing_elsewhere": total("differing_elsewhere"),
        "tasks_with_a_snapshot_of_every_state": sorted(
            {row["task"] for row in rows}
            - {row["task"] for row in rows if row["states"] != row["with_snapshot"]}
        ),
        "in_control_steps": {
            "what": "median over episodes of a mean time, divided by that of a control step",
            "save": in_steps("save_ms"),
            "load by snapshot": in_steps("load_by_snapshot_ms"),
            "load by actions": in_steps("load_by_actions_ms"),
            "load in another environment": in_steps("load_elsewhere_ms"),
        },
    }


def price(shares: Iterable[float]) -> float:
    """The median, rounded."""
    return round(median(shares), 2)


def main() -> None:
    """Restore what has not been restored, and sum up."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", default=list(catalogue().tasks))
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--jobs", type=int, default=cores())
    arguments = parser.parse_args()
    file = RESULTS / "restoring.csv"
    known = {(row["task"], int(row["seed"])) for row in rows_of(file)}
    seeds = range(FIRST_SEED, FIRST_SEED + arguments.seeds)
    jobs = [(task, seed) for task in arguments.tasks for seed in seeds]
    with file.open("a", encoding="utf-8", newline="") as lines:
        writer = csv.DictWriter(lines, FIELDS)
        if not known:
            writer.writeheader()
        with workers(arguments.jobs) as spread:
            for row in spread(restore_all, [job for job in jobs if job not in known]):
                writer.writerow(row)
                lines.flush()
                print(
                    f"{row['task']:22} seed {row['seed']}: {row['differing']} of {row['states']} "
                    f"states differ, and elsewhere {row['differing_elsewhere']} of "
                    f"{row['elsewhere']}",
                    flush=True,
                )
    found = {"machine": describe_machine(), **summary(rows_of(file))}
    (RESULTS / "restoring.json").write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
