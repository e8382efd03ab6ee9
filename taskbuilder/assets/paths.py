"""From a reference in a file to the one existing file that it means.

PyBullet prefers the working directory over the folder of the file that names an asset, and
follows absolute paths and ``..`` anywhere. So a reference is resolved here, once, and from then
on only the absolute path is used.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from functools import cache
from importlib.util import find_spec
from itertools import islice
from pathlib import Path

from taskbuilder.assets import codes
from taskbuilder.engine import DATA_MODULE, PACKAGES
from taskbuilder.errors import Finding, Location, Severity, TaskbuilderError
from taskbuilder.wording import quoted, suggestion

MAX_BYTES = 64 * 2**20

PACKAGE = "package://"
_PACKAGE_NAME = re.compile(r"package://([^/\s\"'<>]+)/")
_MANIFEST = "package.xml"
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:")


class AssetError(TaskbuilderError):
    """An asset cannot be used.

    Attributes:
        code: Stable code, a key of `taskbuilder.assets.codes.CODES`.
        message: What is wrong, then, after a semicolon, what would be right.
    """

    def __init__(self, code: str, message: str) -> None:
        self.code = code
        self.message = message
        super().__init__(message)

    def finding(
        self, path: str = "", location: Location | None = None, severity: Severity = "error"
    ) -> Finding:
        """The same, as a finding at the place that names the asset."""
        return Finding(self.code, self.message, path, location, severity)


@cache
def pybullet_data_folder() -> Path | None:
    """Where pybullet's own assets are, found without importing them; None if not installed."""
    spec = find_spec(DATA_MODULE)
    if spec is None or spec.origin is None:
        return None
    return Path(spec.origin).resolve().parent


def resolve(reference: str, folder: Path, roots: Sequence[Path]) -> Path:
    """The absolute path of the existing file that a reference means, symbolic links resolved.

    Args:
        reference: Path relative to ``folder``, or ``package://NAME/rest``, where NAME is
            ``pybullet_data`` or a folder found from ``folder`` upwards.
        folder: Folder of the file that holds the reference.
        roots: Folders inside which the file must lie; pybullet_data is allowed as well.

    Raises:
        AssetError: There is no such file, it lies elsewhere, or it cannot be read.
    """
    allowed = _allowed_folders(roots)
    wanted = _located(reference, folder, allowed)
    try:
        actual = wanted.resolve()
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links, a name too long
        raise AssetError(
            codes.NOT_READABLE,
            f"{quoted(reference)} cannot be followed ({error}); name a plain file",
        ) from error
    # Before anything about the file is told, not even whether it exists.
    if not _inside(actual, allowed):
        raise AssetError(
            codes.OUTSIDE,
            f"{quoted(reference)} lies outside the allowed folders; "
            "copy the file beside the one that names it",
        )
    require_readable(actual, reference)
    return actual


def package_of(file: Path) -> tuple[Path, ...]:
    """The ROS package that a file is in: the nearest folder upwards with a ``package.xml``.

    A file of a package may name the others. A folder without this mark is none, whatever its name:
    ``package://home/…`` would otherwise open ``/home`` to a file that somebody else has written.

    Returns:
        The folder, or nothing where there is none.
    """
    folders = (folder for folder in file.resolve().parents if (folder / _MANIFEST).is_file())
    return tuple(islice(folders, 1))


def packages_named_in(file: Path) -> tuple[Path, ...]:
    """The folders above a URDF that it names as packages, marked as such or not.

    Only for a file that a person has named. What its ``package://NAME/…`` may lead to is then in a
    folder that has this name and contains the file.
    """
    try:
        require_readable(file, file.name)
        names = set(_PACKAGE_NAME.findall(file.read_bytes().decode(errors="replace")))
    except (AssetError, OSError):  # which reading the file reports
        return ()
    return tuple(folder for folder in file.resolve().parents if folder.name in names)


