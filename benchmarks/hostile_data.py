"""Data sets that were made to do harm, given to every command that reads data sets.

    python benchmarks/hostile_data.py [--sets 600] [--only MUTATOR] [--seed 0]

A sound data set of the task reach, with pictures and depth, and one of a task that comes along with
it are changed by the functions in `hostile_sets` and `hostile_files`, each in turn. Every changed
set is then read by `dataset info`, `check`, `film` and `export`, and by one update of `train`. Each
call runs in a watched process (see `strangers`). None may execute what comes with the set, read
files elsewhere, open a socket, start a program, hang, take over 500 MB more than the same command
on the sound set, show a traceback, or end with status 70.

Writes benchmarks/results/hostile_data.json where it is run in full. For Linux on x86-64, on a file
system that records when files are read.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
import tempfile
import zlib
from collections import Counter
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import hostile_files  # noqa: F401  # adds its functions to MUTATORS
import numpy as np
from hostile_sets import MUTATORS, UNSEALED, Outside, reseal, video
from machine import describe_machine
from strangers import Call, Watch
from tqdm import tqdm

RESULTS = Path(__file__).parent / "results" / "hostile_data.json"

SETS, MOST_MB = 600, 500.0
TAKEN_ALONG_EVERY = 8
"""Every so many sets, mutators of all kinds change the set with a task that comes along."""

OWN = {
    "mine.yaml": """\
task: mine
summary: One arm moves at random.
scene:
  robots:
    arm: {model: panda, base: {position: [0, 0, 0]}}
  objects:
    cube: {shape: {box: [0.04, 0.04, 0.04]}, mass: 0.1, position: [0.5, 0, 0.02]}
  cameras:
    front: {position: [1.2, 0, 0.8], look_at: [0.5, 0, 0], size: [32, 32]}
timing: {episode_steps: 30}
""",
    "mine.py": """\
from taskbuilder.description import Above, Bonus, Description


class Mine(Description):
    success = Above("cube", height=0.2)
    reward = (Bonus("done", success, 1.0),)


