"""Reading a URDF as makers write it: what can be mended without a guess is mended and noted."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from taskbuilder.assets import codes
from taskbuilder.assets.joints import check_mimics, read_joint
from taskbuilder.assets.links import as_vec3, read_pose
from taskbuilder.assets.markup import Element, parse
from taskbuilder.assets.report import Report
from taskbuilder.assets.schema import cleaned, number, numbers
from taskbuilder.assets.tree import check_names, check_tree
from taskbuilder.errors import Location
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import (
    ImportedBody,
    ImportedJoint,
    ImportedShape,
    Inertial,
    Link,
    Rgba,
    Role,
)
from taskbuilder.wording import quoted

_ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_FREE = ("floating", "planar")
_SIZES = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
}

_Look = tuple[Rgba | None, str]  # a colour, and a reference to a texture or ""


def read_urdf_text(
    path: Path, data: bytes, changes: Changes, *, folder: Path | None = None
) -> ImportedBody:
    """Read the text of a URDF.

    Args:
        path: The file that findings name.
        data: The text.
        changes: Where changes are noted.
        folder: The folder to which its references are relative; by default that of the file.

    Raises:
        FileError: Something is wrong that cannot be mended without a guess.
    """
    root = parse(path, data, lines=False)
    report = Report(path)
    if root.tag != "robot":
        message = f"the root element is <{root.tag}>; a URDF begins with <robot name=…>"
        report.error(codes.STRUCTURE, root, "", message)
        report.warnings()
    root = _mended(root, path, changes, report)
    robot = cleaned(root, report)
    named = check_names(robot.all("link"), report)
    check_names(robot.all("joint"), report)
    elements = list(robot.all("joint"))
    check_tree(robot, named, elements, report)
    check_mimics(elements, report)
    joints = [joint for element in elements for joint in _joint(element, path, report)]
    looks = dict(_looks(robot))
    links = [_link(element, path, looks, report) for element in robot.all("link")]
    for finding in report.warnings():
        if finding.code == codes.IGNORED:
            changes.leave_out(f"{finding.path}: {finding.message.partition(';')[0]}".lstrip(": "))
    return ImportedBody(
        path, folder or path.resolve().parent, root.attributes["name"], tuple(links), tuple(joints)
    )


def _mended(robot: Element, path: Path, changes: Changes, report: Report) -> Element:
    """The tree with missing names given, and joints that go nowhere turned into fixed ones."""
    if not (robot.get("name") or "").strip():
        changes.note("robot", "name", "none", path.stem, "a robot needs a name")
        robot = robot.with_attributes(name=path.stem)
    taken = {child.get("name") for child in robot.children}
    children: list[Element] = []
    for child in robot.children:
        name = child.get("name") or ""
        if child.tag == "joint" and not name.strip():
            ends = [child.first(end) for end in ("parent", "child")]
            below = (ends[1].get("link") if ends[1] else None) or "joint"
            name = next(_unused(f"{below}_joint", taken))
            taken.add(name)
            changes.note(f"joint {name}", "name", "none", name, "every joint needs a name")
            child = child.with_attributes(name=name)
        if child.tag == "joint":
            child = _mended_joint(child, name, changes)
        children.append(child)
    free = [one for one in children if one.tag == "joint" and one.get("type") in _FREE]
    return robot.with_children(tuple(_without_free(children, free, changes, report)))


def _mended_joint(joint: Element, name: str, changes: Changes) -> Element:
    mimic = joint.first("mimic")
    if mimic and (mimic.get("multiplier") or "1").strip().strip("0.") == "":
        changes.note(
            f"joint {name}", "type", "mimic × 0", "fixed", "with a multiplier of 0 it never moves"
        )
        others = tuple(one for one in joint.children if one.tag not in ("mimic", "limit"))
        return joint.with_children(others).with_attributes(type="fixed")
    if joint.get("type") == "fixed":
        # What a fixed joint says of its motion means nothing, and is often wrong.
        kept = ("parent", "child", "origin")
        return joint.with_children(tuple(one for one in joint.children if one.tag in kept))
    return joint


def _without_free(
    children: list[Element], free: list[Element], changes: Changes, report: Report
) -> Iterator[Element]:
    """All but a floating joint between a world and the robot; other free joints are reported."""
    dropped: set[str] = set()
    for joint in free:
        parent = joint.first("parent")
        above = (parent.get("link") if parent else None) or ""
        ends = [one for one in children if one.tag == "joint" and _end(one, "child") == above]
        others = [one for one in children if one.tag == "joint" and _end(one, "parent") == above]
        frame = next((o for o in children if o.tag == "link" and o.get("name") == above), None)
        name = joint.get("name") or ""
        if not ends and others == [joint] and frame is not None and not frame.children:
            dropped |= {name, above}
            changes.note(
                f"joint {name}", "left out", str(joint.get("type")), "the base is fixed or free",
                f"{quoted(above)} is the world; a task says how the base stands in it",
            )  # fmt: skip
        else:
            message = (
                f"a {joint.get('type')} joint has several degrees of freedom; import the parts "
                "on its two sides as two files, or make it revolute, prismatic or fixed"
            )
            report.error(codes.NOT_IMPORTED, joint, f"joint {name}", message)
    yield from (
        one
        for one in children
        if one.get("name") not in dropped and not (one in free and one.get("name") not in dropped)
    )


def _end(joint: Element, tag: str) -> str:
    end = joint.first(tag)
    return (end.get("link") if end else None) or ""


def _unused(name: str, taken: set[str | None]) -> Iterator[str]:
    yield from (one for one in (name, *(f"{name}_{n}" for n in range(2, 999))) if one not in taken)


def _joint(element: Element, path: Path, report: Report) -> Iterator[ImportedJoint]:
    read = read_joint(element, report)
    if read is None:
        return
    dynamics = element.first("dynamics")
    yield ImportedJoint(
        read.name,
        read.type,
        read.parent,
        read.child,
        read.origin,
        read.axis,
        Location(path, element.line, element.column),
        read.lower,
        read.upper,
        read.effort,
        read.velocity,
        number(dynamics, "damping") or 0.0,
        number(dynamics, "friction") or 0.0,
        read.mimic,
    )


def _link(element: Element, path: Path, looks: dict[str, _Look], report: Report) -> Link:
    name = element.get("name") or ""
    inertial = element.first("inertial")
    found = None
    if inertial is not None:
        mass = number(inertial.first("mass"), "value")
        moments = inertial.first("inertia")
        entries = [number(moments, one) for one in _ENTRIES]
        given = None if any(entries[n] is None for n in (0, 3, 5)) else entries
        values = tuple(value or 0.0 for value in given) if given else None
        found = Inertial(mass, read_pose(inertial), values) if mass is not None else None
    shapes: dict[Role, tuple[ImportedShape, ...]] = {
        role: tuple(
            shape
            for one in element.all(role)
            for shape in _shape(one, f"link {name}", path, looks, report)
        )
        for role in ("visual", "collision")
    }
    place = Location(path, element.line, element.column)
    return Link(name, found, shapes["visual"], shapes["collision"], place)


def _shape(
    element: Element, subject: str, path: Path, looks: dict[str, _Look], report: Report
) -> Iterator[ImportedShape]:
    geometry = element.first("geometry")
    solids = geometry.children if geometry else ()
    if len(solids) != 1:
        message = f"<{element.tag}> needs one <geometry> with exactly one shape"
        report.error(codes.GEOMETRY, geometry or element, subject, message)
        return
    solid = solids[0]
    place = Location(path, solid.line, solid.column)
    color, texture = _look(element, looks)
    if solid.tag == "mesh":
        scale = as_vec3(numbers(solid, "scale") or (1.0, 1.0, 1.0))
        reference = solid.get("filename") or ""
        yield ImportedShape("mesh", scale, read_pose(element), place, reference, color, texture)
        return
    for kind, attributes in _SIZES.items():
        if kind == solid.tag:
            values = [numbers(solid, one) for one in attributes]
            size = tuple(value for each in values for value in each or ())
            if None in values or any(value <= 0.0 for value in size):
                message = f"<{kind}> needs {', '.join(attributes)} above 0, in metres"
                report.error(codes.GEOMETRY, solid, subject, message)
                return
            # The tag is a kind of shape, because `_SIZES` has it.
            yield ImportedShape(solid.tag, size, read_pose(element), place, "", color, texture)  # type: ignore[arg-type]


def _look(element: Element, looks: dict[str, _Look]) -> _Look:
    """The colour and the texture of a visual."""
    material = element.first("material")
    if material is None:
        return None, ""
    color, texture = _own_look(material)
    known = looks.get(material.get("name") or "", (None, ""))
    return color or known[0], texture or known[1]


def _looks(element: Element) -> Iterator[tuple[str, _Look]]:
    """The colours and textures of named materials anywhere in a robot."""
    for child in element.children:
        if child.tag == "material":
            name, look = child.get("name"), _own_look(child)
            if name and any(look):
                yield name, look
        elif child.tag in ("link", "visual"):
            yield from _looks(child)


def _own_look(material: Element) -> _Look:
    texture = material.first("texture")
    return _rgba(material), (texture.get("filename") if texture else None) or ""


def _rgba(material: Element) -> Rgba | None:
    values = numbers(material.first("color"), "rgba")
    if values is None:
        return None
    red, green, blue, opacity = (min(1.0, max(0.0, value)) for value in values)
    return (red, green, blue, opacity)
