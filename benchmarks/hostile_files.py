"""Data sets that were made to do harm, continued: arrays, links, videos, and tasks that come along.

See `hostile_sets`.
"""

from __future__ import annotations

import hashlib
import io
import os
import pickle
import shutil
import zipfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from hostile_sets import (
    Outside,
    Pickled,
    Rng,
    any_file,
    edit,
    edit_arrays,
    episode_of,
    header,
    mutator,
    npy,
    replace_video,
    video,
)

# --- arrays


def chosen(arrays: dict[str, Any], rng: Rng) -> str:
    """The name of an array at random."""
    names = sorted(arrays)
    return names[int(rng.integers(len(names)))]


@mutator
def reshaped(folder: Path, rng: Rng, _: Outside) -> None:
    def change(arrays: dict[str, Any]) -> None:
        name = chosen(arrays, rng)
        array = arrays[name]
        others = [
            *(array[:-1], np.concatenate([array, array]), array[None], array.reshape(-1)[:-1]),
            *(np.zeros((0, *array.shape[1:])), np.float64(3.0), array[:0], array.T),
        ]
        arrays[name] = others[int(rng.integers(len(others)))]

    edit_arrays(folder, change)


@mutator
def other_type(folder: Path, rng: Rng, _: Outside) -> None:
    def change(arrays: dict[str, Any]) -> None:
        name = chosen(arrays, rng)
        kinds = ["f2", "f4", "f8", "i1", "i8", "u8", "c16", "U3", "S3", "M8[s]", "?", ">f8"]
        with suppress(TypeError, ValueError):
            arrays[name] = arrays[name].astype(kinds[int(rng.integers(len(kinds)))])

    edit_arrays(folder, change)


@mutator
def not_finite(folder: Path, rng: Rng, _: Outside) -> None:
    def change(arrays: dict[str, Any]) -> None:
        floats = {name: array for name, array in arrays.items() if array.dtype.kind == "f"}
        array = floats[chosen(floats, rng)]
        array.reshape(-1)[int(rng.integers(array.size))] = rng.choice([np.nan, np.inf, -np.inf])

    edit_arrays(folder, change)


@mutator
def enormous(folder: Path, rng: Rng, _: Outside) -> None:
    def change(arrays: dict[str, Any]) -> None:
        name = ["agents/arm/action.npy", "agents/arm/observation.npy", "subtask.npy", "state.npy"]
        array = arrays[name[int(rng.integers(len(name)))]]
        array[...] = 3e38 if array.dtype.kind == "f" else 2**62

    edit_arrays(folder, change)


@mutator
def array_names(folder: Path, rng: Rng, _: Outside) -> None:
    def change(arrays: dict[str, Any]) -> None:
        old = chosen(arrays, rng)
        names = [
            "../../x",
            "/etc/passwd",
            "\x1b[2J",
            "agents",
            "agents/x",
            "agents/arm/y",
            "x" * 999,
        ]
        if rng.random() < 0.5:
            del arrays[old]
        else:
            arrays[f"{names[int(rng.integers(len(names)))]}.npy"] = np.zeros(3)

    edit_arrays(folder, change)


@mutator
def lying_header(folder: Path, rng: Rng, _: Outside) -> None:
    shapes = [
        "(10000000000,)",
        "(1 << 40,)",
        "(-1,)",
        "(0, 10**18)",
        "('a',)",
        "((" * 500,
        "9" * 9000,
    ]

    def change(arrays: dict[str, Any]) -> None:
        arrays[chosen(arrays, rng)] = header(shapes[int(rng.integers(len(shapes)))])

    edit_arrays(folder, change)


@mutator
def pickled(folder: Path, rng: Rng, outside: Outside) -> None:
    def change(arrays: dict[str, Any]) -> None:
        arrays[chosen(arrays, rng)] = npy(np.array([Pickled(outside.program)], dtype=object))

    edit_arrays(folder, change)


