"""What hours of training ask for: faults survived, memory that does not grow, a pace that holds.

    python benchmarks/soak.py [--only faults|steps|resets] [--scale 0.01]

Three parts, on the task handover:

- faults: 100 worker faults (killed, segmentation fault, stopped, exception), in a seeded order;
  each may cost the episode of that worker's environment and nothing else. A worker that is never
  struck must go on as if it were alone, to the bit.
- steps: 100,000 control steps with random actions; memory and pace.
- resets: 10,000 resets; time and memory.

Writes benchmarks/results/soak.json; with another scale than 1 it only prints.
"""

from __future__ import annotations

import argparse
import json
import logging
import os
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from machine import describe_machine
from tqdm import tqdm

from taskbuilder import load_task, make_vec, parallel_env
from taskbuilder.env.vector import TaskVectorEnv

RESULTS = Path(__file__).parent / "results" / "soak.json"

FAULTS = 100
STEPS = 100_000
RESETS = 10_000

LIMITS = {
    "episodes_lost_besides": 0,
    "environments_disturbed": 0,
    "processes_left": 0,
    "memory_kb_per_episode": 1.0,
    "pace_drift": 0.05,
    "reset_ms": 5.0,
    "memory_kb_per_reset": 1.0,
}

# Handover with a condition that does what a file beside it asks of a process.
TROUBLED = """
import ctypes
import os
from pathlib import Path

from taskbuilder.description import WorldView, condition
from taskbuilder.tasks import handover

ORDER = Path(__file__).with_suffix(".order")


@condition
def trouble(world: WorldView) -> bool:
    if world.time == 0.0:
        return False
    try:
        kind, pid = ORDER.read_text().split()
    except FileNotFoundError:  # none is given, or another worker has just carried it out
        return False
    if int(pid) == os.getpid():
        ORDER.unlink()
        if kind == "segfault":
            ctypes.string_at(0)
        raise RuntimeError("an injected fault")
    return False


class Troubled(handover.Handover):
    troubled = trouble()
"""


def soak_faults(count: int) -> dict[str, Any]:
    """Strike two of three workers again and again."""
    logging.getLogger("taskbuilder").setLevel(logging.ERROR)
    rng = np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as folder:
        task = Path(folder) / "troubled.yaml"
        text = load_task("handover").file.entry.file.read_text()
        task.write_text(text.replace("task: handover", "task: troubled"))
        task.with_suffix(".py").write_text(TROUBLED)
        struck = make_vec(task, 3, 3, timeout_s=2.0)
        calm = make_vec(task, 3)
        try:
            return _strike(struck, calm, task.with_suffix(".order"), rng, count)
        finally:
            struck.close()
            calm.close()


def _strike(
    struck: TaskVectorEnv, calm: TaskVectorEnv, order: Path, rng: np.random.Generator, count: int
) -> dict[str, Any]:
    kinds = [("kill", "segfault", "stop", "raise")[number % 4] for number in range(count)]
    rng.shuffle(kinds)
    struck.reset(seed=0)
    calm.reset(seed=0)
    lost_besides = disturbed = 0
    pids = set(struck.worker_pids)
    started = time.perf_counter()
    for kind in tqdm(kinds, desc="faults"):
        for _ in range(int(rng.integers(1, 10))):
            lost, same = _step_both(struck, calm, rng)
            lost_besides += int(lost.sum())
            disturbed += not same
        victim = int(rng.integers(2))
        _inject(kind, struck.worker_pids[victim], order)
        lost, same = _step_both(struck, calm, rng)
        if not lost[victim]:
            raise RuntimeError(f"a fault ({kind}) had no effect")
        lost_besides += int(lost.sum()) - 1
        disturbed += not same
        pids |= set(struck.worker_pids)
    seconds = time.perf_counter() - started
    struck.close()
    left = sum(Path(f"/proc/{pid}").exists() for pid in pids)
    return {
        "faults": count,
        "episodes_lost_besides": lost_besides,
        "environments_disturbed": disturbed,
        "processes_left": left,
        "seconds_per_fault": seconds / count,
    }


def _step_both(
    struck: TaskVectorEnv, calm: TaskVectorEnv, rng: np.random.Generator
) -> tuple[np.ndarray[Any, Any], bool]:
    """Which episodes were lost, and whether the spared environment is as in a calm run."""
    actions = {
        agent: rng.uniform(-1.0, 1.0, struck.action_space[agent].shape) for agent in struck.agents
    }
    seen, paid, _, _, infos = struck.step(actions)
    expected, due, *_ = calm.step(actions)
    same = all(
        np.array_equal(seen[agent][2], expected[agent][2]) and paid[agent][2] == due[agent][2]
        for agent in struck.agents
    )
    return infos["lost"], same


