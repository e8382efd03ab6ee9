"""Where the files of a data set are, how they are written, and the manifest of all of them."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from secrets import token_hex
from typing import Any

from taskbuilder.arrays import Arrays, StoreError, packed_arrays, read_arrays
from taskbuilder.data.recording import EpisodeData
from taskbuilder.data.videos import DEPTH, VIDEO, encoded, encoded_depth
from taskbuilder.digests import digest, digest_of
from taskbuilder.errors import UsageError, display_path
from taskbuilder.files import claim, write_whole

FORMAT = 1
"""Version of the format; others are refused."""

KIND = "taskbuilder data set"
ABOUT, INDEX, MANIFEST, CARD = "dataset.json", "index.json", "manifest.json", "README.md"
EPISODES, FAILURES, PARTIAL = "episodes", "failures", ".partial"
EPISODE, ARRAYS = "episode.json", "arrays.npz"

OWN = (ABOUT, INDEX, MANIFEST, CARD, EPISODES, FAILURES, PARTIAL)
"""Everything that may lie in the folder of a data set."""

_ARRAYS_KIND = "episode"
_LARGEST_JSON = 256 << 20


def write_json(path: Path, data: Any) -> None:
    """Write JSON, whole and synced.

    Raises:
        OSError: It cannot be written.
    """
    write_whole(path, json_bytes(data), sync=True)


def json_bytes(data: Any) -> bytes:
    """JSON as all files of a data set have it."""
    return (json.dumps(data, indent=1, ensure_ascii=True) + "\n").encode()


def read_json(path: Path) -> dict[str, Any]:
    """Read a JSON object of a data set.

    Raises:
        StoreError: It is damaged.
        OSError: It cannot be read.
    """
    name = display_path(path)
    if path.stat().st_size > _LARGEST_JSON:
        raise StoreError(f"{name} is too large to be a part of a data set")
    try:
        data = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise StoreError(f"{name} is damaged ({error})") from None
    if not isinstance(data, dict):
        raise StoreError(f"{name} is damaged: it is no object")
    return data


def read_about(folder: Path) -> dict[str, Any]:
    """What a data set says of itself.

    Raises:
        UsageError: The folder is no data set, or one of another version.
        StoreError: It is damaged.
    """
    file = folder / ABOUT
    if not file.is_file():
        raise UsageError(f"{display_path(folder)} is no data set; it has no {ABOUT}")
    about = read_json(file)
    if about.get("kind") != KIND:
        raise UsageError(f"{display_path(folder)} is no data set of taskbuilder")
    if about.get("format") != FORMAT:
        found = about.get("format")
        raise UsageError(f"{display_path(folder)} has format {found}; this version reads {FORMAT}")
    return about


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder for one process alone.

    Raises:
        UsageError: Another process holds it.
    """
    handle = os.open(folder, os.O_RDONLY)
    try:
        if not claim(handle):
            raise UsageError(f"another process collects into {display_path(folder)} now")
        yield
    finally:
        os.close(handle)


# --- episodes


Files = dict[str, bytes]
"""The contents of files, by name."""


def episode_files(name: str, data: EpisodeData) -> Files:
    """The files of an episode.

    Args:
        name: Of the episode.
        data: The episode.
    """
    files = {ARRAYS: packed_arrays(data.arrays, {"kind": _ARRAYS_KIND, "name": name})}
    videos: dict[str, dict[str, Any]] = {}
    fps = data.about["control_hz"]
    for camera, images in data.images.items():
        height, width = images[0].shape[:2]
        size = {"width": width, "height": height, "fps": fps, "frames": len(images)}
        videos[camera] = {**size, "video": f"{camera}{VIDEO}"}
        files[f"{camera}{VIDEO}"] = encoded(images, fps)
    for camera, depths in data.depths.items():
        videos[camera]["depth"] = f"{camera}{DEPTH}"
        files[f"{camera}{DEPTH}"] = encoded_depth(depths, fps)
    digests = {file: digest(files[file]) for file in sorted(files)}
    about = {"name": name, **data.about, "cameras": videos, "files": digests}
    return {**files, EPISODE: json_bytes(about)}


def write_episode(folder: Path, name: str, files: Mapping[str, bytes]) -> None:
    """Write an episode: its folder is there whole or not at all.

    Args:
        folder: Of the data set.
        name: Of the episode.
        files: Of the episode; see `episode_files`.

    Raises:
        OSError: It cannot be written.
    """
    aside = folder / PARTIAL / f"{name}-{token_hex(4)}"
    aside.mkdir(parents=True)
    try:
        for file, content in files.items():
            write_whole(aside / file, content, sync=True)
        place = folder / EPISODES / name
        place.parent.mkdir(exist_ok=True)
        try:
            aside.rename(place)
        except OSError:  # a process that was about to end has written the same
            if not is_whole(place):
                raise
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def read_episode(place: Path) -> dict[str, Any]:
    """What an episode says of itself.

    Raises:
        StoreError: It is damaged.
        OSError: It cannot be read.
    """
    return read_json(place / EPISODE)


def read_episode_arrays(place: Path) -> Arrays:
    """The arrays of an episode.

    Raises:
        StoreError: They are damaged.
        OSError: They cannot be read.
    """
    return read_arrays(place / ARRAYS, _ARRAYS_KIND)[0]


def is_whole(place: Path) -> bool:
    """Whether all files of an episode are there as they were written."""
    try:
        files = read_episode(place)["files"]
        there = {file.name for file in place.iterdir()} - {EPISODE}
        return there == set(files) and all(
            digest((place / name).read_bytes()) == known for name, known in files.items()
        )
    except (StoreError, OSError, KeyError, TypeError, AttributeError):
        return False


# --- the manifest


def files_of(folder: Path) -> list[str]:
    """All files of a data set but the manifest, by their paths in it, in order."""
    found = (file.relative_to(folder) for file in folder.rglob("*") if not file.is_dir())
    return sorted(name.as_posix() for name in found if name.parts[0] not in (MANIFEST, PARTIAL))


def write_manifest(folder: Path) -> None:
    """Write the manifest: the digest of every other file, and of the manifest itself.

    Raises:
        OSError: It cannot be written.
    """
    for left in folder.glob(f".{MANIFEST}.*"):  # by one that was killed while it wrote this
        left.unlink()
    files = {name: digest((folder / name).read_bytes()) for name in files_of(folder)}
    write_json(folder / MANIFEST, sealed(files))


def sealed(files: Mapping[str, str]) -> dict[str, Any]:
    """The content of a manifest."""
    return {"kind": f"{KIND}: manifest", "format": FORMAT, "seal": digest_of(files), "files": files}


def is_finished(folder: Path) -> bool:
    """Whether collecting has come to its end."""
    return (folder / MANIFEST).is_file()
