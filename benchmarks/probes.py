"""Errors that escape from an episode, however badly it is played.

    python benchmarks/probes.py [--seeds 200] [--tasks reach handover ...]

Plays every task of the library, and those of `tests/newcomers`, in these ways:

- the expert without one of the robots, each in turn;
- the expert with one of its stages left out, each in turn;
- the expert with some of its actions replaced by wild ones;
- attempts of one robot alone, as the family "needs its robots" makes them;
- random actions, and wild ones: at the bounds, with other signs at every step.

The first two seeds of a task are played in all of them, and every other seed in one: the ways take
turns.

Whatever the robots do, an episode comes to its end. An error that is raised on the way is counted,
with its traceback. A simulation that diverges is counted apart: the episode then ends, as it
should.

The seeds of a task are played in order, and those that were already played are left out. So a run
can be interrupted, and goes on where it was when it is started again.

Writes benchmarks/results/probes.json after each task; delete the file to start over.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from machine import describe_machine
from tqdm import tqdm

from taskbuilder import catalogue, load_task
from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout.play import play
from taskbuilder.rollout.record import Rollout
from taskbuilder.validate.checks.necessity import MOST_SOLOS
from taskbuilder.validate.env_cache import EnvCache
from taskbuilder.validate.playing import play_random
from taskbuilder.validate.solo import play_solo, solos

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results" / "probes.json"
SEEDS = 200

WHOLE = 2
"""So many seeds of a task are played in all ways."""

BUMPS = 0.03
"""Share of the expert's actions that are replaced by wild ones."""


Way = tuple[str, Callable[[], Rollout]]
"""A way to play an episode: its name, and what plays it."""


class WildActions:
    """Actions at their bounds, with signs that are drawn anew at every step."""

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode."""
        self._env = env
        self._rng = np.random.default_rng([seed, 3])

    def act(self, _: Mapping[str, Any]) -> Actions:
        """The next wild actions."""
        return {
            agent: self._rng.choice(np.array([-1.0, 1.0], dtype=np.float32), modes.size)
            for agent, modes in self._env.episode.actions.items()
        }


class BumpedExpert:
    """The expert, with some of its actions replaced by wild ones."""

    def __init__(self, expert: Expert) -> None:
        self._expert = expert
        self._wild = WildActions()

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode."""
        self._expert.reset(env, seed)
        self._wild.reset(env, seed)
        self._rng = np.random.default_rng([seed, 4])

    def act(self, observations: Mapping[str, Any]) -> Actions | None:
        """The expert's next actions, or wild ones."""
        actions = self._expert.act(observations)
        bumped = actions is not None and self._rng.random() < BUMPS
        return self._wild.act(observations) if bumped else actions


def plays_of(cache: EnvCache, seed: int) -> Iterator[Way]:
    """The ways to play from a seed, by name; the variations take turns."""
    task = cache.task
    variation = seed % len(task.file.scenes)
    env = cache.env(variation)
    yield "random", lambda: play_random(env, seed)
    yield "wild", lambda: play(env, WildActions(), seed)
    if not cache.has_expert:
        return
    expert = cache.expert(variation)
    yield "bumped", lambda: play(env, BumpedExpert(expert), seed)
    stages = task.file.spec.expert
    for number in range(len(stages)) if len(stages) > 1 else ():
        rest = (*stages[:number], *stages[number + 1 :])
        yield (
            f"without stage {number + 1}",
            lambda rest=rest: expert.play(seed, stages=rest, persist=True),
        )
    if len(task.agents) < 2:
        return
    for robot in task.agents:
        yield (
            f"without {robot}",
            lambda robot=robot: expert.play(seed, without={robot}, persist=True),
        )
    listed = solos(task, env.task.file.scenes[variation])
    for offset in range(min(MOST_SOLOS, len(listed))):
        solo = listed[(seed * MOST_SOLOS + offset) % len(listed)]
        yield str(solo.baseline), lambda solo=solo: play_solo(expert, seed, solo)


def turn(ways: list[Way], seed: int) -> list[Way]:
    """Those that are played from a seed.

    As many seeds as there are ways play each once; the next as many begin one later, so that a way
    does not always meet the same variation.
    """
    if seed < WHOLE:
        return ways
    return [ways[(seed + seed // len(ways)) % len(ways)]]


def probe(name: str, before: dict[str, Any], seeds: int) -> dict[str, Any]:
    """Play a task from the seeds that have not been played yet."""
    first = before.get("seeds", 0)
    plays, diverged = before.get("plays", 0), before.get("diverged", 0)
    errors = list(before.get("errors", ()))
    started = time.process_time()
    with closing(EnvCache(load_task(name))) as cache:
        for seed in tqdm(range(first, seeds), desc=Path(name).stem, disable=None, leave=False):
            for way, play_it in turn(list(plays_of(cache, seed)), seed):
                plays += 1
                try:
                    diverged += play_it().exploded
                except Exception as error:  # these are what is looked for
                    errors.append({"seed": seed, "way": way, **described(error)})
    seconds = before.get("cpu_s", 0.0) + time.process_time() - started
    return {
        "seeds": max(first, seeds),
        "plays": plays,
        "diverged": diverged,
        "cpu_s": round(seconds, 1),
        "errors": errors,
    }


def described(error: Exception) -> dict[str, str]:
    """An error, and where it arose in the library."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "taskbuilder" in f.filename]
    where = [f"{Path(f.filename).name}:{f.lineno} {f.name}" for f in frames[-4:]]
    return {"error": f"{type(error).__name__}: {error}", "where": " > ".join(where)}


def main() -> int:
    """Play, print, and write after each task."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=SEEDS, help="play up to so many of each task")
    parser.add_argument("--tasks", nargs="+", help="names or files; by default all")
    arguments = parser.parse_args()
    own = sorted((ROOT / "tests" / "newcomers").glob("*.yaml"))
    names = arguments.tasks or [*catalogue().tasks, *map(str, own)]
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {"tasks": {}}
    for name in names:
        key = Path(name).stem
        figures = probe(name, results["tasks"].get(key, {}), arguments.seeds)
        results["tasks"][key] = figures
        results |= {"command": "python benchmarks/probes.py", "machine": describe_machine()}
        RESULTS.write_text(json.dumps(results, indent=2) + "\n")
        print(
            f"{key:24} {figures['seeds']:4} seeds {figures['plays']:6} episodes "
            f"{len(figures['errors']):3} errors {figures['diverged']:3} diverged "
            f"{figures['cpu_s']:8.1f} s",
            flush=True,
        )
    tasks = results["tasks"].values()
    errors, plays = sum(len(t["errors"]) for t in tasks), sum(t["plays"] for t in tasks)
    print(f"{errors} errors escaped from {plays} episodes of {len(tasks)} tasks")
    return 0 if not errors else 1


if __name__ == "__main__":
    sys.exit(main())
