"""Importing a robot or an object: from a file of its maker to a folder of ours."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from taskbuilder.assets import codes
from taskbuilder.assets.model import Urdf
from taskbuilder.assets.urdf import read_urdf
from taskbuilder.errors import FileError, Finding, Location, UsageError
from taskbuilder.geometry import Pose
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import ImportedBody, ImportedShape, Link
from taskbuilder.importing.geometry import Geometry
from taskbuilder.importing.limits import held_as_unused, with_followers, with_limits
from taskbuilder.importing.masses import with_masses
from taskbuilder.importing.mesh_options import MeshOptions
from taskbuilder.importing.mounting import Mount, is_cup, mounted, with_located_meshes
from taskbuilder.importing.naming import folder_name, proposed_name
from taskbuilder.importing.packages import Packages
from taskbuilder.importing.reading import is_mesh, read_description
from taskbuilder.importing.shells import without_shells
from taskbuilder.importing.steadying import with_steady_fingers
from taskbuilder.importing.writing import MARK, urdf_text
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.schema.robot import MOST_JOINTS
from taskbuilder.schema.robots import RobotModel, load_robot
from taskbuilder.trials.proposing import corrected
from taskbuilder.trials.robot_trial import GripperTrial
from taskbuilder.wording import quoted, suggestion
from taskbuilder.world.robot_file import robot_file
from taskbuilder.world.robot_proposal import Proposal, propose

_ROBOT_SLACK, _OBJECT_SLACK = math.inf, 1.0


@dataclass(frozen=True)
class ImportSource:
    """What is imported.

    Attributes:
        file: The file.
        packages: Package name -> folder, where they are not found upwards.
        arguments: Values of arguments of xacro files.
        root: The import root; None for the ROS package or repository of the file.
        name: The name of what is written; "" for that of the file.
        meshes: How meshes are imported.
        mass: Of the whole in kg, in place of what the file says.
        density: In kg/m³, in place of masses that the file says.
        mounts: What is mounted on a robot, one after the other: adapters, and a gripper.
        arm: A link of the arm that is meant, where there are several.
        suction: Force in newtons of the suction cup that it ends in; None for none, or for one that
            its names tell of.
    """

    file: Path
    packages: Mapping[str, Path] = field(default_factory=dict)
    arguments: Mapping[str, str] = field(default_factory=dict)
    root: Path | None = None
    name: str = ""
    meshes: MeshOptions = field(default_factory=MeshOptions)
    mass: float | None = None
    density: float | None = None
    mounts: tuple[Mount, ...] = ()
    arm: str | None = None
    suction: float | None = None


@dataclass(frozen=True)
class Imported:
    """What an import came to, not yet written.

    Attributes:
        name: The name of the folder.
        files: Content by path in the folder.
        changes: What was changed and left out.
        proposal: What a robot file says; None for objects, and for grippers alone.
        collisions: The text of a URDF that shows collision shapes in place of looks.
        warnings: What the check of the result warns of.
    """

    name: str
    files: Mapping[str, bytes]
    changes: Changes
    proposal: Proposal | None
    collisions: str
    warnings: tuple[Finding, ...]


TryGripper = Callable[[RobotModel], GripperTrial]
"""Tries the gripper of a robot in physics."""


@dataclass(frozen=True)
class ReadRobot:
    """A robot with all that was found out about it, before it is known what its arm is.

    Attributes:
        description: It, with what is mounted on it.
        geometry: Its meshes.
        changes: What was changed so far.
        suction: As of `propose`.
    """

    description: ImportedBody
    geometry: Geometry
    changes: Changes
    suction: float | None = None

    @contextmanager
    def urdf(self) -> Iterator[Urdf]:
        """What would be written, as it will be read; in a folder that is removed again."""
        name = self.description.name
        with _aside(name, self.description, self.geometry, self.changes) as urdf:
            yield urdf


def import_robot(source: ImportSource, try_gripper: TryGripper | None = None) -> Imported:
    """Read a robot and make the files of a folder of it.

    Args:
        source: What is imported.
        try_gripper: Tries the gripper that is proposed, so that its stroke and force are corrected
            by what is measured; None to leave them as they follow from the shapes.

    Raises:
        FileError: Something is wrong that cannot be mended without a guess.
        UsageError: Options are wrong, or the extra is not installed.
    """
    return finished(read_robot(source), source, try_gripper)


def read_robot(source: ImportSource) -> ReadRobot:
    """Read a robot, and what is mounted on it.

    Raises:
        FileError: Something is wrong that cannot be mended without a guess.
        UsageError: Options are wrong, or the extra is not installed.
    """
    changes = Changes()
    unknown: list[dict[str, Finding]] = [{}]
    packages, description = _read(source, changes, unknown[0] if source.mounts else None)
    description = with_followers(description, changes)
    parts = []
    for mount in source.mounts:
        other = Packages.around(mount.file, source.packages, source.root)
        unknown.append({})
        part = read_description(other, source.arguments, changes, unknown[-1])
        part = with_followers(part, changes)
        parts.append((with_located_meshes(part, other), mount.flange))
        packages.admit(other.roots)
    if nowhere := [name for name in unknown[0] if all(name in each for each in unknown)]:
        raise FileError([unknown[0][name] for name in nowhere])
    suction = source.suction
    if suction is None and parts and is_cup(parts[-1][0]):
        suction = 0.0
    description = mounted(description, parts, changes, suction=suction is not None)
    name = folder_name(source.name or proposed_name(description))
    description = replace(description, name=name)
    options = replace(source.meshes, slack=_ROBOT_SLACK)
    geometry = Geometry(packages, options, changes)
    _require_link(description, source.arm)
    description = _completed(description, geometry, source, changes)
    return ReadRobot(description, geometry, changes, suction)


def finished(
    read: ReadRobot,
    source: ImportSource,
    try_gripper: TryGripper | None,
    home: Mapping[str, float] | None = None,
    said: tuple[str, ...] = (),
) -> Imported:
    """The files of a folder of a robot that was read.

    Args:
        read: The robot.
        source: What is imported.
        try_gripper: As of `import_robot`.
        home: Joint -> position in rad or m that it begins in; by default as its file says, or as
            is found.
        said: What its robot file says at its beginning.

    Raises:
        FileError: It cannot be used.
    """
    description, geometry, changes = read.description, read.geometry, read.changes
    name = description.name
    home = home or description.postures.get("home")
    cup = read.suction
    with _aside(name, description, geometry, changes) as urdf:
        proposal = propose(urdf, end=source.arm, home=home, suction=cup)
    if proposal is not None:
        _require_arm(description, proposal)
        description = _without_unused(description, proposal, urdf, changes)
        description = geometry.refined(description, proposal.touching)
        description = with_steady_fingers(description, proposal, urdf, changes)
    with _aside(name, description, geometry, changes) as urdf:
        files = geometry.used_files(description)
        files[f"{name}.urdf"] = _text(description, source, changes).encode()
        warnings = urdf.warnings
        if proposal is not None:
            proposal = _again(proposal, propose(urdf, end=source.arm, home=home, suction=cup))
            written = urdf.path.parent / "robot.yaml"

            def loaded(proposal: Proposal) -> RobotModel:
                lines = (*_lines(urdf, source, description, changes), *said)
                text = robot_file(urdf, replace(proposal, remarks=(*lines, *proposal.remarks)))
                files["robot.yaml"] = text.encode()
                written.write_text(text, encoding="utf-8")
                return load_robot(CatalogueEntry(name, written))

            model = loaded(proposal)
            if try_gripper is not None and proposal.gripper:
                proposal = corrected(proposal, try_gripper(model))
                loaded(proposal)
    shown = urdf_text(_collisions_shown(description), ["collision shapes"])
    return Imported(name, files, changes, proposal, shown, warnings)


def _require_link(description: ImportedBody, arm: str | None) -> None:
    """Refuse a link of an arm that is not there.

    Raises:
        FileError: It is not.
    """
    links = [link.name for link in description.links]
    if arm is not None and arm not in links:
        right = suggestion(arm, links, otherwise="name one of its links")
        message = f"has no link {quoted(arm)} of an arm that is meant; {right}"
        raise FileError([Finding(codes.STRUCTURE, message, "", Location(description.file))])


def _require_arm(description: ImportedBody, proposal: Proposal) -> None:
    """Refuse a chain of joints that is longer than an arm may be.

    Raises:
        FileError: It is.
    """
    if proposal.too_long:
        first = proposal.arm[MOST_JOINTS].name
        place = next(joint.place for joint in description.joints if joint.name == first)
        finding = Finding(codes.NOT_IMPORTED, proposal.too_long, f"joint {first}", place)
        raise FileError([finding])


def import_object(source: ImportSource) -> Imported:
    """Read an object, a mesh or a description, and make the files of a folder of it.

    Raises:
        FileError: Something is wrong that cannot be mended without a guess.
        UsageError: The extra is not installed.
    """
    changes = Changes()
    mesh = is_mesh(source.file)
    if source.meshes.scale != 1.0 and not mesh:
        raise UsageError(
            f"{source.file.name} is no mesh, and --scale is for meshes; write scale under shape in "
            "the task file"
        )
    if mesh:
        packages = Packages.around(source.file, source.packages, source.root)
        description = _of_mesh(packages.file)
    else:
        packages, description = _read(source, changes)
    name = folder_name(source.name or proposed_name(description))
    description = replace(description, name=name)
    options = replace(source.meshes, slack=_OBJECT_SLACK, upright=mesh)
    geometry = Geometry(packages, options, changes)
    description = _completed(description, geometry, source, changes)
    with _aside(name, description, geometry, changes, fixed=False) as urdf:
        warnings = urdf.warnings
    files = geometry.used_files(description)
    files[f"{name}.urdf"] = _text(description, source, changes).encode()
    shown = urdf_text(_collisions_shown(description), ["collision shapes"])
    return Imported(name, files, changes, None, shown, warnings)


def _again(first: Proposal, second: Proposal | None) -> Proposal:
    """The proposal for the final shapes, with what was asked of joints that are fixed by now."""
    if second is None:
        return first
    known = {remark[:_BEGINNING] for remark in second.remarks}
    asked = tuple(remark for remark in first.remarks if remark[:_BEGINNING] not in known)
    return replace(second, remarks=(*asked, *second.remarks))


_BEGINNING = 20  # characters in which remarks on the same thing agree


def _read(
    source: ImportSource, changes: Changes, unknown: dict[str, Finding] | None = None
) -> tuple[Packages, ImportedBody]:
    if not source.file.exists():
        raise UsageError(f"there is no file {source.file}")
    packages = Packages.around(source.file, source.packages, source.root)
    return packages, read_description(packages, source.arguments, changes, unknown)


def _of_mesh(file: Path) -> ImportedBody:
    """The description of an object that is one mesh."""
    shape = ImportedShape("mesh", (1.0, 1.0, 1.0), Pose(), Location(file), file.name)
    link = Link("body", None, (shape,), (shape,), Location(file))
    return ImportedBody(file, file.parent, file.stem, (link,), ())


def _completed(
    description: ImportedBody, geometry: Geometry, source: ImportSource, changes: Changes
) -> ImportedBody:
    """The description with all that was found out.

    Raises:
        FileError: Meshes cannot be used.
    """
    description = without_shells(description, changes)
    description = geometry.converted(description)
    if geometry.findings:
        raise FileError(geometry.findings)
    description = with_masses(
        description, geometry, changes, mass=source.mass, density=source.density
    )
    return with_limits(description, changes)


def _without_unused(
    description: ImportedBody, proposal: Proposal, urdf: Urdf, changes: Changes
) -> ImportedBody:
    """The description with joints fixed that are neither of the arm nor of the gripper."""
    unused = {joint.name for joint in proposal.unused(urdf)}
    return held_as_unused(
        description, unused, changes, "it is neither of the arm nor of the gripper"
    )


@contextmanager
def _aside(
    name: str,
    description: ImportedBody,
    geometry: Geometry,
    changes: Changes,
    *,
    fixed: bool = True,
) -> Iterator[Urdf]:
    """The URDF written to a folder that is removed again, and read as it will be read."""
    with tempfile.TemporaryDirectory(prefix="taskbuilder-") as temporary:
        folder = Path(temporary).resolve() / name
        for path, content in geometry.used_files(description).items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_bytes(content)
        folder.mkdir(exist_ok=True)
        file = folder / f"{name}.urdf"
        file.write_text(urdf_text(description, changes.lines()), encoding="utf-8")
        try:
            urdf = read_urdf(file, (folder,), fixed=fixed)
        except FileError as error:
            raise FileError([_at_source(one, description) for one in error.findings]) from error
        yield urdf


def _at_source(finding: Finding, description: ImportedBody) -> Finding:
    """A finding about what would be written, at the part of the source that it comes from."""
    kind, _, name = finding.path.partition(" ")
    parts = description.links if kind == "link" else description.joints
    place = next((part.place for part in parts if part.name == name), Location(description.file))
    return replace(finding, location=place)


def _text(description: ImportedBody, source: ImportSource, changes: Changes) -> str:
    comment = [f"{MARK} from {source.file.name}"]
    comment += [f"with {mount.file.name} on {mount.flange}" for mount in source.mounts]
    return urdf_text(description, [*comment, "", *changes.lines()])


def _lines(
    urdf: Urdf, source: ImportSource, description: ImportedBody, changes: Changes
) -> list[str]:
    """What a robot file says of where it comes from."""
    others = [name for name in description.postures if name != "home"]
    lines = [f"{MARK} from {source.file.name}; {urdf.path.name} lists the changes"]
    if "home" in description.postures:
        lines.append("home_deg is the posture home of the file")
    elif others:
        lines.append(f"the file also names the postures {', '.join(others)}")
    if changes.left_out:
        lines.append(f"{urdf.path.name} also lists what was left out")
    return lines


def _collisions_shown(description: ImportedBody) -> ImportedBody:
    """The description with its collision shapes as looks, each link in a colour of its own."""
    links = []
    for number, link in enumerate(description.links):
        color = _PALETTE[number % len(_PALETTE)]
        shapes = tuple(replace(shape, color=color) for shape in link.collisions)
        links.append(replace(link, visuals=shapes))
    return replace(description, links=tuple(links))


_PALETTE = (
    (0.90, 0.62, 0.0, 1.0),
    (0.34, 0.71, 0.91, 1.0),
    (0.0, 0.62, 0.45, 1.0),
    (0.94, 0.89, 0.26, 1.0),
    (0.0, 0.45, 0.70, 1.0),
    (0.84, 0.37, 0.0, 1.0),
    (0.80, 0.47, 0.65, 1.0),
)
