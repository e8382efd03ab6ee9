"""The meshes of a description: found, brought to metres, drawn with few triangles, and fitted."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from taskbuilder.assets import codes
from taskbuilder.assets.paths import AssetError
from taskbuilder.errors import Finding
from taskbuilder.geometry import Pose
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import (
    ImportedBody,
    ImportedShape,
    Link,
    Role,
    links_without_collision,
)
from taskbuilder.importing.fitting import Fit, fit
from taskbuilder.importing.mesh_files import (
    UNITS,
    MeshFile,
    Up,
    load_mesh,
    load_picture,
    textured,
)
from taskbuilder.importing.mesh_options import MeshOptions
from taskbuilder.importing.mesh_output import compound_obj, decimated, obj_files
from taskbuilder.importing.packages import Packages
from taskbuilder.importing.primitives import box_corners, primitive_part
from taskbuilder.importing.surfaces import Floats, Part, is_closed, placed, volume, welded_mesh

LARGEST_M, SMALLEST_M = 5.0, 0.0005
"""Extents between which a mesh without a unit is taken for one in metres."""
_LARGEST_MM, _SMALLEST_MM = 3000.0, 20.0
_Z_UP: Mapping[Up, Floats] = {
    "x": np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "z": np.eye(3),
}


@dataclass(frozen=True, eq=False)
class _Source:
    """A mesh that a collision shape is made of: its file, points and faces in metres, and place."""

    path: Path
    count: int
    part: Part
    shape: ImportedShape


@dataclass
class Geometry:
    """Converts the shapes of one description, and collects the files that are to be written.

    Attributes:
        files: Content by path relative to the folder that is written.
        solids: Link -> what it looks like, as parts of its frame, for inertias and pictures.
    """

    packages: Packages
    options: MeshOptions
    changes: Changes
    files: dict[str, bytes] = field(default_factory=dict)
    solids: dict[str, list[Part]] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    _sources: dict[str, list[_Source]] = field(default_factory=dict)
    _loaded: dict[Path, MeshFile | AssetError] = field(default_factory=dict)
    _drawn: dict[tuple[object, ...], tuple[str, bool]] = field(default_factory=dict)
    _fitted: dict[tuple[object, ...], Fit] = field(default_factory=dict)
    _stems: set[str] = field(default_factory=set)

    def converted(self, description: ImportedBody) -> ImportedBody:
        """The description with meshes that are written, and collision shapes for all that needs it.

        What cannot be used is collected in ``findings``.
        """
        links: dict[str, Link] = {}
        needy = set(links_without_collision(description))
        for link in description.links:
            boxes = {role: self._boxes(getattr(link, f"{role}s"), description) for role in _ROLES}
            visuals = self._shapes(link, "visual", description, boxes["collision"])
            collisions = self._shapes(link, "collision", description, boxes["visual"])
            if link.name in needy:
                self.changes.note(
                    f"link {link.name}", "collision", "none", "as it looks",
                    "it moves, and would pass through everything",
                )  # fmt: skip
                look = replace(link, collisions=link.visuals)
                collisions = self._shapes(look, "collision", description, None)
                self.solids.pop(f"{link.name}/collision", None)
            links[link.name] = replace(link, visuals=visuals, collisions=collisions)
        return description.with_links(links)

    def _shapes(
        self, link: Link, role: Role, description: ImportedBody, reference: Floats | None
    ) -> tuple[ImportedShape, ...]:
        made: list[ImportedShape] = []
        for shape in link.visuals if role == "visual" else link.collisions:
            try:
                made += self._shape(shape, link, role, description, reference)
            except AssetError as error:
                self.findings.append(error.finding(f"link {link.name}", shape.place))
        return tuple(made)

    def _shape(
        self,
        shape: ImportedShape,
        link: Link,
        role: Role,
        description: ImportedBody,
        reference: Floats | None,
    ) -> Sequence[ImportedShape]:
        if shape.kind != "mesh":
            self._note_solid(link.name, role, primitive_part(shape), Pose())
            if role == "visual":
                return [self._painted(shape, link)]
            return [replace(shape, color=None, texture="")]
        path = self.packages.locate(shape.mesh, description.folder)
        mesh = self._load(path)
        if role == "visual":
            mesh = self._textured(mesh, shape, link, description.folder)
        matrix = self._matrix(mesh, shape, link, reference)
        looks = shape.texture if role == "visual" else ""
        key = (path, looks, tuple(matrix.reshape(-1).tolist()))
        points, faces = self._soup(mesh.moved(matrix), f"link {link.name}")
        self._note_solid(link.name, role, (points, faces), shape.pose)
        if role == "visual":
            if key not in self._drawn:
                self._drawn[key] = self._draw(path, mesh.moved(matrix), link.name)
            file, colored = self._drawn[key]
            size = (1.0, 1.0, 1.0)
            return [
                replace(
                    shape,
                    size=size,
                    file=file,
                    mesh="",
                    texture="",
                    color=None if colored else shape.color,
                )
            ]
        kept = _Source(path, mesh.triangles, (points, faces), shape)
        self._sources.setdefault(link.name, []).append(kept)
        return [self._collision(kept, key, link.name, self.options.slack)]

    def refined(self, description: ImportedBody, links: Collection[str]) -> ImportedBody:
        """The description with the collision shapes of some links as exact as those of objects."""
        changed: dict[str, Link] = {}
        for name in links:
            sources = self._sources.get(name, [])
            if not sources or self.options.collision != "auto":
                continue
            link = description.link(name)
            plain = tuple(one for one in link.collisions if one.place not in _places(sources))
            self.changes.forget(f"link {name}", "collision", sources[0].path.name)
            made = [self._collision(one, (id(one),), name, 1.0) for one in sources]
            changed[name] = replace(link, collisions=(*plain, *made))
        return description.with_links(changed)

    def used_files(self, description: ImportedBody) -> dict[str, bytes]:
        """The files that a description needs."""
        shapes = [s for link in description.links for s in (*link.visuals, *link.collisions)]
        stems = {Path(shape.file).stem for shape in shapes if shape.file}
        used = {name: content for name, content in self.files.items() if Path(name).stem in stems}
        pictures = [name for name in self.files if name.endswith(".png")]
        text = b"".join(content for name, content in used.items() if name.endswith(".mtl"))
        return used | {n: self.files[n] for n in pictures if Path(n).name.encode() in text}

    def _collision(
        self, source: _Source, key: tuple[object, ...], link: str, slack: float
    ) -> ImportedShape:
        """The collision shape for a mesh."""
        key = (*key, slack)
        if key not in self._fitted:
            self._fitted[key] = fit(*source.part, self.options.collision, slack)
        found = self._fitted[key]
        self.changes.note(
            f"link {link}", "collision", f"{source.path.name}, {source.count:,} triangles",
            found.words, _error_words(found),
        )  # fmt: skip
        shape = source.shape
        if found.kind != "mesh":
            return ImportedShape(found.kind, found.size, shape.pose @ found.pose, shape.place)
        file = self._write_compound(source.path, found)
        return ImportedShape("mesh", (1.0, 1.0, 1.0), shape.pose, shape.place, file=file)

    def _load(self, path: Path) -> MeshFile:
        if path not in self._loaded:
            try:
                self._loaded[path] = load_mesh(path, self.packages)
            except AssetError as error:
                self._loaded[path] = error
        outcome = self._loaded[path]
        if isinstance(outcome, AssetError):
            raise outcome
        for oddity in outcome.oddities:
            self.changes.note(f"mesh {path.name}", "triangles", oddity, "left out", "as they are")
        return outcome

    def _soup(self, mesh: MeshFile, subject: str) -> Part:
        """All triangles, turned outwards where a closed surface faces inwards."""
        points, faces = welded_mesh(*mesh.soup)
        flat = bool((np.ptp(points, axis=0) < 1e-7).sum() >= 2)
        if flat:
            raise AssetError(codes.BAD_MESH, f"{mesh.path.name}: all its points lie on one line")
        if is_closed(faces):
            if volume(points, faces) < 0.0:
                self.changes.note(
                    f"mesh {mesh.path.name}", "triangles", "face inwards", "turned", subject
                )
                faces = faces[:, ::-1]
        else:
            self.changes.note(
                f"mesh {mesh.path.name}", "surface", "not closed", "as it is",
                "its volume is taken for that of its hull",
            )  # fmt: skip
        return points, faces

    def _matrix(
        self, mesh: MeshFile, shape: ImportedShape, link: Link, reference: Floats | None
    ) -> Floats:
        """What brings a mesh into its link's units: its unit, up axis and scale."""
        name = f"mesh {mesh.path.name}"
        scale = np.array(shape.size, np.float64)
        unit = self._unit(mesh, name, float(np.abs(scale).max()))
        turn = self._turn(mesh, name, shape, scale * unit, reference)
        if (np.sign(scale) < 0).any():
            self.changes.note(
                f"link {link.name}", "mesh scale", _spaced(shape.size), "baked into the mesh",
                "a mirrored mesh would be drawn inside out",
            )  # fmt: skip
        if self.options.scale != 1.0:
            self.changes.note(name, "scale", "1", f"{self.options.scale:g}", "as given")
        return np.asarray(np.diag(scale * unit * self.options.scale) @ turn, np.float64)

    def _unit(self, mesh: MeshFile, name: str, scale: float) -> float:
        extent = float(np.ptp(mesh.bounds, axis=0).max()) * scale
        if mesh.unit_m is not None:
            if abs(mesh.unit_m - 1.0) > 1e-9:
                self.changes.note(
                    name, "unit", f"{mesh.unit_m:g} m", "metres", f"{mesh.path.suffix} states it"
                )
            return mesh.unit_m
        if self.options.unit is not None and abs(scale - 1.0) < 1e-9:
            if self.options.unit != 1.0:
                self.changes.note(name, "unit", f"{self.options.unit:g} m", "metres", "as given")
            return self.options.unit
        if SMALLEST_M <= extent <= LARGEST_M:
            return 1.0
        if _SMALLEST_MM <= extent <= _LARGEST_MM:
            self.changes.note(
                name, "unit", f"none; it measures {extent:.4g}", "taken for millimetres",
                f"as metres it would be {extent:.0f} m long",
            )  # fmt: skip
            return UNITS["mm"]
        raise AssetError(
            codes.UNIT,
            f"{mesh.path.name} states no unit and measures {extent:.4g}, which is implausible in "
            f"metres and in millimetres; give it with --unit {'|'.join(UNITS)}",
        )

    def _turn(
        self,
        mesh: MeshFile,
        name: str,
        shape: ImportedShape,
        factors: Floats,
        reference: Floats | None,
    ) -> Floats:
        if self.options.up is not None:
            return _Z_UP[self.options.up]
        if mesh.up is None or mesh.up == "z":
            return np.eye(3)
        turn = _Z_UP[mesh.up]
        said = f"{mesh.up.upper()} up"
        if self.options.upright:
            self.changes.note(name, "up axis", said, "Z up", f"{mesh.path.suffix} states it")
            return turn
        if reference is not None:
            corners = box_corners(mesh.bounds)
            misfits = []
            for candidate in (np.eye(3), turn):
                moved = (corners @ candidate.T) * factors
                seen = placed(shape.pose, moved)
                box = np.stack([seen.min(axis=0), seen.max(axis=0)])
                misfits.append(float(np.abs(box - reference).max()))
            if misfits[1] < 0.7 * misfits[0]:
                self.changes.note(
                    name, "up axis", said, "Z up",
                    f"the other shape of its link fits so to {misfits[1] * 1000:.0f} mm, "
                    f"and as written to {misfits[0] * 1000:.0f} mm",
                )  # fmt: skip
                return turn
        self.changes.note(name, "up axis", said, "coordinates as written", "as ROS reads them")
        return np.eye(3)

    def _boxes(self, shapes: Sequence[ImportedShape], description: ImportedBody) -> Floats | None:
        """The box around shapes in their link, as far as they are known without a question."""
        corners: list[Floats] = []
        for shape in shapes:
            if shape.kind == "mesh":
                try:
                    mesh = self._load(self.packages.locate(shape.mesh, description.folder))
                except AssetError:
                    return None
                if mesh.up not in (None, "z"):
                    return None
                low_high = mesh.bounds * np.array(shape.size) * (mesh.unit_m or 1.0)
            else:
                points, _ = primitive_part(replace(shape, pose=Pose()))
                low_high = np.stack([points.min(axis=0), points.max(axis=0)])
            corners += list(placed(shape.pose, box_corners(low_high)))
        if not corners:
            return None
        return np.stack([np.min(corners, axis=0), np.max(corners, axis=0)])

    def _note_solid(self, link: str, role: Role, part: Part, pose: Pose) -> None:
        """Keep what a link looks like: its visuals or, without them, its collision shapes."""
        key = link if role == "visual" else f"{link}/collision"
        self.solids.setdefault(key, []).append((placed(pose, part[0]), part[1]))

    def _textured(self, mesh: MeshFile, shape: ImportedShape, link: Link, folder: Path) -> MeshFile:
        """A mesh with the texture of the material that the description gives it."""
        if not shape.texture or all(piece.uv is None for piece in mesh.pieces):
            self._painted(shape, link)
            return textured(mesh, None)
        path = self.packages.locate(shape.texture, folder)
        self.changes.note(
            f"link {link.name}", "texture", path.name, "kept",
            f"with the texture points of {mesh.path.name}",
        )  # fmt: skip
        return textured(mesh, load_picture(path))

    def _painted(self, shape: ImportedShape, link: Link) -> ImportedShape:
        """A visual whose texture is found, or left out."""
        if not shape.texture:
            return shape
        self.changes.note(
            f"link {link.name}", "texture", Path(shape.texture).name, "left out",
            "a texture of a URDF needs texture points that its shape lacks",
        )  # fmt: skip
        return replace(shape, texture="")

    def _draw(self, path: Path, mesh: MeshFile, link: str) -> tuple[str, bool]:
        """Write a mesh that is drawn; its path, and whether it has looks of its own."""
        pieces = decimated(mesh.pieces, self.options.triangles)
        count = sum(len(piece.faces) for piece in pieces)
        if count < mesh.triangles:
            self.changes.note(
                f"mesh {path.name}", "triangles", f"{mesh.triangles:,}", f"{count:,}",
                "so many are not seen, and slow cameras down",
            )  # fmt: skip
        if path.suffix.lower() != ".obj":
            self.changes.note(f"mesh {path.name}", "format", path.suffix[1:].upper(), "OBJ", link)
        stem = self._stem(path)
        for name, content in obj_files(stem, pieces).items():
            self.files[f"meshes/{name}"] = content
        colored = any(piece.color is not None or piece.texture is not None for piece in pieces)
        return f"meshes/{stem}.obj", colored

    def _write_compound(self, path: Path, found: Fit) -> str:
        content = compound_obj(found.parts)
        for name, other in self.files.items():
            if other == content:
                return name
        name = f"meshes/{self._stem(path, '_collision')}.obj"
        self.files[name] = content
        return name

    def _stem(self, path: Path, suffix: str = "") -> str:
        """A name for a mesh that is not taken."""
        stem = re.sub(r"[^A-Za-z0-9_-]+", "_", path.stem).strip("_")[:60] or "mesh"
        candidates = (f"{stem}{suffix}", *(f"{stem}{suffix}_{n}" for n in range(2, 999)))
        name = next(one for one in candidates if one not in self._stems)
        self._stems.add(name)
        return name


def _places(sources: Sequence[_Source]) -> set[object]:
    return {one.shape.place for one in sources}


_ROLES: tuple[Role, ...] = ("visual", "collision")


def link_parts(geometry: Geometry, link: str) -> list[Part]:
    """What a link looks like or, where nothing is seen, what of it collides; in its frame."""
    return geometry.solids.get(link) or geometry.solids.get(f"{link}/collision") or []


def _error_words(found: Fit) -> str:
    tried = ", ".join(
        f"{name} {error * 1000:.1f}" for name, error in found.tried.items() if error < 1e6
    )
    return f"off by mm: {tried}" if tried else "as asked"


def _spaced(values: Sequence[float]) -> str:
    return " ".join(f"{value:g}" for value in values)


__all__ = ["Geometry", "link_parts"]
