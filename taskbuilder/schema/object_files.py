"""Objects of the catalogue: a body with its files, mass and grasp points, for any task to use."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.assets import codes
from taskbuilder.assets.mesh import Mesh, read_mesh
from taskbuilder.assets.model import Urdf
from taskbuilder.assets.paths import AssetError, packages_named_in, resolve
from taskbuilder.assets.urdf import read_urdf
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.schema.articulation import check_object
from taskbuilder.schema.bodies import BodySpec
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.schema.explain import parse
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.source import Path_, Source, dotted, read_source
from taskbuilder.schema.values import Name, Text, exactly_one, frozen

MESHES = (".obj", ".stl")
"""Endings of meshes that are read as they are; others have to be imported."""

WATER_KG_M3 = 1000.0


class ObjectFileSpec(BodySpec):
    """An object file: a body that tasks place by its name."""

    object: Name = Field(description="Name of the object; the same as that of its folder.")
    summary: Text = Field(description="What the object is, in one sentence.")

    @model_validator(mode="after")
    def _whole(self) -> ObjectFileSpec:
        exactly_one("an object", self, "shape", "parts")
        if self.urdf is None and self.joints:
            raise PydanticCustomError("choice", "joints goes with urdf only")
        if self.urdf is None and self.mass is None and self.density is None:
            raise PydanticCustomError("mass", "mass is missing; give kilograms, or a density")
        return self


@dataclass(frozen=True)
class Assets:
    """The files of an object, read.

    Attributes:
        main: Its mesh or URDF; None without one.
        collision: The mesh by which it collides, if that is another one.
        warnings: What is doubtful.
    """

    main: Mesh | Urdf | None = None
    collision: Mesh | None = None
    warnings: tuple[Finding, ...] = ()


@dataclass(frozen=True)
class ObjectModel:
    """An object of the catalogue.

    Attributes:
        entry: Its entry in the catalogue.
        spec: What its file says.
        assets: Its mesh or URDF.
    """

    entry: CatalogueEntry
    spec: ObjectFileSpec
    assets: Assets = field(default_factory=Assets)


def load_object(entry: CatalogueEntry, roots: Sequence[Path] = ()) -> ObjectModel:
    """Read and check an object file and the files that it names.

    Args:
        entry: The object's entry in the catalogue.
        roots: Folders, besides its own, in which its assets may lie.

    Raises:
        FileError: With every finding.
    """
    source = read_source(entry.file)
    spec, wrong = parse(ObjectFileSpec, source)
    findings = [*source.findings, *wrong]
    assets = Assets()
    try:
        assets = read_assets(
            source, (), entry.root, (entry.root, *roots), fixed=False, trusted=entry.trusted
        )
    except FileError as error:
        findings += error.findings
    if spec is not None:
        if spec.object != entry.file.parent.name and entry.file.name == "object.yaml":
            message = f'is "{spec.object}"; the folder is "{entry.file.parent.name}": use one name'
            findings.append(Finding("TB109", message, "object", source.locate(("object",))))
        findings += _check_body(source, spec, assets)
    if spec is None or any(finding.severity == "error" for finding in findings):
        raise FileError([*findings, *assets.warnings])
    return ObjectModel(entry, spec, assets)


def bare_object(file: Path, *, name: str = "") -> ObjectModel:
    """A URDF or a mesh alone, as an object without an object file.

    A mesh states no mass and is given water's density.

    Args:
        file: A URDF, an OBJ or an STL.
        name: What it is called; by default as its file.

    Raises:
        FileError: With every finding.
    """
    path = file.absolute()
    entry = CatalogueEntry(name or path.stem, path)
    about = {"object": "bare", "summary": f"{path.name}, without an object file"}
    if path.suffix.lower() in MESHES:
        try:
            mesh = read_mesh(path)
        except AssetError as error:
            raise FileError([error.finding(location=Location(path))]) from error
        spec = {**about, "shape": {"mesh": path.name}, "density": WATER_KG_M3}
        return ObjectModel(entry, ObjectFileSpec.model_validate(spec), Assets(mesh))
    urdf = read_urdf(path, (path.parent, *packages_named_in(path)), fixed=False)
    spec = {**about, "shape": {"urdf": path.name}}
    assets = Assets(urdf, None, urdf.warnings)
    return ObjectModel(entry, ObjectFileSpec.model_validate(spec), assets)


def read_assets(
    source: Source, path: Path_, folder: Path, roots: Sequence[Path], *, fixed: bool, trusted: bool
) -> Assets:
    """Read the meshes or the URDF that an object names.

    Args:
        source: The file that describes the object.
        path: Where in it that is.
        folder: Folder that references start from.
        roots: Folders inside which the files must lie.
        fixed: Whether the object is fixed to the world.
        trusted: Whether the files belong to an installed package.

    Raises:
        FileError: With every finding.
    """
    findings: list[Finding] = []

    def asset(key: str, read: Any) -> Any:
        place: Path_ = (*path, "shape", key)
        reference = source.get(*place)
        if not isinstance(reference, str) or not reference:
            return None
        try:
            return read(resolve(reference, folder, roots))
        except AssetError as error:
            findings.append(error.finding(dotted(place), source.locate(place)))
        except FileError as error:
            findings.extend(error.findings)
        return None

    mesh, collision = asset("mesh", read_mesh), asset("collision", read_mesh)
    urdf = asset("urdf", partial(read_urdf, roots=roots, fixed=fixed, trusted=trusted))
    if findings:
        raise FileError(findings)
    warnings = urdf.warnings if isinstance(urdf, Urdf) else ()
    if source.get(*path, "mass") or source.get(*path, "density"):  # which every link then has
        warnings = tuple(warning for warning in warnings if warning.code != codes.MASS)
    return Assets(urdf or mesh, collision, warnings)


def with_objects(scene: SceneSpec, models: Mapping[str, ObjectModel]) -> SceneSpec:
    """A scene in which objects of the catalogue say what their files say.

    Args:
        scene: The scene as it is written.
        models: The model of each object that has one, by its name in the scene.
    """
    if not models:
        return scene
    objects = {
        name: merged(spec, models[name].spec) if name in models else spec
        for name, spec in scene.objects.items()
    }
    return scene.model_copy(update={"objects": frozen(objects)})


def merged(spec: ObjectSpec, file: BodySpec) -> ObjectSpec:
    """An object of a scene with all that its file says and the scene does not.

    Of grasp points and joints, those that the task names are replaced, each as a whole.
    """
    written = spec.model_fields_set
    said = file.model_fields_set & BodySpec.model_fields.keys()
    if written & {"mass", "density"}:
        said -= {"mass", "density"}
    update: dict[str, Any] = {key: getattr(file, key) for key in said - written}
    for key in ("grasps", "joints"):
        both = {**getattr(file, key), **getattr(spec, key)}
        if both:
            update[key] = frozen(both)
    return spec.model_copy(update=update)


def check_use(source: Source, name: str, thing: ObjectSpec) -> Iterator[Finding]:
    """What a scene makes of an object of the catalogue that is not possible with it."""
    if thing.object is None:
        return
    path: Path_ = ("scene", "objects", name, "object")
    if not thing.fixed and thing.shape is not None and thing.shape.collide == "exact":
        message = f"{thing.object} has collide: exact, so it cannot move; write fixed: true"
        yield Finding("TB106", message, dotted(path), source.locate(path))
    if thing.urdf is not None and thing.arrange is not None and thing.arrange.pile is not None:
        message = f"{thing.object} is a URDF, and URDFs make no pile; choose another arrangement"
        yield Finding("TB106", message, dotted(path), source.locate(path))
    known = thing.shape is not None or thing.parts is not None  # else another finding says so
    if known and thing.urdf is None and thing.joints:
        message = f"{thing.object} is no URDF and has no joints; leave joints out"
        yield Finding("TB106", message, dotted(path), source.locate(path))


def _check_body(source: Source, spec: ObjectFileSpec, assets: Assets) -> Iterator[Finding]:
    """What of an object file does not fit its URDF."""
    place: Path_ = ("scene", "objects", spec.object)
    values = {(*place, *path): mark for path, mark in source.values.items()}
    keys = {(*place, *path): mark for path, mark in source.keys.items()}
    shifted = Source(source.file, source.data, values, keys)
    for finding in check_object(shifted, spec.object, as_placed(spec), assets.main):
        yield replace(finding, path=finding.path.removeprefix(f"{dotted(place)}."))


def as_placed(spec: ObjectFileSpec) -> ObjectSpec:
    """An object of the catalogue as it would be in a scene, at its origin."""
    bare = ObjectSpec.model_construct(
        _fields_set={"position"}, position=(0.0, 0.0, 0.0), object=spec.object
    )
    return merged(bare, spec)
