"""A directory with what is shared: putting a bundle there, and copying one from there."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from secrets import token_hex

from taskbuilder.arrays import StoreError
from taskbuilder.data.layout import LARGEST_FILE
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.files import write_whole
from taskbuilder.sharing.bundles import Bundle
from taskbuilder.sharing.manifest import FOLDERS, Manifest, read_manifest
from taskbuilder.untrusted import copy_within, names_within, place_within
from taskbuilder.wording import excerpt, suggestion


def put(root: Path, bundle: Bundle, where: str, *, replace: bool) -> bool:
    """Put a bundle to a directory: it is there whole or not at all.

    Args:
        root: The directory.
        bundle: What is put there.
        where: What the place is called in messages.
        replace: Whether another one of the same name is replaced.

    Returns:
        Whether anything has changed.

    Raises:
        UsageError: Another one has the name.
        OSError: It cannot be written.
    """
    manifest = bundle.manifest
    place, file = root / manifest.folder, root / manifest.file
    if file.is_file() and not replace:
        there = read_manifest(root, manifest.kind, manifest.name)
        if there.content() == manifest.content():
            return False
        raise UsageError(f"{where} has another {there.label}; {_advice(manifest, there)}")
    if place.exists() and not replace:
        raise UsageError(
            f"{where} has {manifest.folder} without a manifest; give another --name, or --replace"
        )
    aside = place.with_name(f".{manifest.name}.{token_hex(4)}")
    aside.mkdir(parents=True)
    try:
        for name, source in bundle.sources.items():
            to = aside / name
            to.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(source, Path):
                shutil.copyfile(source, to)
            else:
                to.write_bytes(source)
        file.unlink(missing_ok=True)
        if place.exists():
            shutil.rmtree(place)
        aside.rename(place)
        write_whole(file, manifest.content())
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return True


def _advice(manifest: Manifest, there: Manifest) -> str:
    advice = "give another --name, or --replace"
    if manifest.kind == "task" and there.about["task_version"] == manifest.about["task_version"]:
        return f"a changed task has the next version in its file; then give {advice[5:]}"
    return advice


def find(root: Path, name: str, where: str) -> Manifest:
    """Find what is called so, and read its manifest.

    Args:
        root: The directory.
        name: The name, or the folder and the name, such as ``tasks/handover``.
        where: What the place is called in messages.

    Raises:
        UnknownNameError: Nothing is called so.
        UsageError: Several kinds are called so.
        StoreError: The manifest is damaged.
    """
    listed = dict(_listed(root))
    found = [path for path in listed if name in (path, path.partition("/")[2])]
    if not found:
        help_ = suggestion(name, listed, what="it has", otherwise="it has nothing to pull")
        raise UnknownNameError(f'{where} has no "{excerpt(name)}"; {help_}')
    if len(found) > 1:
        raise UsageError(f"{where} has {' and '.join(found)}; name one of them")
    kind = listed[found[0]]
    return read_manifest(root, kind, found[0].partition("/")[2])


def _listed(root: Path) -> Iterator[tuple[str, str]]:
    """The path and the kind of everything that has a manifest."""
    for kind, folder in FOLDERS.items():
        place = root / folder
        files = sorted(place.glob("*.json")) if place.is_dir() and not place.is_symlink() else ()
        yield from ((f"{folder}/{file.stem}", kind) for file in files)


def copy(root: Path, manifest: Manifest, to: Path, where: str) -> None:
    """Copy the files of a manifest to a new folder; what differs from it is refused.

    Args:
        root: The directory.
        manifest: What is copied.
        to: The new folder.
        where: What the place is called in messages.

    Raises:
        StoreError: A file is missing, new, a link, or not as in the manifest.
        OSError: The copy cannot be written.
    """
    wrong = f"{where}: {manifest.folder} is not what its manifest says"
    advice = "ask whoever pushed it to push it again"
    try:
        there = set(names_within(place_within(root, manifest.folder)))
    except OSError as error:
        raise StoreError(f"{wrong}: {error.filename} {error.strerror}; {advice}") from None
    for name in sorted({*there} ^ {*manifest.files}):
        state = "new" if name in there else "gone"
        raise StoreError(f"{wrong}: {excerpt(name)} is {state}; {advice}")
    to.mkdir(parents=True)
    for name, digest in manifest.files.items():
        target = to / name
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            copied = copy_within(root, f"{manifest.folder}/{name}", LARGEST_FILE, target)
        except OSError as error:
            said = f"{excerpt(name)} {error.strerror or error}"
            raise StoreError(f"{wrong}: {said}; {advice}") from None
        if copied != digest:
            raise StoreError(f"{wrong}: {excerpt(name)} was changed; {advice}")
