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

from taskbuilder.arrays import Arrays, StoreError, packed_arrays, unpacked_arrays
from taskbuilder.data import records
from taskbuilder.data.recording import EpisodeData
from taskbuilder.data.videos import DEPTH, VIDEO, encoded, encoded_depth
from taskbuilder.digests import digest, digest_of
from taskbuilder.errors import UsageError, display_path
from taskbuilder.files import claim, write_whole
from taskbuilder.untrusted import digest_within, names_within, parse_json, read_within

FORMAT = 1
"""Version of the format; others are refused."""

KIND = "taskbuilder data set"
ABOUT, INDEX, MANIFEST, CARD = "dataset.json", "index.json", "manifest.json", "README.md"
EPISODES, FAILURES, TASKS, PARTIAL = "episodes", "failures", "tasks", ".partial"
EPISODE, ARRAYS = "episode.json", "arrays.npz"

OWN = (ABOUT, INDEX, MANIFEST, CARD, EPISODES, FAILURES, TASKS, PARTIAL)
"""Everything that may lie in the folder of a data set."""

_ARRAYS_KIND = "episode"
_LARGEST_JSON = 4 << 20
_LINE = 16 << 10
"""Most bytes that the index and the manifest have for each episode or file."""

LARGEST_FILE = 2 << 30
"""Most bytes of any file of a data set."""


def write_json(path: Path, data: Any) -> None:
    """Write JSON, whole and synced.

    Raises:
        OSError: It cannot be written.
    """
    write_whole(path, json_bytes(data), sync=True)


def json_bytes(data: Any) -> bytes:
    """JSON as all files of a data set have it."""
    return (json.dumps(data, indent=1, ensure_ascii=True) + "\n").encode()


def read_file(folder: Path, name: str, largest: int = LARGEST_FILE) -> bytes:
    """The contents of a file of a data set.

    Args:
        folder: Of the data set.
        name: Path of the file in it.
        largest: Bytes that it may have at most.

    Raises:
        StoreError: It is missing, is no plain file, is a link, is too large, or cannot be read.
    """
    with _reading(folder, name):
        return read_within(folder, name, largest)


def digest_file(folder: Path, name: str) -> str:
    """The digest of a file of a data set.

    Raises:
        StoreError: As `read_file` does.
    """
    with _reading(folder, name):
        return digest_within(folder, name, LARGEST_FILE)


@contextmanager
def _reading(folder: Path, name: str) -> Iterator[None]:
    where = display_path(folder / name)
    try:
        yield
    except FileNotFoundError:
        raise StoreError(f"{where} is missing") from None
    except OSError as error:
        raise StoreError(f"{where} {_cannot(error)}") from None


def _cannot(error: OSError) -> str:
    reason = error.strerror or str(error)
    return reason if reason.startswith(("is ", "has ", "leads ")) else f"cannot be read: {reason}"


def read_json(folder: Path, name: str, largest: int = _LARGEST_JSON) -> dict[str, Any]:
    """Read a JSON object of a data set.

    Args:
        folder: Of the data set.
        name: Path of the file in it.
        largest: Bytes that it may have at most.

    Raises:
        StoreError: It is damaged, or cannot be read.
    """
    where = display_path(folder / name)
    try:
        data = parse_json(read_file(folder, name, largest))
    except ValueError as error:
        raise StoreError(f"{where} is damaged ({error})") from None
    if not isinstance(data, dict):
        raise StoreError(f"{where} is damaged: it is no object")
    return data


