"""Reading a URDF: everything that is wrong with it at once, and a text that is safe to load."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from taskbuilder.assets import codes
from taskbuilder.assets.files import Files
from taskbuilder.assets.joints import check_mimics, joint_moves, read_joint
from taskbuilder.assets.links import read_link, read_material
from taskbuilder.assets.markup import MAX_BYTES, Element, parse, serialized
from taskbuilder.assets.model import JointType, Urdf, UrdfJoint, UrdfLink
from taskbuilder.assets.paths import AssetError, package_of, require_readable
from taskbuilder.assets.report import Report
from taskbuilder.assets.schema import cleaned, number
from taskbuilder.assets.tree import check_names, check_tree
from taskbuilder.errors import FileError, Location

MOST_LINKS = 128
"""Of the physics engine, which ends the process on more."""

_NO_INERTIA = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0")
_ENGINES_INERTIA = _NO_INERTIA | dict.fromkeys(("ixx", "iyy", "izz"), "1")
"""What Bullet takes for a link of 1 kg without a word about it."""


def read_urdf(
    path: Path, roots: Sequence[Path], *, fixed: bool = False, trusted: bool = False
) -> Urdf:
    """Reads and checks a robot description and the files that it names.

    Args:
        path: The URDF file.
        roots: Folders inside which its meshes and textures must lie; those of pybullet_data
            and of the ROS package that the file is in are allowed as well.
        fixed: Whether its root is fixed to the world, so that the mass of links without a moving
            joint above them does not matter.
        trusted: Whether to take the content of meshes for good, as of those that come with
            this package and pybullet_data. That they exist is checked all the same.

    Raises:
        FileError: Something is wrong with it; the findings tell all of it.
    """
    robot = _robot_element(path)
    report = Report(path)
    robot = cleaned(robot, report)
    roots = (*roots, *package_of(path))
    files = Files(path.resolve().parent, roots, trusted=trusted, report=report)
    name = _robot_name(robot, report)
    count = len(list(robot.all("link")))
    if count > MOST_LINKS:
        message = f"the robot has {count} links; at most {MOST_LINKS}, so join fixed ones"
        report.error(codes.TOO_MANY, robot, "", message)
    named_links = check_names(robot.all("link"), report)
    check_names(robot.all("joint"), report)
    root = check_tree(robot, named_links, list(robot.all("joint")), report)
    if not fixed and root in named_links:
        _check_root(named_links[root], report)
    joints = _joints(robot, report)
    still = _unmoved(robot) if fixed else frozenset()
    links = _links(robot, still, report, files)
    for material in robot.all("material"):
        read_material(material, f"material {material.get('name')}", files)
    return Urdf(
        path=path,
        name=name,
        root=root,
        links=links,
        joints=joints,
        meshes=tuple(dict.fromkeys(files.meshes.values())),
        textures=tuple(dict.fromkeys(files.textures.values())),
        warnings=report.warnings(),
        files={**files.meshes, **files.textures},
        tree=robot,
    )


def with_limits(urdf: Urdf, limits: Mapping[str, tuple[float, float]]) -> Urdf:
    """The same with other limits of some joints; one that turned without end has an end then.

    Args:
        urdf: What was read.
        limits: Least and greatest position (rad or m) by the name of the joint.
    """
    if not limits:
        return urdf
    joints = tuple(
        replace(joint, type=_LIMITED.get(joint.type, joint.type), lower=ends[0], upper=ends[1])
        if (ends := limits.get(joint.name))
        else joint
        for joint in urdf.joints
    )
    children = tuple(
        _with_ends(child, *limits[child.attributes["name"]])
        if child.tag == "joint" and child.attributes["name"] in limits
        else child
        for child in urdf.tree.children
    )
    return replace(urdf, joints=joints, tree=urdf.tree.with_children(children))


_LIMITED: Mapping[JointType, JointType] = {"continuous": "revolute"}


def _with_ends(joint: Element, lower: float, upper: float) -> Element:
    """A joint's element with other limits."""
    limit = joint.first("limit") or Element("limit", {}, joint.line, joint.column)
    limit = limit.with_attributes(lower=repr(lower), upper=repr(upper))
    others = tuple(child for child in joint.children if child.tag != "limit")
    joint = joint.with_children((*others, limit))
    kind = "revolute" if joint.get("type") == "continuous" else joint.attributes["type"]
    return joint.with_attributes(type=kind)


def resolved_text(urdf: Urdf) -> str:
    """The URDF to give to the physics engine, with checked absolute file names.

    It holds only what was checked. Axes get a length of 1, because Bullet takes another length
    for a scale of the joint's position. A frame (a link on a joint, without inertia and collision
    shapes) gets a mass of 0, because Bullet would make it weigh 1 kg. Other links without a mass
    get what Bullet takes for them, which it would warn of; `read_urdf` does, where it matters.

    Args:
        urdf: What was read.
    """
    children = {joint.child for joint in urdf.joints if not joint.moves}
    assumed = {
        link.name: link.name not in children or bool(link.collisions)
        for link in urdf.links
        if link.mass is None and link.name != "world"  # which Bullet takes for the world itself
    }
    return serialized(_for_engine(urdf.tree, urdf, assumed))


