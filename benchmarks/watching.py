"""How soon after a file is saved `taskbuilder watch` has checked the task and taken its picture.

Tasks are copied, watched, and saved again and again: the task file, then the description, in turn.

    python benchmarks/watching.py --out benchmarks/results/watching.json

For each task, the result has the medians and the largest of the seconds from saving to what is
printed, and the seconds of computation until all is, which do not depend on what else the machine
does.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from machine import describe_machine

from taskbuilder.schema.catalogue import Catalogue

TASKS = ("handover", "collaborative_lift", "open_drawer")
LIMITS_S = {"static": 0.3, "picture": 1.0, "build": 1.0}
_TICKS = os.sysconf("SC_CLK_TCK")


def computed_s(pid: int) -> float:
    """Processor time of a process and its children, in seconds."""
    total = 0.0
    for child in (pid, *map(int, Path(f"/proc/{pid}/task/{pid}/children").read_text().split())):
        fields = Path(f"/proc/{child}/stat").read_text().rpartition(")")[2].split()
        total += (int(fields[11]) + int(fields[12])) / _TICKS
    return total


def until(watched: subprocess.Popen[str], word: str) -> float:
    """Wait for a line that begins with a word; when it came."""
    for line in watched.stdout or ():
        if line.split()[:1] == [word]:
            return time.perf_counter()
    raise RuntimeError(f"the watch ended before it said {word!r}")


def measure(task: str, times: int) -> dict[str, object]:
    """Save a copy of a task so many times, and time what follows."""
    with tempfile.TemporaryDirectory() as folder:
        entry = Catalogue.discover().task(task)
        for file in (*entry.root.glob("*.urdf"), entry.file, entry.description_file):
            shutil.copy(file, folder)
        for assets in (path for path in entry.root.iterdir() if path.is_dir()):
            shutil.copytree(assets, Path(folder, assets.name))
        files = [Path(folder, entry.file.name), Path(folder, entry.description_file.name)]
        command = [sys.executable, "-m", "taskbuilder", "watch", entry.file.name]
        with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as watched:
            until(watched, "build")
            seconds: dict[str, list[float]] = {word: [] for word in (*LIMITS_S, "computed")}
            for number in range(times):
                time.sleep(0.2)
                before = computed_s(watched.pid)
                file = files[number % 2]
                file.write_text(file.read_text() + f"# {number}\n")
                saved = time.perf_counter()
                for word in LIMITS_S:
                    seconds[word].append(until(watched, word) - saved)
                seconds["computed"].append(computed_s(watched.pid) - before)
            watched.send_signal(signal.SIGINT)
        return {
            name: {"median_s": round(statistics.median(found), 3), "most_s": round(max(found), 3)}
            for name, found in seconds.items()
        }


def main() -> None:
    """Measure, print and keep."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=10)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    result = {
        "machine": describe_machine(),
        "load": round(os.getloadavg()[0], 1),
        "limits_s": LIMITS_S,
        "tasks": {task: measure(task, arguments.times) for task in TASKS},
    }
    text = json.dumps(result, indent=2)
    print(text)
    if arguments.out:
        arguments.out.write_text(text + "\n")


if __name__ == "__main__":
    main()