def require_readable(path: Path, reference: str, max_bytes: int = MAX_BYTES) -> None:
    """Checks that a path is a plain file that can be read and is not too large.

    Raises:
        AssetError: It is not; for a missing file the message names the closest one there is.
    """
    try:
        exists, plain = path.exists(), path.is_file()
        readable = plain and os.access(path, os.R_OK)
        size = path.stat().st_size if readable else 0
    except (OSError, ValueError) as error:
        raise AssetError(
            codes.NOT_READABLE, f"{quoted(reference)} cannot be read: {error}"
        ) from error
    if not exists:
        raise AssetError(
            codes.MISSING, f"there is no file {quoted(reference)}; {_suggestion(path)}"
        )
    if not plain:
        kind = "a folder" if path.is_dir() else "not a plain file"
        raise AssetError(codes.NOT_READABLE, f"{quoted(reference)} is {kind}; name a file")
    if not readable:
        raise AssetError(
            codes.NOT_READABLE, f"{quoted(reference)} may not be read; allow it with chmod"
        )
    if size > max_bytes:
        raise AssetError(
            codes.NOT_READABLE,
            f"{quoted(reference)} has {size / 2**20:.1f} MB; "
            f"at most {max_bytes // 2**20} MB are read",
        )


def _allowed_folders(roots: Sequence[Path]) -> tuple[Path, ...]:
    packaged = pybullet_data_folder()
    folders = tuple(root.resolve() for root in roots)
    return folders if packaged is None else (*folders, packaged)


def _inside(path: Path, folders: Sequence[Path]) -> bool:
    return any(path.is_relative_to(folder) for folder in folders)


def _located(reference: str, folder: Path, allowed: Sequence[Path]) -> Path:
    """The path that a reference spells, whether or not there is a file."""
    if not reference.strip():
        raise AssetError(codes.MISSING, "the file name is empty; name a file")
    if "\\" in reference or not reference.isprintable():
        raise AssetError(
            codes.OUTSIDE, f'{quoted(reference)} is not a portable path; separate folders with "/"'
        )
    if reference.startswith(PACKAGE):
        name, _, rest = reference.removeprefix(PACKAGE).partition("/")
        return _package(name, reference, folder, allowed) / rest.lstrip("/")
    if _SCHEME.match(reference) or reference.startswith(("/", "~")):
        raise AssetError(
            codes.OUTSIDE,
            f"{quoted(reference)} works on one machine only; write it relative to the file",
        )
    return folder / reference


def _package(name: str, reference: str, folder: Path, allowed: Sequence[Path]) -> Path:
    """The folder that ``package://NAME`` means."""
    if name in ("", ".", ".."):
        raise AssetError(
            codes.MISSING, f"{quoted(reference)} names no package; write package://NAME/path"
        )
    if name == DATA_MODULE:
        packaged = pybullet_data_folder()
        if packaged is None:
            raise AssetError(
                codes.MISSING,
                f"{quoted(reference)} needs the package {DATA_MODULE}; "
                f"install {' or '.join(PACKAGES)}, which have it",
            )
        return packaged
    for candidate in _package_candidates(name, folder.resolve(), allowed):
        if candidate.is_dir():
            return candidate
    if name in (above.name for above in folder.resolve().parents):
        raise AssetError(
            codes.OUTSIDE,
            f"the folder {quoted(name)} of {quoted(reference)} lies outside the allowed folders; "
            f"if it is the ROS package of the file, put its {_MANIFEST} into it",
        )
    raise AssetError(
        codes.MISSING,
        f"no folder {quoted(name)} for {quoted(reference)} beside the file or above it; "
        "write the path relative to the file",
    )


def _package_candidates(name: str, folder: Path, allowed: Sequence[Path]) -> Iterator[Path]:
    """Where a package may be: in each folder upwards, or that folder itself, as ROS has it."""
    for base in (folder, *folder.parents):
        if not _inside(base, allowed):
            return
        yield base / name
        if base.name == name:
            yield base


def _suggestion(path: Path) -> str:
    folder = path.parent
    try:
        names = [entry.name for entry in folder.iterdir() if entry.is_file()]
    except OSError:
        missing = folder
        while not missing.parent.is_dir():
            missing = missing.parent
        return f"there is no folder {quoted(missing.name)} either"
    alike = [name for name in names if _same_kind(path.suffix, Path(name).suffix)]
    return suggestion(path.name, alike, otherwise=f"put it in the folder {quoted(folder.name)}")


_MESHES = {".obj", ".stl", ".dae", ".glb", ".gltf", ".ply"}


def _same_kind(wanted: str, found: str) -> bool:
    """Whether a file of one ending may be what is meant by another; an MTL is no mesh."""
    wanted, found = wanted.lower(), found.lower()
    return found in _MESHES if wanted in _MESHES else found not in _MESHES
