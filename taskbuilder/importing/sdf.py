"""Reading SDF, as far as it says what a URDF can say."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from taskbuilder.assets import codes
from taskbuilder.assets.markup import Element
from taskbuilder.assets.model import JointType, UrdfMimic
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.geometry import Pose, Vec3, conjugate, from_rpy, norm, rotate, unit
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import (
    ImportedBody,
    ImportedJoint,
    ImportedShape,
    Inertial,
    Link,
    Rgba,
)
from taskbuilder.wording import quoted

_TYPES: dict[str, JointType] = {
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "fixed": "fixed",
}
_UNLIMITED = 1e5
_READ = frozenset({"link", "joint", "pose", "static", "frame"})


def read_sdf(file: Path, root: Element, changes: Changes) -> ImportedBody:
    """Read the first model of an SDF file.

    Raises:
        FileError: It has none, or something in it has no counterpart.
    """
    models = list(_models(root))
    if not models:
        raise _refused(file, root, "", "has no <model>; a world without models holds nothing")
    for other in models[1:]:
        changes.leave_out(f"model {other.get('name')}, the first is read")
    return _SdfReader(file, models[0], changes).read()


def _models(element: Element) -> Iterator[Element]:
    for child in element.children:
        if child.tag == "model":
            yield child
        elif child.tag == "world":
            yield from _models(child)


class _SdfReader:
    """Reads one model."""

    def __init__(self, file: Path, model: Element, changes: Changes) -> None:
        self._file, self._model, self._changes = file, model, changes
        self._findings: list[Finding] = []
        self._links = {link.get("name") or "": link for link in model.all("link")}
        self._joints = {joint.get("name") or "": joint for joint in model.all("joint")}
        self._frames_of: dict[str, Pose] = {}
        self._frames = {frame.get("name") or "": frame for frame in model.all("frame")}

    def read(self) -> ImportedBody:
        for part in self._model.children:
            if part.tag not in _READ:
                self._changes.leave_out(f"<{part.tag}> of the model")
        if not self._links:
            raise _refused(self._file, self._model, "", "the model has no links")
        # A link of a URDF has the frame of the joint above it; here it has one of its own.
        for name, link in self._links.items():
            self._frames_of[name] = self._placed(link)
        for each in self._joints.values():
            below = _text(each, "child").rpartition("::")[2]
            if below in self._links and (_text(each, "parent") in self._links):
                self._frames_of[below] = self._placed(each)
        joints = [one for element in self._joints.values() for one in self._joint(element)]
        children: dict[str, ImportedJoint] = {}
        for joint in joints:
            if joint.child in children:
                self._refuse(
                    self._joints[joint.name], f"joint {joint.name}",
                    f"closes a loop: {quoted(joint.child)} hangs on "
                    f"{quoted(children[joint.child].parent)} already; the physics engine takes "
                    "trees, so leave one of the joints out",
                )  # fmt: skip
            children[joint.child] = joint
        roots = [name for name in self._links if name not in children]
        if len(roots) != 1:
            what = f"{', '.join(roots)} have no parent" if roots else "every link has a parent"
            self._refuse(self._model, "", f"the links are no tree: {what}; connect them by joints")
        if self._findings:
            raise FileError(self._findings)
        links = tuple(self._link(name, element) for name, element in self._links.items())
        return ImportedBody(
            self._file, self._file.parent, self._model.get("name") or self._file.stem,
            links, tuple(joints),
        )  # fmt: skip

    def _placed(self, element: Element, depth: int = 0) -> Pose:
        """The pose of a link, joint or frame in the model."""
        pose = element.first("pose")
        own = _pose(pose)
        relative = (pose.get("relative_to") or pose.get("frame") if pose else None) or ""
        if element.tag == "joint" and not relative:
            relative = _text(element, "child")
        if element.tag == "frame" and not relative:
            relative = element.get("attached_to") or ""
        other = (
            self._links.get(relative) or self._joints.get(relative) or self._frames.get(relative)
        )
        if other is None or depth > 32 or other is element:
            return own
        return self._placed(other, depth + 1) @ own

    def _joint(self, element: Element) -> Iterator[ImportedJoint]:
        name, subject = element.get("name") or "", f"joint {element.get('name')}"
        parent, child = _text(element, "parent"), _text(element, "child")
        parent, child = parent.rpartition("::")[2], child.rpartition("::")[2]
        kind = element.get("type") or ""
        if parent == "world" and parent not in self._links:
            self._changes.leave_out(f"{subject}, which fixes the model to the world")
            return
        for end in (parent, child):
            if end not in self._links:
                self._refuse(element, subject, f"names the link {quoted(end)}, which is not there")
                return
        if kind not in _TYPES:
            self._refuse(
                element, subject,
                f"is {quoted(kind)}; revolute, prismatic, continuous and fixed joints are read",
            )  # fmt: skip
            return
        place = self._placed(element)
        pose = self._frames_of[parent].inverse() @ place
        axis_element = element.first("axis")
        axis: Vec3 = (0.0, 0.0, 1.0)
        lower = upper = effort = velocity = None
        damping = friction = 0.0
        mimic = None
        type_ = _TYPES[kind]
        if axis_element is not None and type_ != "fixed":
            xyz = axis_element.first("xyz")
            written = _numbers(xyz.text if xyz else "") or [0.0, 0.0, 1.0]
            axis = (written[0], written[1], written[2])
            in_model = _text(axis_element, "use_parent_model_frame") in ("1", "true") or (
                xyz is not None and xyz.get("expressed_in") == "__model__"
            )
            if in_model:
                axis = rotate(conjugate(place.quaternion), axis)
            if norm(axis) < 1e-6:
                self._refuse(axis_element, subject, "the axis has no length; write such as 0 0 1")
                axis = (0.0, 0.0, 1.0)
            axis = unit(axis)
            limit, dynamics = axis_element.first("limit"), axis_element.first("dynamics")
            lower, upper = _number(limit, "lower"), _number(limit, "upper")
            effort, velocity = _positive(limit, "effort"), _positive(limit, "velocity")
            damping, friction = (
                _number(dynamics, "damping") or 0.0,
                _number(dynamics, "friction") or 0.0,
            )
            follow = axis_element.first("mimic")
            if follow is not None and follow.get("joint"):
                mimic = UrdfMimic(
                    follow.get("joint") or "",
                    _number(follow, "multiplier") or 1.0,
                    _number(follow, "offset") or 0.0,
                )
        if type_ in ("revolute", "prismatic"):
            unlimited = any(v is None or abs(v) >= _UNLIMITED for v in (lower, upper))
            if unlimited and type_ == "revolute":
                type_, lower, upper = "continuous", None, None
            elif unlimited:
                self._refuse(element, subject, "slides without limits; write <lower> and <upper>")
        yield ImportedJoint(
            name, type_, parent, child, pose, axis, self._at(element),
            lower, upper, effort, velocity, damping, friction, mimic,
        )  # fmt: skip

    def _link(self, name: str, element: Element) -> Link:
        shift = self._frames_of[name].inverse() @ self._placed(element)
        inertial = None
        stated = element.first("inertial")
        mass = _number(stated, "mass")
        if stated is not None and mass is not None:
            entries = [_number(stated.first("inertia"), one) for one in _ENTRIES]
            given = None if entries[0] is None else tuple(value or 0.0 for value in entries)
            inertial = Inertial(mass, shift @ _pose(stated.first("pose")), given)
        for child in element.children:
            if child.tag not in ("inertial", "visual", "collision", "pose"):
                self._changes.leave_out(f"<{child.tag}> of link {name}")
        visuals = tuple(s for one in element.all("visual") for s in self._shape(one, name, shift))
        collisions = tuple(
            s for one in element.all("collision") for s in self._shape(one, name, shift)
        )
        return Link(name, inertial, visuals, collisions, self._at(element))

    def _shape(self, element: Element, link: str, shift: Pose) -> Iterator[ImportedShape]:
        geometry = element.first("geometry")
        solids = geometry.children if geometry else ()
        pose, place = shift @ _pose(element.first("pose")), self._at(element)
        color = _diffuse(element.first("material"))
        for solid in solids[:1]:
            if solid.tag == "box":
                yield ImportedShape(
                    "box", tuple(_numbers(_text(solid, "size"))), pose, place, color=color
                )
            elif solid.tag == "sphere":
                radius = _number(solid, "radius") or 0.0
                yield ImportedShape("sphere", (radius,), pose, place, color=color)
            elif solid.tag in ("cylinder", "capsule"):
                size = (_number(solid, "radius") or 0.0, _number(solid, "length") or 0.0)
                kind = "cylinder" if solid.tag == "cylinder" else "capsule"
                # mypy infers `str` for what is one of two kinds.
                yield ImportedShape(kind, size, pose, place, color=color)  # type: ignore[arg-type]
            elif solid.tag == "mesh":
                scale = _numbers(_text(solid, "scale")) or [1.0, 1.0, 1.0]
                reference = _text(solid, "uri") or _text(solid, "filename")
                size3 = (scale[0], scale[1], scale[2])
                yield ImportedShape("mesh", size3, pose, place, reference, color)
            else:
                self._changes.leave_out(f"<{solid.tag}> of link {link}")

    def _at(self, element: Element) -> Location:
        return Location(self._file, element.line, element.column)

    def _refuse(self, element: Element, subject: str, message: str) -> None:
        self._findings += _refused(self._file, element, subject, message).findings


_ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def _refused(file: Path, element: Element, subject: str, message: str) -> FileError:
    place = Location(file, element.line, element.column)
    return FileError([Finding(codes.NOT_IMPORTED, message, subject, place)])


def _pose(element: Element | None) -> Pose:
    values = _numbers(element.text) if element else []
    if len(values) != 6:
        return Pose()
    return Pose((values[0], values[1], values[2]), from_rpy(*values[3:]))


def _diffuse(material: Element | None) -> Rgba | None:
    values = _numbers(_text(material, "diffuse")) if material else []
    if len(values) < 3:
        return None
    red, green, blue, *rest = (min(1.0, max(0.0, value)) for value in values)
    return (red, green, blue, rest[0] if rest and rest[0] > 0.0 else 1.0)


def _text(element: Element | None, tag: str) -> str:
    child = element.first(tag) if element else None
    return child.text if child else ""


def _numbers(text: str) -> list[float]:
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        return []


def _number(element: Element | None, tag: str) -> float | None:
    values = _numbers(_text(element, tag))
    return values[0] if len(values) == 1 else None


def _positive(element: Element | None, tag: str) -> float | None:
    value = _number(element, tag)
    return value if value is not None and 0.0 < value < 1e6 else None
