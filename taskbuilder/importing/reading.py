"""From a file of any of the formats that are read to a description."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from taskbuilder.assets import codes
from taskbuilder.assets.markup import parse
from taskbuilder.assets.paths import AssetError, require_readable
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import ImportedBody
from taskbuilder.importing.mesh_files import FORMATS
from taskbuilder.importing.mjcf import read_mjcf
from taskbuilder.importing.packages import Packages
from taskbuilder.importing.sdf import read_sdf
from taskbuilder.importing.urdf import read_urdf_text
from taskbuilder.importing.xacro import expand
from taskbuilder.wording import quoted

MAX_BYTES = 16 * 2**20
_MAGIC = (b"PK\x03\x04", b"\x1f\x8b", b"BZh", b"\xfd7zXZ", b"7z\xbc\xaf", b"Rar!")
_TAR = 257  # where a tar file says that it is one
_ARCHIVES = (".zip", ".gz", ".tar", ".tgz", ".7z", ".rar", ".bz2", ".xz", ".whl")
_OTHERS = (".usd", ".usda", ".usdc", ".usdz", ".step", ".stp", ".iges", ".igs", ".fbx", ".blend")


def read_description(
    packages: Packages,
    arguments: Mapping[str, str],
    changes: Changes,
    unknown: dict[str, Finding] | None = None,
) -> ImportedBody:
    """Read the file that packages were looked up around.

    Args:
        packages: The packages around the file, which it names.
        arguments: Values of the arguments of a xacro file.
        changes: Where changes are noted.
        unknown: Where arguments that it does not have are noted; see `expand`.

    Raises:
        FileError: It cannot be read, or something is wrong with it.
        UsageError: The extra is not installed.
    """
    file = packages.file
    data = _content(file)
    if file.suffix.lower() == ".xacro" or b"xmlns:xacro" in data[:4000] or b"<xacro:" in data:
        text, _ = expand(packages, arguments, unknown)
        changes.note("file", "format", file.name, "URDF", "xacro was expanded" + _given(arguments))
        return read_urdf_text(file, text, changes)
    others = {
        name: Finding(codes.XACRO, f"has no argument {quoted(name)}, as it is no xacro file", "",
            Location(file))
        for name in arguments
    }  # fmt: skip
    if others and unknown is None:
        raise FileError([next(iter(others.values()))])
    if unknown is not None:
        unknown.update(others)
    root = parse(file, data, lines=False)
    if root.tag == "robot":
        return read_urdf_text(file, data, changes)
    if root.tag in ("sdf", "gazebo"):
        changes.note(
            "file", "format", file.name, "URDF", f"SDF {root.get('version') or ''}".strip()
        )
        return read_sdf(file, parse(file, data, lines=False, text=True), changes)
    if root.tag == "mujoco":
        changes.note("file", "format", file.name, "URDF", "MJCF of MuJoCo")
        return read_mjcf(packages, root, changes)
    message = f"the root element is <{root.tag}>; URDF, xacro, SDF and MJCF are read"
    raise FileError([Finding(codes.STRUCTURE, message, "", Location(file, root.line))])


def is_mesh(file: Path) -> bool:
    """Whether a file is a mesh by its name."""
    return file.suffix.lower() in FORMATS


def _given(arguments: Mapping[str, str]) -> str:
    listed = ", ".join(f"{name}={value}" for name, value in arguments.items())
    return f" with {listed}" if listed else ""


def _content(file: Path) -> bytes:
    suffix = file.suffix.lower()
    try:
        require_readable(file, file.name, MAX_BYTES)
        data = file.read_bytes()
    except (AssetError, OSError) as error:
        known = error if isinstance(error, AssetError) else None
        problem = known or AssetError(codes.NOT_READABLE, f"{file.name} cannot be read: {error}")
        raise FileError([problem.finding(location=Location(file))]) from error
    message = ""
    if suffix in _ARCHIVES or data.startswith(_MAGIC) or data[_TAR : _TAR + 5] == b"ustar":
        message = f"{file.name} is an archive; unpack it, and import the description inside"
    elif suffix in _OTHERS:
        message = f"{suffix[1:].upper()} files are not read; export URDF, MJCF or a mesh from it"
    elif is_mesh(file):
        message = (
            f"{file.name} is a mesh, which has no joints; import it by taskbuilder objects import, "
            "or import the description that names it"
        )
    if message:
        raise FileError([Finding(codes.NOT_IMPORTED, message, "", Location(file))])
    return data
