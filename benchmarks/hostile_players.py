"""Policies, certificates, runs and policy servers that were made to do harm, given to commands.

    python benchmarks/hostile_players.py [--scale 1.0] [--only KIND] [--seed 0]

A sound policy, certificate and run of the task reach are changed by the functions in `hostile_runs`
and then given to `evaluate`, `evaluate --verify`, `plot` and `train --resume`. Policy servers of
all behaviours in `hostile_servers` are played by `evaluate`. Each call runs in a watched process
(see `strangers`). None may execute what comes along, read or write files elsewhere, open a socket
(but to the server), start a program, hang, take over 500 MB more than the same command on what is
sound, show a traceback, or end with status 70; and no certificate whose claims were changed may be
verified.

Writes benchmarks/results/hostile_players.json. For Linux on x86-64, on a file system that records
when files are read.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import hostile_runs
import hostile_servers
import numpy as np
from hostile_data import aside, remove
from machine import describe_machine
from strangers import Call, Watch
from tqdm import tqdm

RESULTS = Path(__file__).parent / "results" / "hostile_players.json"

COUNTS = {"policies": 300, "certificates": 60, "servers": 50, "runs": 60}
MOST_MB = 500.0

SHORT = ("--episodes", "1", "--controls", "0", "--jobs", "1")
OUT = "OUT"
COMMANDS: dict[str, tuple[tuple[str, ...], ...]] = {
    "policies": (("evaluate", "policy.npz", *SHORT),),
    "certificates": (("evaluate", "--verify", "certificate.json", "--jobs", "1"),),
    "servers": (("evaluate", "SERVER", *SHORT),),
    "runs": (
        ("evaluate", "run", *SHORT),
        ("plot", "run", "--out", OUT),
        ("train", "--resume", "run"),
    ),
}

TRAIN = (
    *("train", "reach", "--steps", "60", "--out", "run", "--seed", "1"),
    *("--evaluate-every", "30", "--evaluate-episodes", "1", "--checkpoint-every", "30"),
    *("--film-every", "0", "--set", "hidden=[8]", "batch=4"),
)

Changed = tuple[str, bool]
"""Name of a change, and whether it changes what a certificate claims."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scale", type=float, default=1.0, help="share of all of them")
    parser.add_argument("--only", choices=sorted(COUNTS))
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    kinds = [arguments.only] if arguments.only else list(COUNTS)
    counts = {kind: max(1, round(COUNTS[kind] * arguments.scale)) for kind in kinds}
    load_all()
    with tempfile.TemporaryDirectory() as folder:
        watch = Watch(Path(folder))
        watch.check_itself()
        make_sound(watch)
        outside = hostile_runs.Outside(
            watch.secret("secret.txt", b"secret\n" * 100),
            watch.secret("policy.npz", (watch.scratch / "policy.npz").read_bytes()),
            trap(watch),
        )
        with served() as ports:
            trials = {
                kind: try_kind(watch, kind, counts[kind], outside, ports, arguments.seed)
                for kind in kinds
            }
    return report(counts, trials)


# --- what is sound


def load_all() -> None:
    """Load what commands load, so that calls need not."""
    import msgpack  # noqa: F401
    import torch
    import websockets.sync.client  # noqa: F401

    import taskbuilder.cli.evaluate_command
    import taskbuilder.cli.plot_command
    import taskbuilder.cli.train_command
    import taskbuilder.learn.training
    import taskbuilder.raster.filling  # noqa: F401

    torch.set_num_threads(1)


def make_sound(watch: Watch) -> None:
    """Make a run, a policy and a certificate in the scratch folder."""
    from taskbuilder.cli import main as taskbuilder

    begun = Path.cwd()
    os.chdir(watch.scratch)
    certified = ("evaluate", "policy.npz", "--episodes", "2", "--controls", "1", "--jobs", "1")
    try:
        with Path(os.devnull).open("w") as sink, redirect_stdout(sink), redirect_stderr(sink):
            made = [taskbuilder(TRAIN)]
            shutil.copy("run/policy.npz", "policy.npz")
            made += [taskbuilder([*certified, "--certificate", "certificate.json"])]
            made += [taskbuilder(["plot", "run", "--out", "plot.png"])]
    finally:
        os.chdir(begun)
    if any(made):
        raise SystemExit(f"what is sound could not be made: {made}")
    sound = watch.scratch / "sound"
    sound.mkdir()
    for name in ("run", "policy.npz", "certificate.json"):
        (watch.scratch / name).rename(sound / name)
        restore(watch, name)


def restore(watch: Watch, name: str) -> None:
    """Put what is sound in its place."""
    place, sound = watch.scratch / name, watch.scratch / "sound" / name
    if place.is_dir() and not place.is_symlink():
        remove(place)
    place.unlink(missing_ok=True)
    shutil.copytree(sound, place) if sound.is_dir() else shutil.copy(sound, place)