def _for_engine(element: Element, urdf: Urdf, assumed: Mapping[str, bool]) -> Element:
    """The element with its file names and missing masses filled in.

    Args:
        element: The element.
        urdf: What was read.
        assumed: By the name of each link without a mass, whether it weighs 1 kg or nothing.
    """
    children = tuple(
        _for_engine(child, urdf, assumed) for child in element.children if not _says_nothing(child)
    )
    if element.tag == "material" and not element.get("name"):
        # Bullet refuses a material without a name, and takes the same name for the same colour.
        name = f"at_{element.line}_{element.column}"
        return element.with_children(children).with_attributes(name=name)
    if element.tag == "link" and element.attributes["name"] in assumed:
        children = (_assumed(element, assumed[element.attributes["name"]]), *children)
    if element.tag in ("mesh", "texture"):
        checked = urdf.files[element.attributes["filename"]]
        element = element.with_attributes(filename=str(checked))
    if element.tag == "joint":
        axis = " ".join(map(repr, urdf.joint(element.attributes["name"]).axis))
        children = tuple(
            child.with_attributes(xyz=axis) if child.tag == "axis" else child for child in children
        )
    return element.with_children(children)


def _says_nothing(element: Element) -> bool:
    """Whether an element is a material that has no name, colour or texture."""
    return element.tag == "material" and not element.get("name") and not element.children


def _assumed(link: Element, heavy: bool) -> Element:
    mass = Element("mass", {"value": "1" if heavy else "0"}, link.line, link.column)
    moments = _ENGINES_INERTIA if heavy else _NO_INERTIA
    inertia = Element("inertia", moments, link.line, link.column)
    return Element("inertial", {}, link.line, link.column, (mass, inertia))


def _robot_element(path: Path) -> Element:
    """The root element of a URDF file.

    Raises:
        FileError: The file cannot be read, is no XML, or describes something else.
    """
    try:
        require_readable(path, path.name, MAX_BYTES)
        data = path.read_bytes()
    except AssetError as error:
        raise FileError([error.finding(location=Location(path))]) from error
    except OSError as error:
        problem = AssetError(codes.NOT_READABLE, f"{path.name} cannot be read: {error}")
        raise FileError([problem.finding(location=Location(path))]) from error
    root = parse(path, data)
    if root.tag != "robot":
        report = Report(path)
        message = f"the root element is <{root.tag}>; a URDF begins with <robot name=…>"
        report.error(codes.STRUCTURE, root, "", message)
        report.warnings()
    return root


def _robot_name(robot: Element, report: Report) -> str:
    name = robot.get("name") or ""
    if not name:
        report.error(codes.NAME, robot, "", "the robot has no name; write <robot name=…>")
    return name


def _check_root(root: Element, report: Report) -> None:
    """Reports a root that is not fixed and that cannot move all the same."""
    name, inertial = root.get("name"), root.first("inertial")
    element = inertial.first("mass") if inertial else None
    if name == "world" and inertial is None:
        cause, mend = "is the world itself to the physics engine", "give it another name and a mass"
    elif number(element, "value") == 0.0:
        cause, mend = "has a mass of 0 and is not fixed", "give it a mass"
    else:
        return
    message = f"{cause}, so the object is immovable; write fixed: true in the task file, or {mend}"
    report.warning(codes.MASS, element or root, f"link {name}", message)


def _joints(robot: Element, report: Report) -> tuple[UrdfJoint, ...]:
    elements = list(robot.all("joint"))
    check_mimics(elements, report)
    joints = [read_joint(element, report) for element in elements]
    return tuple(joint for joint in joints if joint)


def _links(
    robot: Element, still: Collection[str | None], report: Report, files: Files
) -> tuple[UrdfLink, ...]:
    jointed = {child for joint, _, child in _ends(robot) if joint_moves(joint)}
    links = []
    for link in robot.all("link"):
        name = link.get("name")
        movable, moved = name not in still, name in jointed
        links.append(read_link(link, movable=movable, jointed=moved, report=report, files=files))
    return tuple(links)


def _unmoved(robot: Element) -> frozenset[str | None]:
    """Names of the links that no moving joint is above."""
    moved = {child for joint, _, child in _ends(robot) if joint_moves(joint)}
    pending = set(moved)
    while pending:
        pending = {child for _, parent, child in _ends(robot) if parent in pending} - moved
        moved |= pending
    return frozenset(link.get("name") for link in robot.all("link")) - moved


def _ends(robot: Element) -> Iterator[tuple[Element, str | None, str | None]]:
    """Each joint with the links above and below it."""
    for joint in robot.all("joint"):
        parent, child = (joint.first(end) for end in ("parent", "child"))
        yield joint, parent.get("link") if parent else None, child.get("link") if child else None