@mutator
def pickle_as_file(folder: Path, rng: Rng, outside: Outside) -> None:
    any_file(folder, rng).write_bytes(pickle.dumps(Pickled(outside.program)))


@mutator
def zip_bomb(folder: Path, rng: Rng, _: Outside) -> None:
    size = int(rng.choice([100 << 20, 1 << 30]))
    with (
        zipfile.ZipFile(
            episode_of(folder) / "arrays.npz", "w", zipfile.ZIP_DEFLATED, compresslevel=1
        ) as file,
        file.open("state.npy", "w", force_zip64=True) as part,
    ):
        part.write(header(f"({size // 8},)"))
        for _ in range(size >> 20):
            part.write(bytes(1 << 20))


@mutator
def overlapping_zip(folder: Path, rng: Rng, _: Outside) -> None:
    """Many names for the same bytes."""
    del rng
    content, file = npy(np.zeros(100_000)), io.BytesIO()
    with zipfile.ZipFile(file, "w") as packed:
        packed.writestr("state.npy", content)
        first = packed.infolist()[0]
        for number in range(5000):
            other = zipfile.ZipInfo(f"x{number}.npy")
            other.header_offset, other.CRC = first.header_offset, first.CRC
            other.file_size = other.compress_size = first.file_size
            packed.filelist.append(other)
    (episode_of(folder) / "arrays.npz").write_bytes(file.getvalue())


# --- what is no plain file


@mutator
def link(folder: Path, rng: Rng, outside: Outside) -> None:
    file = any_file(folder, rng)
    targets = [outside.text, outside.video, "/dev/zero", "/proc/self/mem", file.name, "nowhere"]
    file.unlink()
    file.symlink_to(targets[int(rng.integers(len(targets)))])


@mutator
def linked_folder(folder: Path, rng: Rng, outside: Outside) -> None:
    place = [episode_of(folder), folder / "episodes"][int(rng.integers(2))]
    moved = outside.text.parent / "moved"
    shutil.rmtree(moved, ignore_errors=True)
    if rng.random() < 0.5:
        place.rename(moved)
        place.symlink_to(moved)
    else:
        shutil.rmtree(place)
        place.symlink_to(["/", "/proc/self/fd", "."][int(rng.integers(3))])


@mutator
def fifo(folder: Path, rng: Rng, _: Outside) -> None:
    file = any_file(folder, rng)
    file.unlink()
    os.mkfifo(file)


@mutator
def new_fifo(folder: Path, rng: Rng, _: Outside) -> None:
    places = [folder, folder / "episodes", episode_of(folder)]
    os.mkfifo(places[int(rng.integers(3))] / "more.json")


@mutator
def device(folder: Path, rng: Rng, outside: Outside) -> None:
    """A device of endless bytes; where only root may make one, a socket of this machine."""
    file = any_file(folder, rng)
    file.unlink()
    try:
        os.mknod(file, 0o600 | 0o020000, os.makedev(1, 5))  # a character device: /dev/zero
    except PermissionError:
        link(folder, rng, outside)


@mutator
def folder_instead(folder: Path, rng: Rng, _: Outside) -> None:
    file = any_file(folder, rng)
    file.unlink()
    file.mkdir()
    (file / "more").write_bytes(b"more")


@mutator
def deep_folders(folder: Path, rng: Rng, _: Outside) -> None:
    del rng
    here = os.open(folder, os.O_RDONLY)
    try:
        for _ in range(300):  # far longer than a path may be
            os.mkdir("d" * 60, dir_fd=here)  # only by a descriptor
            there = os.open("d" * 60, os.O_RDONLY, dir_fd=here)
            os.close(here)
            here = there
    finally:
        os.close(here)


@mutator
def unreadable(folder: Path, rng: Rng, _: Outside) -> None:
    any_file(folder, rng).chmod(0)


# --- videos


