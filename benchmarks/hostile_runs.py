"""Policies, certificates and runs that were made to do harm: functions that change a sound one.

Each takes the place of a copy, a generator, and what it may refer to elsewhere.
"""

from __future__ import annotations

import gzip
import io
import json
import os
import pickle
import shutil
import zipfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from taskbuilder.evaluation.certificate import seals

Rng = np.random.Generator


@dataclass(frozen=True)
class Outside:
    """What hostile files refer to elsewhere.

    Attributes:
        text: A file with text.
        policy: A sound policy.
        task: A task that tells that it was executed, in the working directory.
    """

    text: Path
    policy: Path
    task: Path


Mutator = Callable[[Path, Rng, Outside], None]

# --- bytes of any file


def flipped(file: Path, rng: Rng, _: Outside) -> None:
    """Some bits are others."""
    content = bytearray(file.read_bytes())
    for place in rng.integers(len(content), size=int(rng.integers(1, 9))):
        content[place] ^= 1 << int(rng.integers(8))
    file.write_bytes(content)


def cut(file: Path, rng: Rng, _: Outside) -> None:
    """Its end is gone."""
    content = file.read_bytes()
    file.write_bytes(content[: int(rng.integers(len(content)))])


def longer(file: Path, rng: Rng, _: Outside) -> None:
    """It has more bytes at its end."""
    file.write_bytes(file.read_bytes() + rng.bytes(int(rng.integers(1, 5000))))


def noise(file: Path, rng: Rng, _: Outside) -> None:
    """It has nothing but noise."""
    file.write_bytes(rng.bytes(5000))


def sparse(file: Path, _: Rng, __: Outside) -> None:
    """It has a tebibyte of nothing."""
    os.truncate(file, 1 << 40)


def fifo(file: Path, _: Rng, __: Outside) -> None:
    """Opening it waits."""
    file.unlink()
    os.mkfifo(file)


def endless(file: Path, _: Rng, __: Outside) -> None:
    """It never ends."""
    file.unlink()
    file.symlink_to("/dev/zero")


ANY_FILE = (flipped, cut, longer, noise, sparse, fifo, endless)

# --- JSON


def strange(rng: Rng, outside: Outside) -> Any:
    """A value that is not expected."""
    values: list[Any] = [
        *(None, True, -1, 0, 2**63, 10**400, 1e308, -0.5, "", [], {}),
        *("\x1b[2J", "\u202e", "x" * 100_000, "/proc/self/cwd/mine.yaml", str(outside.task)),
        *("../elsewhere/policy.npz", str(outside.policy), str(outside.text), "mine.yaml"),
        *("ws://127.0.0.1:1/reach", "expert:handover", "zoo:handover/demos", [[[[0]]]]),
        *([1e9, 1e9], [100_000, 100_000], {"a": {"b": 1}}, ["front"], list(range(20_000))),
    ]
    return values[int(rng.integers(len(values)))]


def edit(data: Any, rng: Rng, outside: Outside) -> None:
    """Put something strange somewhere in data, or take something away."""
    for _ in range(int(rng.integers(1, 4))):
        places = list(_places(data))
        container, key = places[int(rng.integers(len(places)))]
        if rng.random() < 0.15:
            del container[key]
            if not data:
                return
        else:
            container[key] = strange(rng, outside)


def _places(data: Any) -> Iterator[tuple[Any, Any]]:
    keys = list(data) if isinstance(data, dict) else range(min(len(data), 50))
    for key in keys:
        yield data, key
        if isinstance(data[key], dict | list):
            yield from _places(data[key])


def deep(rng: Rng) -> bytes:
    """JSON that is nested deeply."""
    depth = int(rng.choice([100, 5_000, 200_000]))
    return b'{"kind": ' + b"[" * depth + b"]" * depth + b"}"


# --- policies