def _inject(kind: str, pid: int, order: Path) -> None:
    if kind in ("kill", "stop"):
        os.kill(pid, signal.SIGKILL if kind == "kill" else signal.SIGSTOP)
    else:
        order.write_text(f"{kind} {pid}")


def soak_steps(count: int) -> dict[str, Any]:
    """Step with random actions; look at memory after every episode, at time in ten parts."""
    env = make_vec("handover", 1)
    rng = np.random.default_rng(0)
    shapes = {agent: env.action_space[agent].shape for agent in env.agents}
    env.reset(seed=0)
    resident = Samples(count)  # at most an episode a step
    part_s: list[float] = []
    started = time.perf_counter()
    for part in tqdm(_tenths(count), desc="steps", total=10):
        before = time.process_time()
        for _ in part:
            *_, ended, over, _ = env.step(
                {agent: rng.uniform(-1.0, 1.0, shape) for agent, shape in shapes.items()}
            )
            if ended[0] or over[0]:
                resident.add(resident_bytes())
        part_s.append(time.process_time() - before)
    resident_mb = resident_bytes() / 2**20
    env.close()
    return {
        "steps": count,
        "episodes": resident.count,
        "memory_kb_per_episode": resident.slope() / 1024.0,
        "memory_mb": resident_mb,
        "pace_drift": part_s[-1] / part_s[0] - 1.0,
        "process_us_per_step": sum(part_s) / count * 1e6,
        "steps_per_second": count / (time.perf_counter() - started),
    }


def soak_resets(count: int) -> dict[str, Any]:
    """Reset with one seed after the other."""
    env = parallel_env("handover")
    resident, seconds = Samples(count), Samples(count)
    for seed in tqdm(range(count), desc="resets"):
        started = time.perf_counter()
        env.reset(seed=seed)
        seconds.add(time.perf_counter() - started)
        resident.add(resident_bytes())
    env.close()
    return {
        "resets": count,
        "reset_ms": seconds.percentile(50) * 1000.0,
        "reset_ms_99th": seconds.percentile(99) * 1000.0,
        "memory_kb_per_reset": resident.slope() / 1024.0,
    }


def resident_bytes() -> int:
    """Memory of this process that is in RAM."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


class Samples:
    """Numbers in an array that is as large from the start as it will ever be.

    A list that grows would be seen in the memory that it is there to watch.
    """

    def __init__(self, most: int) -> None:
        self.count = 0
        self._values = np.full(most, np.nan)

    def add(self, value: float) -> None:
        """Keep one more."""
        self._values[self.count] = value
        self.count += 1

    def percentile(self, share: float) -> float:
        """The value that a share of all, in per cent, is below."""
        return float(np.percentile(self._values[: self.count], share))

    def slope(self) -> float:
        """Growth from one to the next, by a linear fit after the first tenth."""
        settled = self._values[self.count // 10 : self.count]
        return float(np.polyfit(range(len(settled)), settled, 1)[0])


def _tenths(count: int) -> Iterator[range]:
    for part in range(10):
        yield range(count * part // 10, count * (part + 1) // 10)


PARTS: dict[str, tuple[Callable[[int], dict[str, Any]], int]] = {
    "faults": (soak_faults, FAULTS),
    "steps": (soak_steps, STEPS),
    "resets": (soak_resets, RESETS),
}


def show(figures: dict[str, Any]) -> bool:
    """Print a part's figures; tell whether they are within their limits."""
    fine = True
    for key, value in figures.items():
        verdict = ""
        if key in LIMITS:
            good = value <= LIMITS[key]
            fine &= good
            verdict = f"limit {LIMITS[key]:g}  {'ok' if good else 'over'}"
        print(f"  {key:28} {value:10.3f}  {verdict}".rstrip())
    return fine


def main() -> int:
    """Run the parts that are asked for, print, and write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", choices=PARTS, help="one part alone")
    parser.add_argument("--scale", type=float, default=1.0, help="do more or less of everything")
    arguments = parser.parse_args()
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    results |= {"machine": describe_machine(), "limits": LIMITS}
    fine = True
    for name in [arguments.only] if arguments.only else PARTS:
        soak, count = PARTS[name]
        results[name] = soak(max(20, round(count * arguments.scale)))
        print(name)
        fine &= show(results[name])
        if arguments.scale == 1.0:
            RESULTS.write_text(json.dumps(results, indent=2) + "\n")
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