def trap(watch: Watch) -> Path:
    """A task that tells that it was executed."""
    from hostile_data import OWN

    for name, text in OWN.items():
        (watch.scratch / name).write_text(text)
    with (watch.scratch / "mine.py").open("a") as file:
        file.write(watch.program("the task of a run"))
    return watch.scratch / "mine.yaml"


class served:  # noqa: N801  # a context manager
    """The servers of `hostile_servers`, in a process of their own: their ports by name."""

    def __enter__(self) -> dict[str, int]:
        command = [sys.executable, hostile_servers.__file__]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        assert self._process.stdout
        ports: dict[str, int] = json.loads(self._process.stdout.readline())
        return ports

    def __exit__(self, *_: object) -> None:
        self._process.communicate()


# --- trials


def try_kind(
    watch: Watch,
    kind: str,
    count: int,
    outside: hostile_runs.Outside,
    ports: dict[str, int],
    seed: int,
) -> list[dict[str, Any]]:
    """Give what is sound and then what is hostile to the commands of a kind."""
    for name in ("run", "policy.npz", "certificate.json"):
        restore(watch, name)
    sound = call_all(watch, kind, ports[hostile_servers.SOUND])
    for call in sound:
        if call.status or call.wrongs(call.memory_mb, MOST_MB):
            raise SystemExit(f"{' '.join(call.words)} fails on what is sound: {call}")
    own = [call.memory_mb for call in sound]
    names = [name for name in ports if name != hostile_servers.SOUND]
    trials = []
    for number in tqdm(range(count), desc=kind, disable=None):
        rng = np.random.default_rng([seed, number, len(kind)])
        if kind == "servers":
            name, claims = names[number % len(names)], False
        else:
            name, claims = changed(watch, kind, number, rng, outside)
        calls = call_all(watch, kind, ports.get(name, 0))
        for call, own_mb in zip(calls, own, strict=True):
            wrong = list(call.wrongs(own_mb, MOST_MB))
            if claims and not call.status:
                wrong.append("believed")
            if wrong:
                tqdm.write(f"{name} {number}: {', '.join(wrong)}: {call.words}: {call.said}")
            over = call.memory_mb - own_mb
            trials.append(
                {"name": name, "number": number, "wrong": wrong, "over": over} | vars(call)
            )
    print(f"{kind}: {count} are done", flush=True)
    return trials


def changed(
    watch: Watch, kind: str, number: int, rng: np.random.Generator, outside: hostile_runs.Outside
) -> Changed:
    """Put what is hostile in the place of what is sound."""
    file = {"policies": "policy.npz", "certificates": "certificate.json", "runs": "run"}[kind]
    restore(watch, file)
    mutators: Sequence[Callable[..., None]] = hostile_runs.MUTATORS[kind]
    mutator = mutators[number % len(mutators)]
    place = watch.scratch / file
    before = hostile_runs.claims(place) if kind == "certificates" else None
    aside(lambda: mutator(place, rng, outside))
    after = hostile_runs.claims(place) if kind == "certificates" else None
    return mutator.__name__, after is not None and after != before


def call_all(watch: Watch, kind: str, port: int) -> list[Call]:
    """Give what is in its place to all commands of a kind."""
    address = f"ws://127.0.0.1:{port}/reach?timeout=5"
    words = {OUT: str(watch.scratch / "plot.png"), "SERVER": address}
    return [
        watch.call([words.get(word, word) for word in command], sockets=kind == "servers")
        for command in COMMANDS[kind]
    ]


# --- results


def report(counts: dict[str, int], trials: dict[str, list[dict[str, Any]]]) -> int:
    """Print and write what came of all calls."""
    kinds = {}
    for kind, calls in trials.items():
        counted = Counter(what for call in calls for what in call["wrong"])
        worst = max(calls, key=lambda call: call["over"])
        slowest = max(calls, key=lambda call: call["seconds"])
        kinds[kind] = {
            "count": counts[kind],
            "of": len({call["name"] for call in calls}),
            "calls": len(calls),
            "calls_by_status": dict(sorted(Counter(str(c["status"]) for c in calls).items())),
            "most_memory_over_own_mb": round(worst["over"], 1),
            "most_memory_by": worst["name"],
            "slowest_s": slowest["seconds"],
            "slowest_by": slowest["name"],
            "wrong": {what: counted.get(what, 0) for what in WRONGS},
            "wrong_calls": [call for call in calls if call["wrong"]],
        }
        print(f"{kind}: {counts[kind]}, {len(calls)} calls; wrong: {dict(counted) or 'nothing'}")
    if set(kinds) == set(COUNTS):
        command = "python benchmarks/hostile_players.py"
        data = {"command": command, "full": COUNTS, "machine": describe_machine(), **kinds}
        RESULTS.write_text(json.dumps(data, indent=2) + "\n")
    return int(any(each["wrong_calls"] for each in kinds.values()))


WRONGS = (
    *("executed", "read elsewhere", "wrote elsewhere", "opened a socket", "started a program"),
    *("hung", "memory", "showed a traceback", "exit 70", "died", "believed"),
)

if __name__ == "__main__":
    sys.exit(main())
