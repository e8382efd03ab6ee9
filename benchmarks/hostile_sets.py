"""Data sets that were made to do harm: functions that change a sound one.

Each takes the folder of a copy, a generator, and what it may refer to outside of the folder. Most
attackers write the digests anew after what they changed (`reseal`).
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import shutil
import stat
import struct
import zipfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np

Rng = np.random.Generator


@dataclass(frozen=True)
class Outside:
    """What a hostile data set refers to outside of its folder.

    Attributes:
        text: A file with text.
        video: A video that is like those of the data set.
        program: Python code that tells that it was executed.
    """

    text: Path
    video: Path
    program: str


Mutator = Callable[[Path, Rng, Outside], None]

MUTATORS: dict[str, Mutator] = {}
"""All mutators by name."""

UNSEALED = ("flipped", "cut", "emptied", "longer", "gone")
"""Mutators of which every other time the digests stay as they were."""


def mutator(function: Mutator) -> Mutator:
    """Add a function to `MUTATORS`."""
    MUTATORS[function.__name__] = function
    return function


# --- what mutators use


def files_in(folder: Path) -> list[Path]:
    """All plain files of a data set, in order."""
    found = []
    for place, _, names in os.walk(folder):  # which leaves out folders that are too deep to read
        for name in names:
            file = Path(place, name)
            with suppress(OSError):
                found += [file] if stat.S_ISREG(file.lstat().st_mode) else []
    return sorted(found)


def any_file(folder: Path, rng: Rng, pattern: str = "*") -> Path:
    """A file at random."""
    files = [file for file in files_in(folder) if file.match(pattern)]
    return files[int(rng.integers(len(files)))]


def episode_of(folder: Path) -> Path:
    """The folder of the first episode; it is the one that is filmed and replayed."""
    return min((folder / "episodes").iterdir())


def reseal(folder: Path) -> None:
    """Write all digests anew, as far as files can be read."""
    files = files_in(folder)
    for about in (file for file in files if file.name == "episode.json"):
        with suppress(ValueError, KeyError, TypeError, OSError, RecursionError):
            data = json.loads(about.read_bytes()) if about.stat().st_size < 1 << 28 else {}
            for name in data["files"]:
                if about.parent / name in files:
                    data["files"][name] = _digest(about.parent / name)
            about.write_text(json.dumps(data, indent=1) + "\n")
    names = {f.relative_to(folder).as_posix(): f for f in files_in(folder)}
    digests = {n: _digest(f) for n, f in names.items() if n != "manifest.json"}
    sorted_json = json.dumps(digests, sort_keys=True, ensure_ascii=True)
    seal = hashlib.sha256(sorted_json.encode(errors="replace")).hexdigest()
    kind = {"kind": "taskbuilder data set: manifest", "format": 1}
    manifest = folder / "manifest.json"
    if manifest.exists() and not manifest.is_file():
        return  # a FIFO would wait for a reader
    with suppress(OSError):
        data = {**kind, "seal": seal, "files": digests}
        manifest.write_text(json.dumps(data, indent=1) + "\n")


def _digest(file: Path) -> str:
    if file.stat().st_size > 1 << 30:
        return "0" * 64
    return hashlib.sha256(file.read_bytes()).hexdigest()


def edit(file: Path, change: Callable[[Any], Any]) -> None:
    """Change the data of a JSON file."""
    data = json.loads(file.read_bytes())
    changed = change(data)
    file.write_text(json.dumps(data if changed is None else changed, indent=1))


def places_of(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The paths of all values inside some data."""
    items = data.items() if isinstance(data, dict) else ()
    items = enumerate(data) if isinstance(data, list) else items
    for key, value in items:
        yield (*path, key)
        yield from places_of(value, (*path, key))


def put(data: Any, path: tuple[Any, ...], value: Any) -> None:
    """Put a value at a path inside some data."""
    for key in path[:-1]:
        data = data[key]
    data[path[-1]] = value


def edit_arrays(folder: Path, change: Callable[[dict[str, Any]], None]) -> None:
    """Change the arrays of the first episode."""
    file = episode_of(folder) / "arrays.npz"
    with zipfile.ZipFile(file) as packed:
        parts = {name: packed.read(name) for name in packed.namelist()}
    words = parts.pop("about.json.npy")
    arrays = {name: np.load(io.BytesIO(content)) for name, content in parts.items()}
    change(arrays)
    with zipfile.ZipFile(file, "w") as packed:
        packed.writestr("about.json.npy", words)
        for name, array in arrays.items():
            packed.writestr(name, array if isinstance(array, bytes) else npy(array))


