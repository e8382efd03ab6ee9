"""Collecting that is killed at random moments, and goes on; and changed bytes that are found.

    python benchmarks/collect_kills.py [--kills 100] [--runs 10]

In each of `--runs` runs a data set of the task reach is collected by two processes; meanwhile the
command or one of its processes is killed (SIGKILL), `--kills` times in all, at moments drawn evenly
over the time that collecting takes, its beginning and its end included. After a kill of the command
it is run again. At the end every file must have the bytes of a data set that was collected without
interruption. Then `--bytes` bytes of the data set are changed, one at a time, and
`taskbuilder dataset check` must name the file each time.

Writes benchmarks/results/collect_kills.json where it is run in full.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from machine import describe_machine
from tqdm import tqdm

from taskbuilder.data.checking import check_dataset

RESULTS = Path(__file__).parent / "results" / "collect_kills.json"

KILLS, RUNS, BYTES = 100, 10, 20
EPISODES = 4
COLLECT = (
    *(sys.executable, "-m", "taskbuilder", "collect", "reach", "--debug"),
    *("--episodes", str(EPISODES)),
    *("--cameras", "front", "--size", "32", "--jobs", "2", "--out"),
)
QUIET: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
FROM_COMMAND = 0.5
"""Share of the kills that strike the command itself; the others strike one of its processes."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=KILLS)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--bytes", type=int, default=BYTES)
    arguments = parser.parse_args()
    rng = np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder) / "whole"
        started = time.monotonic()
        subprocess.run([*COLLECT, str(whole)], **QUIET, check=True)
        seconds = time.monotonic() - started
        expected = bytes_of(whole)
        parts = np.array_split(np.arange(arguments.kills), arguments.runs)
        runs = []
        for number, part in enumerate(tqdm(parts, desc="runs", disable=None)):
            runs.append(torment(Path(folder) / f"killed-{number}", len(part), seconds, rng))
            runs[-1]["equal"] = bytes_of(Path(folder) / f"killed-{number}") == expected
        found = [change_a_byte(whole, rng) for _ in range(arguments.bytes)]
    struck = sum((Counter(run["kills"]) for run in runs), Counter())
    equal, named = sum(run["equal"] for run in runs), sum(each["named"] for each in found)
    print(f"{struck.total()} kills ({dict(struck)}); {equal} of {len(runs)} data sets are equal")
    print(f"{named} of {len(found)} changed bytes were found, and their files named")
    if (arguments.kills, arguments.runs, arguments.bytes) == (KILLS, RUNS, BYTES):
        data = {"command": "python benchmarks/collect_kills.py", "machine": describe_machine()}
        told = {**data, "episodes": EPISODES, "seconds": round(seconds, 1), "runs": runs}
        RESULTS.write_text(json.dumps({**told, "bytes": found}, indent=2) + "\n")
    complete = struck.total() == arguments.kills
    return 0 if equal == len(runs) and named == len(found) and complete else 1


def torment(out: Path, kills: int, seconds: float, rng: np.random.Generator) -> dict[str, Any]:
    """Collect a data set under fire."""
    struck: Counter[str] = Counter()
    starts = 0
    while True:
        starts, before = starts + 1, struck.total()
        said = out.with_name(f"{out.name}.log")
        with said.open("w") as log, _command(out, log) as child:
            while struck.total() < kills and child.poll() is None:
                with suppress(subprocess.TimeoutExpired):
                    child.wait(float(rng.uniform(0.0, seconds)))
                if child.poll() is None:
                    struck[strike(child.pid, rng)] += 1
            status = child.wait()
        if status > 0 and struck.total() == before:  # although nobody struck it
            command = " ".join([*COLLECT, str(out)])
            raise SystemExit(f"{command} ends with status {status}:\n{said.read_text()}")
        done = status == 0
        if done and struck.total() == kills:
            return {"kills": dict(struck), "starts": starts}
        if done:  # before it could be struck often enough: once more from the start
            shutil.rmtree(out)


def _command(out: Path, log: TextIO) -> subprocess.Popen[bytes]:
    return subprocess.Popen([*COLLECT, str(out)], stdout=log, stderr=log)


def strike(command: int, rng: np.random.Generator) -> str:
    """Kill a command, or one of its processes if it has any yet."""
    if rng.uniform() >= FROM_COMMAND:
        children = Path(f"/proc/{command}/task/{command}/children").read_text().split()
        if children:
            os.kill(int(rng.choice(children)), signal.SIGKILL)
            return "process"
    os.kill(command, signal.SIGKILL)
    return "command"


def change_a_byte(folder: Path, rng: np.random.Generator) -> dict[str, Any]:
    """Change a byte, see whether it is found, and change it back."""
    files = sorted(file for file in folder.rglob("*") if file.is_file())
    file = files[int(rng.integers(len(files)))]
    before = file.read_bytes()
    offset = int(rng.integers(len(before)))
    changed = bytearray(before)
    changed[offset] ^= int(rng.integers(1, 256))
    file.write_bytes(bytes(changed))
    name = file.relative_to(folder).as_posix()
    damaged = check_dataset(folder, 0.0).damaged
    file.write_bytes(before)
    return {"file": name, "offset": offset, "named": any(d.startswith(name) for d in damaged)}


def bytes_of(folder: Path) -> dict[str, bytes]:
    """The content of every file, by its path in the folder."""
    files = (file for file in folder.rglob("*") if file.is_file())
    return {file.relative_to(folder).as_posix(): file.read_bytes() for file in files}


if __name__ == "__main__":
    sys.exit(main())
