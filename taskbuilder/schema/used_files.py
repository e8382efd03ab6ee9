"""The files that a task is made of, also of a task in which something is wrong."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from taskbuilder.assets.paths import AssetError, resolve
from taskbuilder.errors import FileError, UnknownNameError
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.source import Source, read_source

_MESH = re.compile(rb"""filename\s*=\s*["']([^"']+)["']""")
_READ_BYTES = 2**24


def used_files(entry: CatalogueEntry, catalogue: Catalogue) -> frozenset[Path]:
    """The task file, its description, and the robots, URDFs and meshes that it names.

    Files that are named but missing are among them. Of a task file that is no YAML, nothing is
    known but the file itself and its description.

    Args:
        entry: The task.
        catalogue: Where the names of robots are looked up.
    """
    return frozenset(_files(entry, catalogue))


def _files(entry: CatalogueEntry, catalogue: Catalogue) -> Iterator[Path]:
    yield entry.file
    yield entry.description_file
    source = _read(entry.file)
    if source is None:
        return
    roots = (entry.root, *catalogue.folders)
    for name, _ in source.entries("scene", "robots"):
        yield from _robot(source.get("scene", "robots", name, "model"), entry, catalogue)
    for name, _ in source.entries("scene", "objects"):
        shape = ("scene", "objects", name, "shape")
        yield from _assets(source, shape, entry.root, roots)
        object_ = source.get("scene", "objects", name, "object")
        yield from _object(object_, entry, catalogue)


def _read(file: Path) -> Source | None:
    try:
        return read_source(file)
    except FileError:
        return None


def _robot(reference: object, entry: CatalogueEntry, catalogue: Catalogue) -> Iterator[Path]:
    if not isinstance(reference, str) or not reference:
        return
    try:
        robot = catalogue.robot(reference, entry.root)
    except (UnknownNameError, FileError):
        if reference.endswith((".yaml", ".yml")):
            yield entry.root / reference  # it may appear
        return
    yield robot.file
    source = _read(robot.file)
    if source is not None:
        roots = (robot.root, entry.root, *catalogue.folders)
        yield from _urdf(source.get("urdf"), robot.root, roots)


def _object(reference: object, entry: CatalogueEntry, catalogue: Catalogue) -> Iterator[Path]:
    if not isinstance(reference, str) or not reference:
        return
    try:
        found = catalogue.object(reference, entry.root)
    except (UnknownNameError, FileError):
        if reference.endswith((".yaml", ".yml")):
            yield entry.root / reference  # it may appear
        return
    yield found.file
    source = _read(found.file)
    if source is not None:
        roots = (found.root, entry.root, *catalogue.folders)
        yield from _assets(source, ("shape",), found.root, roots)


def _assets(
    source: Source, shape: tuple[str, ...], folder: Path, roots: tuple[Path, ...]
) -> Iterator[Path]:
    """The files of an object's shape."""
    yield from _asset(source.get(*shape, "mesh"), folder, roots)
    yield from _asset(source.get(*shape, "collision"), folder, roots)
    yield from _urdf(source.get(*shape, "urdf"), folder, roots)


def _urdf(reference: object, folder: Path, roots: tuple[Path, ...]) -> Iterator[Path]:
    """A URDF and its meshes."""
    for file in _asset(reference, folder, roots):
        yield file
        try:
            with file.open("rb") as opened:
                text = opened.read(_READ_BYTES)
        except OSError:
            continue
        for mesh in set(_MESH.findall(text)):
            yield from _asset(mesh.decode(errors="replace"), file.parent, (*roots, file.parent))


def _asset(reference: object, folder: Path, roots: tuple[Path, ...]) -> Iterator[Path]:
    if not isinstance(reference, str) or not reference:
        return
    try:
        yield resolve(reference, folder, roots)
    except AssetError:
        if ":" not in reference and "\0" not in reference:
            yield folder / reference  # it may appear
