"""Load a task file: its models, its robots and the assets it names, with every finding at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from taskbuilder.assets.mesh import Mesh
from taskbuilder.assets.model import Urdf
from taskbuilder.assets.paths import AssetError, resolve
from taskbuilder.errors import FileError, Finding, Fix, UnknownNameError
from taskbuilder.schema.articulation import check_object, check_orders, check_surfaces
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry, looks_like_path
from taskbuilder.schema.end_effectors import check_end_effectors
from taskbuilder.schema.explain import parse
from taskbuilder.schema.groups import (
    check_arrangements,
    entries_of,
    expanded,
    expanded_scene,
    of_members,
)
from taskbuilder.schema.instructions import fill
from taskbuilder.schema.names import ObjectNames, SceneNames
from taskbuilder.schema.object_files import (
    ObjectModel,
    check_use,
    load_object,
    read_assets,
    with_objects,
)
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.references import check_names, read_names
from taskbuilder.schema.robots import RobotModel, check_joint_values, load_robot
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.source import Path_, Source, dotted, read_source
from taskbuilder.schema.task import TaskSpec
from taskbuilder.schema.variants import check_randomize, read_variations
from taskbuilder.wording import suggestion


@dataclass(frozen=True)
class TaskFile:
    """A task file that has been found right, with what it refers to.

    Attributes:
        entry: Its entry in the catalogue.
        source: Its text's marks, for findings that turn up later.
        spec: Its content, with groups written out.
        scenes: The plain scene, then one for each variation, likewise.
        robots: The model of each robot, by its name in the scene.
        assets: Mesh or URDF of each object that has one, by the object's name.
        collisions: Mesh by which an object collides, where that is another one, likewise.
        models: The model of each object of the catalogue, likewise.
        names: Every name of the scene.
        written: Its content as it is in the file.
        warnings: What is doubtful.
        catalogue: Where its robots were looked up.
        named: The objects and sites that the task is about, and how far around each of them that
            extends, in metres. `load_task` fills it in from the description and the instructions.
    """

    entry: CatalogueEntry
    source: Source
    spec: TaskSpec
    scenes: tuple[SceneSpec, ...]
    robots: Mapping[str, RobotModel]
    assets: Mapping[str, Mesh | Urdf]
    names: SceneNames
    written: TaskSpec
    warnings: tuple[Finding, ...] = ()
    catalogue: Catalogue = field(default_factory=Catalogue)
    collisions: Mapping[str, Mesh] = field(default_factory=dict)
    models: Mapping[str, ObjectModel] = field(default_factory=dict)
    named: Mapping[str, float] = field(default_factory=dict)

    def check_cameras(self, names: Iterable[str], variation: int = 0) -> None:
        """Refuse cameras that the scene of a variation does not have.

        Raises:
            UnknownNameError: There is no such camera.
        """
        cameras = self.scenes[variation].cameras
        for name in names:
            if name not in cameras:
                help_ = suggestion(name, cameras, what="it has")
                raise UnknownNameError(f'{self.spec.task} has no camera "{name}"; {help_}')


class TaskFileError(FileError):
    """A task file is wrong.

    Attributes:
        names: The names of the scene, if what is wrong leaves no doubt about them.
    """

    def __init__(self, findings: Iterable[Finding], names: SceneNames | None = None) -> None:
        super().__init__(findings)
        self.names = names


@dataclass
class _Loading:
    """A task file on its way: what has been read, and what has been found wrong."""

    entry: CatalogueEntry
    source: Source
    catalogue: Catalogue
    findings: list[Finding] = field(default_factory=list)
    robots: dict[str, RobotModel] = field(default_factory=dict)
    assets: dict[str, Mesh | Urdf] = field(default_factory=dict)
    collisions: dict[str, Mesh] = field(default_factory=dict)
    models: dict[str, ObjectModel] = field(default_factory=dict)

    @property
    def roots(self) -> tuple[Path, ...]:
        return (self.entry.root, *self.catalogue.folders)

    def report(self, code: str, message: str, path: Path_, *, key: bool = False) -> None:
        location = self.source.locate(path, key=key)
        self.findings.append(Finding(code, message, dotted(path), location))

    def report_name(self, error: UnknownNameError, path: Path_) -> None:
        """Report that a name of the catalogue stands for nothing."""
        location, name = self.source.locate(path), self.source.get(*path)
        fix = Fix(location, name, error.meant) if error.meant else None
        self.findings.append(Finding("TB009", str(error), dotted(path), location, fix=fix))


def read_task(entry: CatalogueEntry, catalogue: Catalogue) -> TaskFile:
    """Read and check a task file and everything that it names, except its description.

    Raises:
        TaskFileError: With every finding of the file and of the robots and assets it names.
    """
    loading = _Loading(entry, read_source(entry.file), catalogue)
    spec, wrong = parse(TaskSpec, loading.source)
    loading.findings += [*loading.source.findings, *wrong]
    _read_robots(loading)
    _read_objects(loading)
    handless = tuple(name for name, model in loading.robots.items() if not model.takes_hold)
    bodies = {name: model.spec for name, model in loading.models.items()}
    names = read_names(loading.source, _articulated(loading.assets), handless, bodies)
    loading.findings += check_names(loading.source, names)
    scenes: list[SceneSpec] = []
    written = spec
    if spec is not None:
        scenes, wrong_variations = read_variations(loading.source, names, spec.scene)
        spec = spec.model_copy(update={"scene": with_objects(spec.scene, loading.models)})
        _check_whole(loading, spec)
        scenes = [with_objects(scene, loading.models) for scene in scenes]
        loading.findings += wrong_variations
        if not wrong_variations:
            _check_varied(loading, spec, scenes)
        loading.findings += check_randomize(loading.source, names, spec)
        loading.findings += _check_instructions(loading.source, spec, scenes)
    if not (spec and written) or any(f.severity == "error" for f in loading.findings):
        raise TaskFileError(loading.findings, _certain(loading.source, names, loading.findings))
    return TaskFile(
        entry,
        replace(loading.source, entries_of=entries_of(names)),
        expanded(spec, names, loading.assets),
        tuple(expanded_scene(scene, names, loading.assets) for scene in (spec.scene, *scenes)),
        loading.robots,
        of_members(names, loading.assets),
        names,
        written,
        tuple(loading.findings),
        catalogue,
        of_members(names, loading.collisions),
        of_members(names, loading.models),
    )


_WHAT_NAMES = ("robots", "objects", "sites", "cameras")
_NAMELESS = ObjectSpec.model_fields.keys() - {"object", "shape", "parts", "grasps"}
"""The keys of an object that name nothing inside it."""


def _certain(source: Source, names: SceneNames, findings: Sequence[Finding]) -> SceneNames | None:
    """The names of a scene in whose file there are mistakes; None where names may be missing.

    An object may have any part if a mistake may hide parts, and a site in which something is wrong
    any marker.
    """
    if () in names.groups.values():
        return None
    objects, sites = dict(names.objects), dict(names.sites)
    for finding in findings:
        if finding.code.startswith("TB00") and finding.code != "TB009":
            return None  # not all of the file was read
        if finding.code == "TB107":
            return None  # it will have another name
        top, _, rest = finding.path.partition(".")
        group, _, name = rest.partition(".")
        misplaced = finding.code == "TB102" and not rest  # "objects" may stand at the top
        if misplaced or (top == "scene" and (group not in _WHAT_NAMES or not name)):
            return None
        name, _, inside = name.partition(".")
        if top == "scene" and (name in objects or name in names.groups):
            if _whole_inside(source, name, inside.partition(".")[0], finding):
                continue
            for one in names.groups.get(name, (name,)):
                objects[one] = replace(objects[one], unread=True)
        elif top == "scene" and name in sites:
            sites[name] = True
    return replace(names, objects=objects, sites=sites)


def _whole_inside(source: Source, name: str, key: str, finding: Finding) -> bool:
    """Whether a mistake in an object leaves all names inside it as they are."""
    if key:
        return key in _NAMELESS
    shaped = any(
        source.get("scene", "objects", name, part) for part in ("object", "shape", "parts")
    )
    return finding.code == "TB101" and shaped  # something is missing, and it is not these


def _read_robots(loading: _Loading) -> None:
    models: dict[Path, RobotModel] = {}
    for name, _ in loading.source.entries("scene", "robots"):
        path = ("scene", "robots", name, "model")
        reference = loading.source.get(*path)
        if not isinstance(reference, str) or not reference:
            continue
        try:
            if looks_like_path(reference):
                resolve(reference, loading.entry.root, loading.roots)
            entry = loading.catalogue.robot(reference, loading.entry.root)
            if entry.file not in models:
                models[entry.file] = load_robot(entry, loading.roots)
            loading.robots[name] = models[entry.file]
        except UnknownNameError as error:
            loading.report_name(error, path)
        except AssetError as error:
            loading.report(error.code, error.message, path)
        except FileError as error:
            loading.findings += error.findings
    # What is doubtful about a packaged robot is not for the task's author to mend.
    own = [model for model in models.values() if not model.entry.trusted]
    loading.findings += [warning for model in own for warning in model.warnings]


def _read_objects(loading: _Loading) -> None:
    """The files of objects: their own, or those of an object of the catalogue."""
    for name, _ in loading.source.entries("scene", "objects"):
        path: Path_ = ("scene", "objects", name)
        reference = loading.source.get(*path, "object")
        try:
            if isinstance(reference, str) and reference:
                loading.models[name] = _model(loading, reference)
                assets = loading.models[name].assets
            else:
                fixed = loading.source.get(*path, "fixed") is True
                trusted = loading.entry.trusted
                root = loading.entry.root
                assets = read_assets(
                    loading.source, path, root, loading.roots, fixed=fixed, trusted=trusted
                )
                loading.findings += assets.warnings
        except UnknownNameError as error:
            loading.report_name(error, (*path, "object"))
        except AssetError as error:
            loading.report(error.code, error.message, (*path, "object"))
        except FileError as error:
            loading.findings += error.findings
        else:
            if assets.main is not None:
                loading.assets[name] = assets.main
            if assets.collision is not None:
                loading.collisions[name] = assets.collision


def _model(loading: _Loading, reference: str) -> ObjectModel:
    """An object of the catalogue, or of a file of the task."""
    if looks_like_path(reference):
        resolve(str(Path(reference)), loading.entry.root, loading.roots)
    entry = loading.catalogue.object(reference, loading.entry.root)
    known = {model.entry.file: model for model in loading.models.values()}
    if entry.file in known:
        return known[entry.file]
    model = load_object(entry, loading.roots)
    # What is doubtful about a packaged object is not for the task's author to mend.
    loading.findings += () if entry.trusted else model.assets.warnings
    return model


def _articulated(assets: Mapping[str, Mesh | Urdf]) -> dict[str, ObjectNames]:
    return {
        name: ObjectNames(
            parts=tuple(link.name for link in asset.links),
            joints={joint.name: joint.type for joint in asset.moving_joints},
            fixed=tuple(joint.name for joint in asset.joints if not joint.moves),
        )
        for name, asset in assets.items()
        if isinstance(asset, Urdf)
    }


def _check_whole(loading: _Loading, spec: TaskSpec) -> None:
    """What only shows with the robots and assets at hand."""
    if spec.task != loading.entry.file.stem:
        message = f'is "{spec.task}"; the file is "{loading.entry.file.name}": use one name'
        loading.report("TB109", message, ("task",))
    observers = spec.observe if spec.observe is not None else spec.scene.robots
    unknown = set(observers) - set(spec.scene.robots)
    for name in spec.scene.robots:
        if name not in observers and not unknown:  # else it may be the one that was meant
            message = f'has no entry for the robot "{name}"; list what it observes, if only []'
            loading.report("TB101", message, ("observe",), key=True)
    loading.findings += _check_scene(loading, spec, spec.scene)


def _check_varied(loading: _Loading, spec: TaskSpec, scenes: Sequence[SceneSpec]) -> None:
    """What only a variation gets wrong, each reported at its variation."""
    known = {(finding.path, finding.message) for finding in loading.findings}
    for index, scene in enumerate(scenes):
        for finding in _check_scene(loading, spec, scene):
            if (finding.path, finding.message) not in known:
                message = f"{finding.path}: {finding.message}"
                loading.report(finding.code, message, ("variations", index))


def _check_scene(loading: _Loading, spec: TaskSpec, scene: SceneSpec) -> Iterator[Finding]:
    """Joint values that do not fit their URDFs, and groups that do not fit as they are arranged."""
    for name, robot in scene.robots.items():
        model = loading.robots.get(name)
        if model is None:
            continue
        path: Path_ = ("scene", "robots", name)
        if robot.home is not None and robot.home.joints_deg is not None:
            place: Path_ = (*path, "home", "joints_deg")
            yield from _check_posture(loading.source, place, model, robot.home.joints_deg)
        for key, posture in robot.postures.items():
            place = (*path, "postures", key, "joints_deg")
            yield from _check_posture(loading.source, place, model, posture.joints_deg)
    for name, thing in scene.objects.items():
        yield from check_object(loading.source, name, thing, loading.assets.get(name))
        yield from check_use(loading.source, name, thing)
    yield from check_surfaces(loading.source, scene, loading.assets)
    yield from check_arrangements(loading.source, scene, loading.assets)
    yield from check_orders(loading.source, spec.expert, scene, loading.assets)
    yield from check_end_effectors(loading.source, spec.expert, scene, loading.robots)


def _check_posture(
    source: Source, path: Path_, model: RobotModel, joints_deg: Sequence[float]
) -> Iterator[Finding]:
    if len(joints_deg) != len(model.arm):
        message = f"has {len(joints_deg)} values; {model.name} has {len(model.arm)} arm joints"
        yield Finding("TB302", message, dotted(path), source.locate(path))
    else:
        yield from check_joint_values(source, path, model.arm, joints_deg)


def _check_instructions(
    source: Source, spec: TaskSpec, scenes: Sequence[SceneSpec]
) -> Iterator[Finding]:
    for index, text in enumerate(spec.instructions):
        path: Path_ = ("instructions", index)
        try:
            for scene in (spec.scene, *scenes):
                fill(text, scene)
        except (ValueError, UnknownNameError) as error:
            yield Finding("TB205", str(error), dotted(path), source.locate(path))
