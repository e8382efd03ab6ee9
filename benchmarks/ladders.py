"""The progress that descriptions write, beside the ladder that is made from the expert's stages.

    python benchmarks/ladders.py [--tasks reach handover ...] [--seeds 1] [--minutes 10]

Plays, from each seed, the expert, and the expert with Gaussian noise of 0.2 and of 0.5 on the
actions of its arms. Both ladders are read in every state up to the first success, and compared by
Spearman's rank correlation: in each kind of episode, and over all states of a task. `falls` are by
how much each ladder is below its highest value before, at most, where the expert succeeds, and
`waits_s` how long it does not rise by 1/300, both from 0 to 1. `at_end` is the mean of the last
value of each ladder.

Writes benchmarks/results/ladders.json after each task. Tasks that are in it are left out, so a run
goes on where it was stopped; delete the file to start over. After the CPU time that is given, it
stops with the task that it is at. It takes about 5 CPU-minutes.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from machine import describe_machine
from numpy.typing import NDArray

from taskbuilder import catalogue, load_task, parallel_env
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert import Expert, StageLadder
from taskbuilder.policies.noisy import NoisyExpert
from taskbuilder.rollout import Rollout, play
from taskbuilder.rollout.progress import (
    ProgressRange,
    longest_wait_s,
    measured_range,
    written_range,
)
from taskbuilder.task import Task

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results" / "ladders.json"
FIRST_SEED = 510_000
NOISE = (0.0, 0.2, 0.5)
"""Standard deviations of the noise, where actions are from -1 to 1."""

Numbers = NDArray[np.float64]
Climb = tuple[Rollout, Numbers]
"""An episode, and the ladder of the stages along it."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tasks", nargs="+", metavar="TASK", help="default: all with progress")
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="seeds for each task")
    parser.add_argument("--minutes", type=float, default=10.0, metavar="N", help="of CPU time")
    arguments = parser.parse_args()
    names = arguments.tasks or [n for n, e in sorted(catalogue().tasks.items()) if e.trusted]
    tasks = {name: load_task(name) for name in names}
    tasks = {
        name: task
        for name, task in tasks.items()
        if task.description.progress is not None and task.file.spec.expert
    }
    found: dict[str, Any] = json.loads(RESULTS.read_text())["tasks"] if RESULTS.exists() else {}
    for name, task in tasks.items():
        if name in found:
            continue
        if time.process_time() > 60.0 * arguments.minutes:
            print(f"{len(found)} of {len(tasks)} tasks; start again to go on")
            return 1
        found[name] = compared(task, range(FIRST_SEED, FIRST_SEED + arguments.seeds))
        write(found, arguments.seeds)
        print(f"{name}: {found[name]['rank_correlation']}", flush=True)
    return 0


def compared(task: Task, seeds: Sequence[int]) -> dict[str, Any]:
    """Both ladders of a task along its episodes."""
    with closing(parallel_env(task)) as env, closing(Expert(env)) as expert:
        climbs = {spread: [climbed(env, expert, s, spread) for s in seeds] for spread in NOISE}
    everything = [climb for each in climbs.values() for climb in each]
    scale = scale_of(task, [episode for episode, _ in everything])
    good = [climb for climb in everything if climb[0].success]
    return {
        "episodes": len(everything),
        "succeeded": len(good),
        "rank_correlation": {
            **{f"noise {spread:g}": spearman(each) for spread, each in climbs.items()},
            "all": spearman(everything),
        },
        "falls": both(fall, good, scale),
        "waits_s": both(longest_wait_s, good, scale),
        "at_end": both(at_end, everything, scale, np.mean),
    }


def climbed(env: TaskEnv, expert: Expert, seed: int, spread: float) -> Climb:
    """An episode of the expert with noise, and the ladder of the stages along it."""
    ladder, values = StageLadder(env), list[float]()

    def watch(env: TaskEnv) -> None:
        values.append(ladder.advance() if env.episode.steps else ladder.begin())

    policy = NoisyExpert(expert, spread) if spread else expert
    return play(env, policy, seed, watch=watch), np.array(values)


def scale_of(task: Task, episodes: Sequence[Rollout]) -> ProgressRange:
    """What is 0 and what is 1 of the progress that a description writes."""
    progress = task.description.progress
    found = (written_range(progress) if progress else None) or measured_range(episodes)
    if found is None:
        raise SystemExit(f"the progress of {task.name} never rises")
    return found


def states(climbs: Sequence[Climb]) -> tuple[Numbers, Numbers]:
    """Both ladders in all states up to the first success of each episode."""
    ends = [(e.first_success or e.steps) + 1 for e, _ in climbs]
    written = [e.progress[:end] for (e, _), end in zip(climbs, ends, strict=True)]
    stages = [values[:end] for (_, values), end in zip(climbs, ends, strict=True)]
    return np.concatenate(written), np.concatenate(stages)


def spearman(climbs: Sequence[Climb]) -> float:
    """The rank correlation of both ladders over all states."""
    written, stages = (ranks(values) for values in states(climbs))
    return round(float(np.corrcoef(written, stages)[0, 1]), 3)


def ranks(values: Numbers) -> Numbers:
    """The rank of each value; equal ones share the mean of theirs."""
    _, inverse, counts = np.unique(np.round(values, 9), return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    return (last - (counts - 1) / 2.0)[inverse]


def at_end(_: Rollout, ladder: Numbers) -> float:
    """The last value of a ladder."""
    return float(ladder[-1])


def fall(episode: Rollout, ladder: Numbers) -> float:
    """By how much a ladder is below its highest value before, at most, until success."""
    until = ladder[: (episode.first_success or episode.steps) + 1]
    return float((np.maximum.accumulate(until) - until).max())


def both(
    figure: Callable[[Rollout, Numbers], float],
    climbs: Sequence[Climb],
    scale: ProgressRange,
    over: Any = max,
) -> dict[str, float] | None:
    """A figure of each ladder, over some episodes."""
    if not climbs:
        return None
    written = [figure(episode, scale.shares(episode)) for episode, _ in climbs]
    stages = [figure(episode, values) for episode, values in climbs]
    return {"task": round(float(over(written)), 3), "expert": round(float(over(stages)), 3)}


def write(found: Mapping[str, Any], seeds: int) -> None:
    """Write the figures of all tasks so far, and their medians."""
    kinds = list(next(iter(found.values()))["rank_correlation"])
    correlations = {k: [t["rank_correlation"][k] for t in found.values()] for k in kinds}
    summary = {
        "tasks": len(found),
        "rank_correlation": {
            kind: dict(zip(("least", "median", "greatest"), _quantiles(each), strict=True))
            for kind, each in correlations.items()
        },
        "largest_fall": {
            ladder: max(t["falls"][ladder] for t in found.values() if t["falls"])
            for ladder in ("task", "expert")
        },
    }
    data = {
        "command": f"python benchmarks/ladders.py --seeds {seeds}",
        "machine": describe_machine(),
        "summary": summary,
        "tasks": found,
    }
    RESULTS.write_text(json.dumps(data, indent=1) + "\n")


def _quantiles(values: Sequence[float]) -> Iterator[float]:
    yield from (round(float(q), 3) for q in np.quantile(values, (0.0, 0.5, 1.0)))


if __name__ == "__main__":
    sys.exit(main())