def read_about(folder: Path) -> dict[str, Any]:
    """What a data set says of itself.

    Raises:
        UsageError: The folder is no data set, or one of another version.
        StoreError: It is damaged.
    """
    file = folder / ABOUT
    if folder.is_file():
        raise UsageError(f"{display_path(folder)} is a file; name the folder of a data set")
    if not folder.exists():
        raise UsageError(f"there is no folder {display_path(folder)}")
    if not file.exists() and not file.is_symlink():
        raise UsageError(f"{display_path(folder)} is no data set; it has no {ABOUT}")
    about = read_json(folder, ABOUT)
    if about.get("kind") != KIND:
        raise UsageError(f"{display_path(folder)} is no data set of taskbuilder")
    if about.get("format") != FORMAT:
        version = about.get("format")
        raise UsageError(
            f"{display_path(folder)} has format {version}; this version reads {FORMAT}"
        )
    records.check_about(about, display_path(file))
    return about


def read_index(folder: Path, about: Mapping[str, Any]) -> dict[str, Any]:
    """The index of a data set.

    Args:
        folder: Of the data set.
        about: What it says of itself.

    Raises:
        StoreError: It is damaged, or lists other episodes than there are.
    """
    there = [*_entries(folder / EPISODES), *_entries(folder / FAILURES)]
    index = read_json(folder, INDEX, _LARGEST_JSON + _LINE * len(there))
    records.check_index(index, about, display_path(folder / INDEX))
    return index


def read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of a data set.

    Raises:
        StoreError: It is damaged.
    """
    largest = _LARGEST_JSON + _LINE * len(files_of(folder))
    manifest = read_json(folder, MANIFEST, largest)
    records.check_manifest(manifest, display_path(folder / MANIFEST))
    return manifest


def _entries(folder: Path) -> list[str]:
    """The names in a folder; none if it is not there, or is a link."""
    if folder.is_symlink() or not folder.is_dir():
        return []
    return [each.name for each in folder.iterdir()]


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
            if not is_whole(folder, name):
                raise
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def read_episode(folder: Path, name: str) -> dict[str, Any]:
    """What an episode says of itself, unchecked.

    Raises:
        StoreError: It is no JSON, or cannot be read.
    """
    return read_json(folder, f"{EPISODES}/{name}/{EPISODE}")


def read_episode_arrays(folder: Path, name: str, largest: int = LARGEST_FILE) -> Arrays:
    """The arrays of an episode, unchecked.

    Args:
        folder: Of the data set.
        name: Of the episode.
        largest: Bytes that their file may have at most.

    Raises:
        StoreError: Their file is damaged, or cannot be read.
    """
    file = f"{EPISODES}/{name}/{ARRAYS}"
    content = read_file(folder, file, largest)
    return unpacked_arrays(content, _ARRAYS_KIND, display_path(folder / file))[0]


def is_whole(folder: Path, name: str) -> bool:
    """Whether all files of an episode are there as they were written."""
    place = f"{EPISODES}/{name}"
    try:
        files = read_episode(folder, name)["files"]
        there = {file.name for file in (folder / place).iterdir()} - {EPISODE}
        return there == set(files) and all(
            digest_file(folder, f"{place}/{file}") == digest for file, digest in files.items()
        )
    except (StoreError, OSError, KeyError, TypeError, AttributeError):
        return False


# --- the manifest


def files_of(folder: Path) -> list[str]:
    """All files of a data set but the manifest, by their paths in it, in order."""
    names = names_within(folder)
    return sorted(name for name in names if name.partition("/")[0] not in (MANIFEST, PARTIAL))


def write_manifest(folder: Path) -> None:
    """Write the manifest: the digest of every other file, and of the manifest itself.

    Raises:
        OSError: It cannot be written.
    """
    for left in folder.glob(f".{MANIFEST}.*"):  # by one that was killed while it wrote this
        left.unlink()
    files = {name: digest_file(folder, name) for name in files_of(folder)}
    write_json(folder / MANIFEST, sealed(files))


def sealed(files: Mapping[str, str]) -> dict[str, Any]:
    """The content of a manifest."""
    return {"kind": f"{KIND}: manifest", "format": FORMAT, "seal": digest_of(files), "files": files}


def is_finished(folder: Path) -> bool:
    """Whether collecting has come to its end."""
    return (folder / MANIFEST).is_file()