def npy(array: Any) -> bytes:
    """An array as a .npy file, pickled if it must be."""
    file = io.BytesIO()
    np.lib.format.write_array(file, np.asanyarray(array), allow_pickle=True)
    return file.getvalue()


def header(shape: str, descr: str = "<f8") -> bytes:
    """A .npy file without data, with a header of one's own."""
    text = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    text += b" " * (-(len(text) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text


class Pickled:
    """What executes code when it is unpickled."""

    def __init__(self, program: str) -> None:
        self.program = program

    def __reduce__(self) -> tuple[Any, ...]:
        return exec, (self.program,)


def video(
    width: int, height: int, frames: int, container: str = "mp4", codec: str = "libx264rgb"
) -> bytes:
    """A video of black images."""
    file = io.BytesIO()
    with av.open(file, "w", format=container) as output:
        stream: Any = output.add_stream(codec, rate=10)
        stream.width, stream.height = width, height
        stream.pix_fmt = {"libx264rgb": "rgb24", "ffv1": "gray16le", "gif": "rgb8"}.get(
            codec, "yuv420p"
        )
        if codec == "libx264rgb":
            stream.options = {"qp": "0", "preset": "ultrafast"}
        black = av.VideoFrame.from_ndarray(np.zeros((height, width, 3), np.uint8), format="rgb24")
        black = black.reformat(format=stream.pix_fmt)
        for number in range(frames):
            black.pts, black.time_base = number, Fraction(1, 10)
            output.mux(stream.encode(black))
        output.mux(stream.encode(None))
    return file.getvalue()


def replace_video(folder: Path, content: bytes, pattern: str = "front.mp4") -> None:
    """Replace the video of every episode."""
    for file in folder.glob(f"episodes/*/{pattern}"):
        file.write_bytes(content)


# --- bytes


@mutator
def flipped(folder: Path, rng: Rng, _: Outside) -> None:
    file = any_file(folder, rng)
    content = bytearray(file.read_bytes())
    for place in rng.integers(len(content), size=int(rng.integers(1, 9))):
        content[int(place)] ^= int(rng.integers(1, 256))
    file.write_bytes(bytes(content))


@mutator
def cut(folder: Path, rng: Rng, _: Outside) -> None:
    file = any_file(folder, rng)
    file.write_bytes(file.read_bytes()[: int(rng.integers(file.stat().st_size))])


@mutator
def emptied(folder: Path, rng: Rng, _: Outside) -> None:
    any_file(folder, rng).write_bytes(b"")


@mutator
def longer(folder: Path, rng: Rng, _: Outside) -> None:
    with any_file(folder, rng).open("ab") as file:
        file.write(rng.bytes(int(rng.integers(1, 5000))))


@mutator
def sparse(folder: Path, rng: Rng, _: Outside) -> None:
    """A file of zeros that takes no room on the disk, and far more than there is in memory."""
    os.truncate(any_file(folder, rng), int(rng.choice([1 << 30, 1 << 34, 1 << 40])))


@mutator
def gone(folder: Path, rng: Rng, _: Outside) -> None:
    any_file(folder, rng).unlink()


@mutator
def exchanged(folder: Path, rng: Rng, _: Outside) -> None:
    one, other = any_file(folder, rng), any_file(folder, rng)
    first, second = one.read_bytes(), other.read_bytes()
    one.write_bytes(second)
    other.write_bytes(first)


# --- JSON

VALUES: tuple[Any, ...] = (
    *(None, True, -1, 0, 0.5, 10**30, -(10**18), 1e308, float("nan"), float("inf")),
    *("", "x" * 100_000, "\x1b[2J\x1b]0;title\x07", "\ud800", "../../etc/passwd", "/dev/zero"),
    *("a\nb", "\u202egpj.exe", [], {}, [[]], {"": {}}, [1] * 1000),
)


@mutator
def retyped(folder: Path, rng: Rng, _: Outside) -> None:
    file = any_file(folder, rng, "*.json")

    def change(data: Any) -> None:
        places = [path for path in places_of(data) if "files" not in path[:-1]]
        for _ in range(int(rng.integers(1, 4))):
            with suppress(KeyError, IndexError, TypeError):  # an earlier change took its place
                path = places[int(rng.integers(len(places)))]
                put(data, path, VALUES[int(rng.integers(len(VALUES)))])

    edit(file, change)


@mutator
def retyped_record(folder: Path, rng: Rng, _: Outside) -> None:
    """As `retyped`, in the file that all commands go by."""

    def change(data: Any) -> None:
        places = [
            path for path in places_of(data) if "files" not in path and "versions" not in path
        ]
        put(data, places[int(rng.integers(len(places)))], VALUES[int(rng.integers(len(VALUES)))])

    edit(folder / "dataset.json", change)


@mutator
def without_key(folder: Path, rng: Rng, _: Outside) -> None:
    def change(data: Any) -> None:
        places = [path for path in places_of(data) if isinstance(path[-1], str)]
        path = places[int(rng.integers(len(places)))]
        for key in path[:-1]:
            data = data[key]
        del data[path[-1]]

    edit(any_file(folder, rng, "*.json"), change)


@mutator
def numbers_changed(folder: Path, rng: Rng, _: Outside) -> None:
    """Numbers become others of the same type, in all files that say them."""

    def number(value: Any) -> bool:
        return isinstance(value, int | float) and not isinstance(value, bool)

    def change(data: Any) -> None:
        paths = [path for path in places_of(data) if number(_at(data, path))]
        path = paths[int(rng.integers(len(paths)))]
        put(data, path, int(rng.choice([0, 1, 2, 7, 1000, 100_000, 999_999, 2**31, 2**40])))

    edit(any_file(folder, rng, "*.json"), change)


def _at(data: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        data = data[key]
    return data


@mutator
def nested(folder: Path, rng: Rng, _: Outside) -> None:
    depth = int(rng.choice([40, 900, 100_000, 3_000_000]))
    file = any_file(folder, rng, "*.json")
    if rng.random() < 0.5:
        file.write_bytes(b"[" * depth + b"]" * depth)
    else:
        file.write_bytes(b'{"kind": ' * depth + b"1" + b"}" * depth)


@mutator
def nested_inside(folder: Path, rng: Rng, _: Outside) -> None:
    depth = int(rng.choice([20, 31, 300]))
    value: Any = 1
    for _ in range(depth):
        value = [value]
    file = any_file(folder, rng, "*.json")
    edit(file, lambda data: data.update({"more": value}))


@mutator
def many_values(folder: Path, rng: Rng, _: Outside) -> None:
    part = [b"[],", b"{},", b"0,", b'"",', b'{"a":0},'][int(rng.integers(5))]
    content = b'{"more": [' + part * int(rng.choice([300_000, 3_000_000])) + b"0]}"
    any_file(folder, rng, "*.json").write_bytes(content)


@mutator
def key_twice(folder: Path, rng: Rng, _: Outside) -> None:
    file = any_file(folder, rng, "*.json")
    file.write_text(file.read_text().replace("{", '{"steps": 3, "steps": 4,', 1))


@mutator
def long_number(folder: Path, rng: Rng, _: Outside) -> None:
    file = any_file(folder, rng, "*.json")
    digits = "9" * int(rng.choice([20, 4000, 1_000_000]))
    file.write_text(file.read_text().replace("{", f'{{"more": {digits},', 1))


# --- names


@mutator
def strange_file(folder: Path, rng: Rng, outside: Outside) -> None:
    names = [b"\x1b[31mred", b"new\nline", b"\xff\xfe", b"a" * 250, b"-rf", b"x.py", b"~"]
    name = names[int(rng.integers(len(names)))]
    places = [folder, folder / "episodes", episode_of(folder)]
    place = os.fsencode(places[int(rng.integers(len(places)))])
    Path(os.fsdecode(os.path.join(place, name))).write_text(outside.program)  # noqa: PTH118


@mutator
def programs_everywhere(folder: Path, rng: Rng, outside: Outside) -> None:
    del rng
    for place in (folder, folder / "episodes", episode_of(folder)):
        for name in ("reach", "random", "json", "env", "__init__", "sitecustomize", "conftest"):
            (place / f"{name}.py").write_text(outside.program)
    shutil.copy(folder / "dataset.json", folder / "reach.yaml")


@mutator
def task_renamed(folder: Path, rng: Rng, outside: Outside) -> None:
    """The task has the name of a file, beside which there is a program."""
    (folder / "evil.yaml").write_text("task: evil\n")
    (folder / "evil.py").write_text(outside.program)
    names = [str(folder / "evil.yaml"), str(folder / "evil"), "../reach", "..", "./reach", "a/b/c"]
    name = names[int(rng.integers(len(names)))]
    for file in (*folder.glob("*.json"), *folder.glob("episodes/*/episode.json")):
        text = file.read_text()
        text = text.replace('"reach":', f"{json.dumps(name)}:")
        file.write_text(text.replace(': "reach"', f": {json.dumps(name)}"))


@mutator
def camera_renamed(folder: Path, rng: Rng, _: Outside) -> None:
    name = ["../../x", "a/b", "..", "\x1b[2J", "x" * 300][int(rng.integers(5))]
    for file in (*folder.glob("*.json"), *folder.glob("episodes/*/episode.json")):
        file.write_text(file.read_text().replace('"front"', json.dumps(name)))


@mutator
def video_elsewhere(folder: Path, rng: Rng, outside: Outside) -> None:
    up = os.path.relpath(outside.video, episode_of(folder))
    name = [str(outside.video), up, "../../../dataset.json", "/dev/zero"][int(rng.integers(4))]
    key = ["video", "depth"][int(rng.integers(2))]

    def change(data: Any) -> None:
        data["cameras"]["front"][key] = name
        data["files"][name] = "0" * 64

    for file in folder.glob("episodes/*/episode.json"):
        edit(file, change)


@mutator
def robot_elsewhere(folder: Path, rng: Rng, outside: Outside) -> None:
    up = os.path.relpath(outside.text, folder)
    paths = [str(outside.text), up, "./robot.yaml", "/dev/zero", "panda/../panda"]
    robots = {"arm": paths[int(rng.integers(len(paths)))]}
    edit(folder / "dataset.json", lambda data: data["options"].update({"robots": robots}))


@mutator
def other_options(folder: Path, rng: Rng, _: Outside) -> None:
    options = [
        *({"horizon": 10**6}, {"control_hz": 1}, {"control_hz": 7}, {"flat": False}, {"no": 1}),
        *({"normalize": False}, {"render_camera": "none"}, {"cameras": ["none"]}),
        *({"camera_size": [4096, 4096]}, {"camera_size": [0, 0]}, {"variation": "random"}),
        *({"robots": {"arm": "ur5e"}}, {"robots": {"leg": "panda"}}, {"reward": "none"}),
        *({"observe": "scene"}, {"renderer": "tiny"}, {"position_noise": -1.0}, {"randomize": 2}),
    ]
    chosen = options[int(rng.integers(len(options)))]
    edit(folder / "dataset.json", lambda data: data["options"].update(chosen))


@mutator
def licence(folder: Path, rng: Rng, outside: Outside) -> None:
    texts = [
        *("MIT\n---\ntags: [evil]", "no", "a: b", "'", '"', "!!python/name:os.system", "&a *a"),
        *("<script>alert(1)</script>", "{{ 7 * 7 }}", "| a | b |", f"[x]({outside.text})"),
    ]
    text = texts[int(rng.integers(len(texts)))]
    edit(folder / "dataset.json", lambda data: data.update({"license": text}))


@mutator
def lengths(folder: Path, rng: Rng, _: Outside) -> None:
    """All files say that episodes are longer, or shorter, than their arrays."""
    steps = int(rng.choice([0, 1, 29, 31, 1000, 999_999]))

    def episode(data: Any) -> None:
        data["steps"] = steps
        data["cameras"]["front"]["frames"] = steps + 1

    def index(data: Any) -> None:
        for line in data["episodes"]:
            line["steps"] = steps

    def record(data: Any) -> None:
        for task in data["tasks"].values():
            task["max_episode_steps"] = max(1, steps)

    for file in folder.glob("episodes/*/episode.json"):
        edit(file, episode)
    edit(folder / "index.json", index)
    edit(folder / "dataset.json", record)
