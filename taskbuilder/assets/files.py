"""The meshes and textures that one URDF names, each looked up and read once."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from taskbuilder.assets import codes
from taskbuilder.assets.markup import Element
from taskbuilder.assets.mesh import Mesh, read_mesh, require_supported, size_warning
from taskbuilder.assets.paths import AssetError, resolve
from taskbuilder.assets.report import Report
from taskbuilder.geometry import Vec3

# How each kind of image begins; Bullet takes a file that is none of them without a word.
_IMAGES: dict[str, tuple[bytes, ...]] = {
    ".png": (b"\x89PNG\r\n\x1a\n",),
    ".jpg": (b"\xff\xd8\xff",),
    ".jpeg": (b"\xff\xd8\xff",),
    ".gif": (b"GIF87a", b"GIF89a"),
    ".bmp": (b"BM",),
    ".tga": (b"",),  # a TGA begins with nothing in particular
}


class Files:
    """Looks up the files that the elements of one URDF name, and reports those it cannot use.

    Args:
        folder: Folder of the URDF.
        roots: Folders inside which its files must lie.
        trusted: Whether to take the content of meshes for good.
        report: Where findings go.
    """

    def __init__(
        self, folder: Path, roots: Sequence[Path], *, trusted: bool, report: Report
    ) -> None:
        self._folder = folder
        self._roots = roots
        self._trusted = trusted
        self._report = report
        self._read: dict[Path, Mesh | AssetError] = {}
        self.meshes: dict[str, Path] = {}
        self.textures: dict[str, Path] = {}

    def mesh(self, element: Element, subject: str, scale: Vec3) -> Path | None:
        """The checked path of a ``<mesh>``; None if it was reported as wrong."""
        try:
            path = self._found(element)
            require_supported(path)
            mesh = None if self._trusted else self._mesh(path)
        except AssetError as error:
            self._report.asset(error, element, subject)
            return None
        for oddity in _oddities(mesh, scale) if mesh else ():
            self._report.warning(codes.BAD_MESH, element, subject, oddity)
        self.meshes[element.attributes["filename"]] = path
        return path

    def texture(self, element: Element, subject: str) -> None:
        """Looks up the image of a ``<texture>``."""
        try:
            path = self._found(element)
            _require_image(path)
        except AssetError as error:
            self._report.asset(error, element, subject)
        else:
            self.textures[element.attributes["filename"]] = path

    def _found(self, element: Element) -> Path:
        reference = element.get("filename")
        if reference is None:
            raise AssetError(codes.MISSING, f"<{element.tag}> names no file; write filename=…")
        return resolve(reference, self._folder, self._roots)

    def _mesh(self, path: Path) -> Mesh:
        """The mesh of a file, read the first time it is asked for."""
        if path not in self._read:
            try:
                self._read[path] = read_mesh(path)
            except AssetError as error:
                self._read[path] = error
        outcome = self._read[path]
        if isinstance(outcome, AssetError):
            raise outcome
        return outcome


def _oddities(mesh: Mesh, scale: Vec3) -> tuple[str, ...]:
    implausible = size_warning(mesh, scale)
    return (*mesh.warnings, implausible) if implausible else mesh.warnings


def _require_image(path: Path) -> None:
    beginnings = _IMAGES.get(path.suffix.lower())
    if beginnings is None:
        raise AssetError(
            codes.NOT_READABLE,
            f"{path.name} is no image that can be a texture; use one of {', '.join(_IMAGES)}",
        )
    with path.open("rb") as file:
        if not file.read(16).startswith(beginnings):
            raise AssetError(
                codes.NOT_READABLE,
                f"{path.name} is not the image that its name says; save it again as PNG",
            )