@mutator
def playlist(folder: Path, rng: Rng, outside: Outside) -> None:
    near = os.path.relpath(outside.video, episode_of(folder))
    texts = [
        *(f"ffconcat version 1.0\nfile {name}\n" for name in (near, outside.video)),
        f"ffconcat version 1.0\nfile '{outside.video}'\nduration 3\n",
        f"#EXTM3U\n#EXT-X-TARGETDURATION:3\n#EXTINF:3,\n{outside.video}\n#EXT-X-ENDLIST\n",
        f"#EXTM3U\n#EXT-X-TARGETDURATION:3\n#EXTINF:3,\nfile://{outside.video}\n#EXT-X-ENDLIST\n",
        "#EXTM3U\n#EXT-X-TARGETDURATION:3\n#EXTINF:3,\nhttp://127.0.0.1:9/a.ts\n#EXT-X-ENDLIST\n",
        f'<?xml version="1.0"?><MPD><Period><BaseURL>{outside.video}</BaseURL></Period></MPD>',
        f"[playlist]\nFile1={outside.video}\n",
    ]
    text = texts[int(rng.integers(len(texts)))].encode()
    replace_video(folder, text, ["front.mp4", "front.depth.mkv"][int(rng.integers(2))])


@mutator
def session(folder: Path, rng: Rng, _: Outside) -> None:
    """A description of a stream, which has FFmpeg open ports."""
    port = int(rng.integers(10_000, 60_000)) // 2 * 2
    text = (
        "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\n"
        f"m=video {port} RTP/AVP 96\na=rtpmap:96 H264/90000\n"
    ).encode()
    replace_video(folder, text, ["front.mp4", "front.depth.mkv"][int(rng.integers(2))])


@mutator
def other_format(folder: Path, rng: Rng, outside: Outside) -> None:
    first = episode_of(folder)
    made = [
        lambda: (first / "front.depth.mkv").read_bytes(),
        lambda: video(32, 32, 31, "matroska"),
        lambda: video(32, 32, 31, "avi", "mpeg4"),
        lambda: video(32, 32, 31, "mp4", "mpeg4"),
        lambda: video(32, 32, 31, "gif", "gif"),
        lambda: video(32, 32, 31, "mpegts", "libx264"),
        lambda: outside.text.read_bytes(),
    ]
    content = made[int(rng.integers(len(made)))]()
    replace_video(folder, content, ["front.mp4", "front.depth.mkv"][int(rng.integers(2))])


@mutator
def video_bomb(folder: Path, rng: Rng, _: Outside) -> None:
    """Few bytes that become many images or large ones; the record stays as it was."""
    size, frames = [(2048, 31), (4096, 8), (32, 5000), (8192, 2)][int(rng.integers(4))]
    replace_video(folder, video(size, size, frames))


@mutator
def patched_video_bomb(folder: Path, rng: Rng, _: Outside) -> None:
    """As `video_bomb`, with a header that tells what the record tells."""
    size = int(rng.choice([2048, 4096, 8192]))
    content = video(size, size, 31 if size < 4096 else 4)
    right, wrong = (32).to_bytes(2, "big"), size.to_bytes(2, "big")
    content = content.replace(wrong + wrong, right + right)
    content = content.replace(wrong + b"\0\0" + wrong + b"\0\0", right + b"\0\0" + right + b"\0\0")
    replace_video(folder, content)


@mutator
def recorded_video_bomb(folder: Path, rng: Rng, _: Outside) -> None:
    """As `video_bomb`, and everything in the data set tells the same size."""
    size = int(rng.choice([1024, 2048, 4096]))
    replace_video(folder, video(size, size, 31))

    def camera(about: Any) -> None:
        about["width"] = about["height"] = size

    for file in folder.glob("episodes/*/episode.json"):
        edit(file, lambda data: camera(data["cameras"]["front"]))

    def record(data: Any) -> None:
        data["collected"]["size"] = [size, size]
        for task in data["tasks"].values():
            camera(task["cameras"]["front"])

    edit(folder / "dataset.json", record)