""",
}

PICTURES = ("--cameras", "front", "--size", "32", "--depth", "--episodes", "2", "--jobs", "1")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=int, default=SETS)
    parser.add_argument("--only", choices=sorted(MUTATORS))
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    load_all()
    with tempfile.TemporaryDirectory() as folder:
        watch = Watch(Path(folder))
        watch.check_itself()
        sound = sound_sets(watch)
        warm_up(watch, sound["reach"])
        outside = Outside(
            watch.secret("secret.txt", b"secret\n" * 100),
            watch.secret("secret.mp4", video(32, 32, 31)),
            watch.program("by a mutator"),
        )
        own = {name: try_all(watch, place) for name, place in sound.items()}
        check_sound(own["reach"])
        names = [arguments.only] if arguments.only else sorted(MUTATORS)
        sets = [
            hostile_set(watch, sound, outside, names[n % len(names)], n, arguments.seed)
            for n in tqdm(range(arguments.sets), desc="sets", disable=None)
        ]
    calls = [(told, call) for told in sets for call in told["calls"]]
    memory = {words[:3]: max(of[words].memory_mb for of in own.values()) for words in COMMANDS}
    wrong = [
        {"mutator": told["mutator"], "number": told["number"], "wrong": wrongs, **call.as_data()}
        for told, call in calls
        if (wrongs := call.wrongs(memory[command_of(call)], MOST_MB))
    ]
    report(arguments, sets, calls, memory, wrong)
    return 1 if wrong else 0


# --- calls

SET, OUT = "SET", "OUT"

COMMANDS: tuple[tuple[str, ...], ...] = (
    ("dataset", "info", SET),
    ("dataset", "check", SET, "--replay", "0.1"),
    ("dataset", "film", SET, "--episode", "0", "--size", "32", "--out", OUT),
    ("dataset", "export", SET, "--format", "lerobot", "--out", OUT),
    ("dataset", "export", SET, "--format", "robomimic", "--out", OUT),
    (
        *("train", "--algorithm", "bc", "--data", SET, "--cameras", "front", "--out", OUT),
        *("--steps", "1", "--evaluate-episodes", "1", "--film-every", "0"),
        *("--set", "hidden=[8]", "batch=4"),
    ),
)


def try_all(watch: Watch, place: Path) -> dict[tuple[str, ...], Call]:
    """Give a data set to all commands."""
    calls = {}
    for words in COMMANDS:
        out = watch.scratch / "out"
        shutil.rmtree(out, ignore_errors=True)
        calls[words] = watch.call([{SET: str(place), OUT: str(out)}.get(w, w) for w in words])
    return calls


def check_sound(calls: dict[tuple[str, ...], Call]) -> None:
    """Check that all commands work on what is sound, or else nothing would be measured.

    Raises:
        SystemExit: One does not.
    """
    for call in calls.values():
        if call.status or call.wrongs(call.memory_mb, MOST_MB):
            raise SystemExit(f"{' '.join(call.words)} fails on the sound data set: {call}")


def command_of(call: Call) -> tuple[str, ...]:
    """The first words of a call, as `COMMANDS` has them."""
    return next(
        words[:3]
        for words in COMMANDS
        if len(words) == len(call.words)
        and all(w in (SET, OUT, said) for w, said in zip(words, call.words, strict=True))
    )


# --- data sets


def load_all() -> None:
    """Load what commands load, so that calls need not."""
    import av  # noqa: F401
    import cv2  # noqa: F401
    import h5py  # noqa: F401
    import torch

    import taskbuilder.cli.dataset_command
    import taskbuilder.cli.train_command
    import taskbuilder.learn.algorithms.bc
    import taskbuilder.raster.filling  # noqa: F401

    torch.set_num_threads(1)


def warm_up(watch: Watch, place: Path) -> None:
    """Read a sound data set in this process, so that calls find compiled what they need."""
    from taskbuilder.cli import main as taskbuilder

    with Path(os.devnull).open("w") as sink, redirect_stdout(sink), redirect_stderr(sink):
        for number, words in enumerate(COMMANDS):
            out = watch.scratch / f"warm-{number}"
            taskbuilder([{SET: str(place), OUT: str(out)}.get(w, w) for w in words])


def sound_sets(watch: Watch) -> dict[str, Path]:
    """Collect the data sets that are changed later."""
    own = watch.scratch / "own"
    own.mkdir()
    for name, text in OWN.items():
        (own / name).write_text(text)
    with (own / "mine.py").open("a") as file:
        file.write(watch.program("the task that comes along"))
    reach, mine = watch.scratch / "reach", watch.scratch / "mine"
    for words in (
        ("reach", "--out", str(reach)),
        (str(own / "mine.yaml"), "--out", str(mine), "--policy", "random", "--keep-failures"),
    ):
        call = watch.call(["collect", *words, *PICTURES])
        if call.status:
            raise SystemExit(f"collecting failed: {call}")
    shutil.rmtree(own)
    return {"reach": reach, "mine": mine}


def hostile_set(
    watch: Watch,
    sound: dict[str, Path],
    outside: Outside,
    name: str,
    number: int,
    seed: int,
) -> dict[str, Any]:
    """Change a sound data set by a mutator, and give it to all commands."""
    rng = np.random.default_rng([seed, number, zlib.crc32(name.encode())])
    along = name.startswith("carried") or not rng.integers(TAKEN_ALONG_EVERY)
    place = watch.scratch / "hostile"
    shutil.copytree(sound["mine" if along else "reach"], place)
    sealed = name not in UNSEALED or bool(rng.integers(2))
    aside(lambda: change(place, name, rng, outside, sealed=sealed))
    calls = list(try_all(watch, place).values())
    remove(place)
    for call in calls:
        if wrongs := call.wrongs(call.memory_mb, MOST_MB):
            tqdm.write(f"{name} {number}: {', '.join(wrongs)}: {call.words[1]}: {call.said}")
    return {"mutator": name, "number": number, "calls": calls}


def change(
    place: Path, name: str, rng: np.random.Generator, outside: Outside, *, sealed: bool
) -> None:
    """Change a data set."""
    MUTATORS[name](place, rng, outside)
    if sealed:
        reseal(place)


def aside(function: Any) -> None:
    """Call a function in a process of its own, whose memory and threads end with it.

    Raises:
        SystemExit: It fails.
    """
    child = os.fork()
    if not child:
        try:
            function()
        except BaseException:
            import traceback

            traceback.print_exc()
            os._exit(1)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    if status:
        raise SystemExit("a mutator failed")


def remove(place: Path) -> None:
    """Remove a data set, however deep its folders are."""
    os.system(f"rm -rf -- '{place}'")  # a path of ours; Python's own goes too deep


# --- results


def report(
    arguments: argparse.Namespace,
    sets: Sequence[dict[str, Any]],
    calls: Sequence[tuple[dict[str, Any], Call]],
    memory: dict[tuple[str, ...], float],
    wrong: Sequence[dict[str, Any]],
) -> None:
    """Print and write what was found."""
    counts = Counter(what for each in wrong for what in each["wrong"])
    refused = sum(any(call.status for call in told["calls"]) for told in sets)
    over = max(calls, key=lambda pair: pair[1].memory_mb - memory[command_of(pair[1])])
    slowest = max(calls, key=lambda pair: pair[1].seconds)
    print(f"{len(sets)} data sets, {len(calls)} calls; {refused} sets are refused by a command")
    for each in wrong:
        print(f"  {', '.join(each['wrong'])}: {each['mutator']} {each['number']}: {each['said']}")
        print(f"    {' '.join(each['words'])}")
    print(f"wrong: {dict(counts) or 'nothing'}")
    if arguments.only or arguments.sets != SETS:
        return
    by_command: dict[str, Counter[str]] = {}
    for _, call in calls:
        of = by_command.setdefault(" ".join(w for w in command_of(call) if w != SET), Counter())
        of[str(call.status)] += 1
    data = {
        "command": "python benchmarks/hostile_data.py",
        "machine": describe_machine(),
        "sets": len(sets),
        "mutators": dict(sorted(Counter(told["mutator"] for told in sets).items())),
        "refused_sets": refused,
        "calls": len(calls),
        "calls_by_status": {name: dict(sorted(of.items())) for name, of in by_command.items()},
        "most_memory_over_own_mb": round(over[1].memory_mb - memory[command_of(over[1])], 1),
        "most_memory_by": over[0]["mutator"],
        "slowest_s": slowest[1].seconds,
        "slowest_by": slowest[0]["mutator"],
        "wrong": {
            name: counts.get(name, 0)
            for name in (
                *(
                    "executed",
                    "read elsewhere",
                    "wrote elsewhere",
                    "opened a socket",
                    "started a program",
                    "hung",
                ),
                *("memory", "showed a traceback", "exit 70", "died"),
            )
        },
        "wrong_calls": list(wrong),
    }
    RESULTS.write_text(json.dumps(data, indent=2) + "\n")


if __name__ == "__main__":
    sys.exit(main())