def _read(file: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    with np.load(file) as parts:
        arrays = {name: parts[name] for name in parts.files}
    return json.loads(arrays.pop("about.json").tobytes()), arrays


def _write(file: Path, about: bytes, arrays: dict[str, np.ndarray], packed: int = 0) -> None:
    words = np.frombuffer(about, np.uint8)
    with zipfile.ZipFile(file, "w", packed) as made:
        for name, array in {"about.json": words, **arrays}.items():
            content = io.BytesIO()
            np.lib.format.write_array(content, array, allow_pickle=True)
            made.writestr(f"{name}.npy", content.getvalue())


def about_edited(file: Path, rng: Rng, outside: Outside) -> None:
    """It says something strange of itself."""
    about, arrays = _read(file)
    edit(about, rng, outside)
    _write(file, json.dumps(about).encode(), arrays)


def other_task(file: Path, rng: Rng, outside: Outside) -> None:
    """It names another task."""
    about, arrays = _read(file)
    names = ("mine.yaml", "./mine.yaml", str(outside.task), "/proc/self/cwd/mine.yaml", "mine")
    about["task"] = names[int(rng.integers(len(names)))]
    _write(file, json.dumps(about).encode(), arrays)


def large_pictures(file: Path, rng: Rng, _: Outside) -> None:
    """It asks for pictures of any size."""
    about, arrays = _read(file)
    size = int(rng.choice([4096, 10**6]))
    about["env"] |= {"cameras": ["front"] * 20, "camera_size": [size, size]}
    _write(file, json.dumps(about).encode(), arrays)


def about_deep(file: Path, rng: Rng, _: Outside) -> None:
    """Its words are nested deeply."""
    _, arrays = _read(file)
    _write(file, deep(rng), arrays)


def arrays_edited(file: Path, rng: Rng, _: Outside) -> None:
    """Arrays have other shapes, types or values."""
    about, arrays = _read(file)
    for _ in range(int(rng.integers(1, 4))):
        name = sorted(arrays)[int(rng.integers(len(arrays)))]
        array = np.atleast_1d(arrays[name])
        with np.errstate(invalid="ignore"):  # zeros times infinity
            infinite = array * np.inf
        others = [
            *(array * np.nan, infinite, array[None], array[:0], array.T, array.ravel()),
            *(array.astype(np.int64), array.astype(np.float64) * 1e300, array.astype("U8")),
            *(np.zeros((1, 2_000_000), np.float32), np.zeros((2_000_000, 1), np.float32)),
            *(np.zeros((2000, 1000), np.float32), np.float32(0), array.astype(np.float16)),
        ]
        arrays[name] = others[int(rng.integers(len(others)))]
    _write(file, json.dumps(about).encode(), arrays)


def names_edited(file: Path, rng: Rng, _: Outside) -> None:
    """Arrays have other names."""
    about, arrays = _read(file)
    names = ["arm/0/weight", "../../arm/0/weight", "arm/-1/bias", "arm/9999999999/weight", "x"]
    names += ["arm/x/bias", "\x1b[2J/0/weight", "other/0/weight", "/0/weight", "arm/1/w/bias"]
    for old in list(arrays):
        if rng.random() < 0.5:
            arrays[str(rng.choice(names))] = arrays.pop(old)
    _write(file, json.dumps(about).encode(), arrays)


def pickled(file: Path, _: Rng, outside: Outside) -> None:
    """An array is a pickle that runs a program."""

    class Runs:
        def __reduce__(self) -> tuple[Any, ...]:
            return exec, (outside.task.with_suffix(".py").read_text().splitlines()[-1],)

    about, arrays = _read(file)
    arrays["arm/0/weight"] = np.array([Runs()], dtype=object)
    _write(file, json.dumps(about).encode(), arrays)


def bare_pickle(file: Path, _: Rng, __: Outside) -> None:
    """It is a pickle as a whole."""
    file.write_bytes(pickle.dumps({"kind": "policy"}))


def bomb(file: Path, rng: Rng, _: Outside) -> None:
    """It unpacks to far more than it is."""
    about, arrays = _read(file)
    arrays["arm/0/weight"] = np.zeros((10_000, int(rng.choice([100, 10_000]))), np.float32)
    _write(file, json.dumps(about).encode(), arrays, zipfile.ZIP_DEFLATED)


def many_parts(file: Path, _: Rng, __: Outside) -> None:
    """It has very many arrays."""
    about, arrays = _read(file)
    arrays |= {f"arm/{number}/bias": np.zeros(1, np.float32) for number in range(30_000)}
    _write(file, json.dumps(about).encode(), arrays)


POLICY = (
    *(about_edited, about_edited, about_edited, about_edited, arrays_edited, arrays_edited),
    *(names_edited, other_task, large_pictures, about_deep, pickled, bare_pickle, bomb),
    *(many_parts, *ANY_FILE),
)

# --- certificates

UNCHECKED = ("made", "command", "versions", "processor", "system", "seals")
"""Sections of which nobody can say here whether they are true, or that decide nothing."""


def claims(file: Path) -> Any:
    """What a certificate claims that can be checked; None if it is none."""
    with suppress(OSError, ValueError, RecursionError, AttributeError):
        if file.is_file() and file.stat().st_size < 1 << 24:
            data = json.loads(file.read_bytes())
            return json.dumps({k: v for k, v in data.items() if k not in UNCHECKED}, sort_keys=True)
    return None


def resealed(file: Path, rng: Rng, outside: Outside) -> None:
    """Something in it is another, and it is sealed anew."""
    data = json.loads(file.read_bytes())
    edit(data, rng, outside)
    with suppress(KeyError, TypeError):
        data["seals"] = seals(data)
    file.write_text(json.dumps(data))


def section_resealed(file: Path, rng: Rng, outside: Outside) -> None:
    """Something in a section that counts is another, and it is sealed anew."""
    data = json.loads(file.read_bytes())
    name = str(rng.choice(["options", "results", "episodes", "digests"]))
    edit(data[name], rng, outside)
    with suppress(KeyError, TypeError):
        data["seals"] = seals(data)
    file.write_text(json.dumps(data))


def option_added(file: Path, rng: Rng, outside: Outside) -> None:
    """It has an option that was not played."""
    data = json.loads(file.read_bytes())
    names = ["horizon", "control_hz", "robots", "randomize", "position_noise", "grasp", "x"]
    data["options"][str(rng.choice(names))] = strange(rng, outside)
    data["seals"] = seals(data)
    file.write_text(json.dumps(data))


def seeds_doubled(file: Path, rng: Rng, _: Outside) -> None:
    """An episode counts several times."""
    data = json.loads(file.read_bytes())
    times = int(rng.integers(2, 9))
    data["seeds"] = data["seeds"][:1] * times
    data["episodes"]["policy"] = data["episodes"]["policy"][:1] * times
    data["seals"] = seals(data)
    file.write_text(json.dumps(data))


def policy_named(file: Path, rng: Rng, outside: Outside) -> None:
    """It names a policy elsewhere, or a link to one."""
    data = json.loads(file.read_bytes())
    link = file.with_name("link.npz")
    link.unlink(missing_ok=True)
    link.symlink_to(outside.policy)
    names = ["link.npz", str(outside.policy), "elsewhere/../elsewhere/policy.npz", "ws://h:1/reach"]
    data["policy"] = str(rng.choice([*names, "mine.yaml", "\x1b[2J"]))
    data["digests"]["policy"] = {data["policy"]: next(iter(data["digests"]["policy"].values()))}
    data["seals"] = seals(data)
    file.write_text(json.dumps(data))


def text_deep(file: Path, rng: Rng, _: Outside) -> None:
    """It is nested deeply."""
    file.write_bytes(deep(rng))


def many_values(file: Path, _: Rng, __: Outside) -> None:
    """It has very many values."""
    file.write_bytes(b'{"kind": "taskbuilder certificate", "x": [' + b"[]," * 8_000_000 + b"0]}")


CERTIFICATE = (
    *(resealed, section_resealed, option_added, seeds_doubled, policy_named, resealed),
    *(section_resealed, option_added, text_deep, many_values, resealed, section_resealed),
    *ANY_FILE,
)

# --- runs


def plan_edited(run: Path, rng: Rng, outside: Outside) -> None:
    """Its plan says something strange."""
    data = json.loads((run / "run.json").read_bytes())
    edit(data, rng, outside)
    (run / "run.json").write_text(json.dumps(data))


def task_named(run: Path, rng: Rng, outside: Outside) -> None:
    """It names a task elsewhere, or brings one."""
    for name in ("mine.yaml", "mine.py"):
        shutil.copy(outside.task.with_name(name), run / name)
    data = json.loads((run / "run.json").read_bytes())
    names = [str(outside.task), "/proc/self/cwd/mine.yaml", "mine.yaml", "run/mine.yaml", "mine"]
    names += [str(run / "mine.yaml"), f"{run}/../mine.yaml", "/proc/self/cwd/run/../mine.yaml"]
    data["task"] = str(rng.choice(names))
    (run / "run.json").write_text(json.dumps(data))


def files_of(run: Path) -> list[Path]:
    """All files of a run."""
    return sorted(file for file in run.rglob("*") if file.is_file())


def any_file_changed(run: Path, rng: Rng, outside: Outside) -> None:
    """A file of it is damaged, a device, or without end."""
    files = files_of(run)
    mutator = ANY_FILE[int(rng.integers(len(ANY_FILE)))]
    file = files[int(rng.integers(len(files)))]
    if file.stat().st_size:
        mutator(file, rng, outside)


def linked(run: Path, rng: Rng, outside: Outside) -> None:
    """A file of it is a link to a file elsewhere."""
    names = [file.relative_to(run) for file in files_of(run)]
    name = [*names, Path(".lock"), Path("episodes.csv")][int(rng.integers(len(names) + 2))]
    (run / name).unlink(missing_ok=True)
    (run / name).symlink_to(outside.policy if name.suffix == ".npz" else outside.text)


def folder_linked(run: Path, _: Rng, outside: Outside) -> None:
    """A folder of it is a link to one elsewhere."""
    for folder in [file for file in run.iterdir() if file.is_dir()]:
        shutil.rmtree(folder)
        folder.symlink_to(outside.text.parent)


def table_bomb(run: Path, _: Rng, __: Outside) -> None:
    """A table unpacks to far more than it is."""
    (run / "episodes.csv").unlink(missing_ok=True)
    with gzip.open(run / "episodes.csv.gz", "wb", compresslevel=1) as file:
        for _ in range(1000):
            file.write(bytes(1 << 20))


def policy_changed(run: Path, rng: Rng, outside: Outside) -> None:
    """Its policy is hostile."""
    POLICY[int(rng.integers(len(POLICY)))](run / "policy.npz", rng, outside)


RUN = (
    *(plan_edited, task_named, any_file_changed, linked, policy_changed, plan_edited),
    *(table_bomb, any_file_changed, folder_linked, task_named, linked),
)

MUTATORS: dict[str, tuple[Mutator, ...]] = {
    "policies": POLICY,
    "certificates": CERTIFICATE,
    "runs": RUN,
}