@mutator
def damaged_video(folder: Path, rng: Rng, _: Outside) -> None:
    for file in episode_of(folder).glob("front.*"):
        content = bytearray(file.read_bytes())
        for place in rng.integers(len(content), size=int(rng.integers(1, 60))):
            content[int(place)] = int(rng.integers(256))
        file.write_bytes(bytes(content))


@mutator
def referring_video(folder: Path, rng: Rng, outside: Outside) -> None:
    """An MP4 file that says that its images are in another file (a Macintosh alias)."""
    del rng
    path = str(outside.video).encode()
    path += b"\0" * (len(path) % 2)
    alias = bytes(10 + 1 + 27 + 12 + 1 + 63 + 16) + b"\0\x01\0\x01" + bytes(16)
    alias += b"\0\x02" + len(path).to_bytes(2, "big") + path + b"\xff\xff\0\0"
    other = (12 + len(alias)).to_bytes(4, "big") + b"alis\0\0\0\0" + alias
    own = b"\0\0\0\x0curl \0\0\0\x01"
    for file in folder.glob("episodes/*/front.mp4"):
        content = bytearray(file.read_bytes())
        for box in (b"moov", b"trak", b"mdia", b"minf", b"dinf", b"dref"):
            at = content.index(box) - 4
            size = int.from_bytes(content[at : at + 4], "big") + len(other) - len(own)
            content[at : at + 4] = size.to_bytes(4, "big")
        file.write_bytes(bytes(content).replace(own, other))


# --- the task that comes along


@mutator
def carried_changed(folder: Path, rng: Rng, outside: Outside) -> None:
    for file in folder.glob("tasks/*/*.py"):
        file.write_text(file.read_text() + outside.program * int(rng.integers(1, 3)))


@mutator
def carried_elsewhere(folder: Path, rng: Rng, outside: Outside) -> None:
    up = os.path.relpath(outside.text, folder / "tasks" / "mine")
    names = [up, str(outside.text), "../../../evil.py", "/tmp/evil.py", "a//b.py", ".", "a/../b"]
    name = names[int(rng.integers(len(names)))]

    def change(data: Any) -> None:
        for task in data["tasks"].values():
            carried = task.get("carried") or {"file": "mine.yaml", "folders": [], "files": {}}
            carried["files"][name] = "0" * 64
            if rng.random() < 0.5:
                carried["file"] = name
            if rng.random() < 0.3:
                carried["folders"] = [name]
            task["carried"] = carried

    edit(folder / "dataset.json", change)


@mutator
def carried_as_packaged(folder: Path, rng: Rng, outside: Outside) -> None:
    """A program comes along under the name of a task of the package."""
    del rng
    place = folder / "tasks" / "reach"
    place.mkdir(parents=True, exist_ok=True)
    files = {"reach.yaml": b"task: reach\n", "reach.py": outside.program.encode()}
    for name, content in files.items():
        (place / name).write_bytes(content)
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}

    def change(data: Any) -> None:
        for task in data["tasks"].values():
            task["carried"] = {"file": "reach.yaml", "folders": [], "files": digests}
            task["files"] = {**task["files"], **digests}

    edit(folder / "dataset.json", change)


@mutator
def carried_bytes(folder: Path, rng: Rng, _: Outside) -> None:
    """Bytes of a task that comes along are others, and all digests are right again."""
    for file in folder.glob("tasks/mine/*"):
        content = bytearray(file.read_bytes())
        content[int(rng.integers(len(content)))] ^= int(rng.integers(1, 256))
        file.write_bytes(bytes(content))

    def change(data: Any) -> None:
        for task in data["tasks"].values():
            for name in (task.get("carried") or {"files": ()})["files"]:
                with suppress(OSError):
                    content = (folder / "tasks/mine" / name).read_bytes()
                    task["carried"]["files"][name] = hashlib.sha256(content).hexdigest()

    edit(folder / "dataset.json", change)
