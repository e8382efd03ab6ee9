"""What collecting a data set takes: time, processor time and space.

    python benchmarks/collecting.py [--episodes 1000] [--jobs 2] [--only numbers]

Collects episodes of handover once without cameras, and once with two cameras at 128 x 128 pixels
that are exported to LeRobot v3. The targets for 1,000 episodes on two cores are 2 minutes for the
first, and 5 minutes and 150 MB for the second.

Writes benchmarks/results/collecting.json where it is run in full.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from machine import describe_machine

RESULTS = Path(__file__).parent / "results" / "collecting.json"

EPISODES, JOBS = 1000, 2
COLLECT = (sys.executable, "-m", "taskbuilder", "collect", "handover")
CAMERAS = ("--cameras", "front,left_wrist", "--size", "128", "--format", "lerobot")
KINDS: dict[str, tuple[str, ...]] = {"numbers": (), "pictures": CAMERAS}
TARGETS: dict[str, dict[str, float]] = {
    "numbers": {"seconds": 120.0},
    "pictures": {"seconds": 300.0, "megabytes": 150.0},
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--episodes", type=int, default=EPISODES)
    parser.add_argument("--jobs", type=int, default=JOBS)
    parser.add_argument("--only", choices=KINDS)
    arguments = parser.parse_args()
    kinds = [arguments.only] if arguments.only else list(KINDS)
    measured = {kind: measure(kind, arguments.episodes, arguments.jobs) for kind in kinds}
    for kind, found in measured.items():
        print(f"{kind}: {found}")
    if (arguments.episodes, arguments.jobs, kinds) == (EPISODES, JOBS, list(KINDS)):
        data = {"command": "python benchmarks/collecting.py", "machine": describe_machine()}
        told = {**data, "episodes": EPISODES, "jobs": JOBS, "targets": TARGETS}
        RESULTS.write_text(json.dumps({**told, "measured": measured}, indent=2) + "\n")
    return 0


def measure(kind: str, episodes: int, jobs: int) -> dict[str, Any]:
    """Collect one data set, and say what it took."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "data"
        words = ("--episodes", str(episodes), "--jobs", str(jobs), "--out", str(out), *KINDS[kind])
        before, started = processor_s(), time.monotonic()
        subprocess.run([*COLLECT, *words], check=True, stdout=subprocess.DEVNULL)
        seconds = time.monotonic() - started
        about = json.loads((out / "dataset.json").read_text())
        exported = out.with_name("data-lerobot")
        return {
            "seconds": round(seconds, 1),
            "processor_s": round(processor_s() - before, 1),
            "processor_s_per_episode": round((processor_s() - before) / episodes, 3),
            "megabytes": megabytes(exported if exported.exists() else out),
            "own_megabytes": megabytes(out),
            "renderer": about["renderer"],
        }


def processor_s() -> float:
    """Processor time of all processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def megabytes(folder: Path) -> float:
    """Size of the files of a folder."""
    total = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    return round(total / 1e6, 2)


if __name__ == "__main__":
    sys.exit(main())
