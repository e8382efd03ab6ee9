"""Reading MJCF, the format of MuJoCo, as far as it says what a URDF can say."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from taskbuilder.assets import codes
from taskbuilder.assets.markup import Element
from taskbuilder.assets.model import JointType, ShapeKind, UrdfMimic
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.geometry import (
    NO_TURN,
    Pose,
    Quat,
    Vec3,
    add,
    from_axes,
    from_rpy,
    multiply,
    norm,
    normalized,
    scale,
    subtract,
    turn_onto,
    unit,
)
from taskbuilder.importing import mjcf_elements as elements
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import (
    ImportedBody,
    ImportedJoint,
    ImportedShape,
    Inertial,
    Link,
    Rgba,
)
from taskbuilder.importing.packages import Packages
from taskbuilder.wording import quoted

_READ = frozenset(
    ("compiler", "default", "asset", "worldbody", "include", "keyframe", "equality", "option")
)
_LIGHT = Inertial(1e-3, Pose(), (1e-7, 0.0, 0.0, 1e-7, 0.0, 1e-7))


def read_mjcf(packages: Packages, root: Element, changes: Changes) -> ImportedBody:
    """Read the first tree of bodies of an MJCF file.

    Raises:
        FileError: It has none, or something in it has no counterpart.
    """
    root = elements.with_includes(packages, packages.file, root, [0])
    for child in root.children:
        if child.tag not in _READ:
            changes.leave_out(f"<{child.tag}>")
    return _MjcfReader(packages, root, changes).read()


class _MjcfReader:
    """Reads one model."""

    def __init__(self, packages: Packages, root: Element, changes: Changes) -> None:
        self._file, self._root, self._changes = packages.file, root, changes
        self._findings: list[Finding] = []
        self._compiler = elements.compiler_of(root)
        self._defaults = dict(elements.defaults_of(root))
        assets = [one for each in root.all("asset") for one in each.children]
        self._meshes = {
            one.get("name") or Path(one.get("file") or "").stem: self._with_default(one, "main")
            for one in assets
            if one.tag == "mesh"
        }
        self._materials = {one.get("name"): one for one in assets if one.tag == "material"}
        self._links: list[Link] = []
        self._joints: list[ImportedJoint] = []
        self._places: list[tuple[str, str]] = []  # names of joints in the order of qpos
        self._names: set[str] = set()

    def read(self) -> ImportedBody:
        tops = [body for world in self._root.all("worldbody") for body in world.all("body")]
        if not tops:
            place = Location(self._file, self._root.line)
            raise FileError([Finding(codes.NOT_IMPORTED, "has no <body>", "", place)])
        tops.sort(key=lambda body: -sum(1 for _ in elements.all_below(body, "joint")))
        for other in tops[1:]:
            self._changes.leave_out(f"body {other.get('name')}, the one with most joints is read")
        self._body(tops[0], None, "main")
        self._couple()
        if self._findings:
            raise FileError(self._findings)
        return ImportedBody(
            self._file,
            self._file.parent,
            self._root.get("model") or self._file.stem,
            tuple(self._links),
            tuple(self._joints),
            dict(self._keyframes()),
        )

    def _body(self, body: Element, parent: str | None, inherited: str) -> None:
        name = self._unused(body.get("name") or "body")
        inherited = body.get("childclass") or inherited
        pose = self._pose(body)
        joints = [self._with_default(one, inherited) for one in body.all("joint")]
        free = [one for one in joints if one.get("type") in ("free", "ball")] + list(
            body.all("freejoint")
        )
        if free and parent is None:
            self._changes.leave_out(
                f"the {free[0].get('type') or 'free'} joint of {name}: a task says how its base "
                "stands"
            )
            joints = [one for one in joints if one not in free]
        elif free:
            self._refuse(
                free[0], f"joint {free[0].get('name')}",
                f"is {quoted(free[0].get('type') or 'free')}; only hinges and slides are read "
                "inside a robot",
            )  # fmt: skip
            return
        if parent is None:
            pose = Pose()
            if joints:  # what moves needs something to move against
                self._links.append(Link("base", None, (), (), self._at(body)))
                parent = "base"
        shift = Pose()
        for index, joint in enumerate(joints):
            last = index == len(joints) - 1
            at = elements.numbers(joint.get("pos")) or [0.0, 0.0, 0.0]
            anchor: Vec3 = (at[0], at[1], at[2])
            child = name if last else self._unused(f"{name}_{index + 1}")
            # A link of a URDF has its frame in the joint above it.
            self._joint(joint, str(parent), child, pose @ Pose(anchor))
            if not last:
                self._links.append(Link(child, _LIGHT, (), (), self._at(joint)))
                self._changes.note(
                    f"link {child}", "mass", "several joints on one body", "1 g between them",
                    "a link of a URDF has one joint",
                )  # fmt: skip
            pose, shift, parent = Pose(scale(anchor, -1.0)), Pose(scale(anchor, -1.0)), child
        if not joints and parent is not None:
            place = self._at(body)
            fixed = ImportedJoint(self._unused(f"{name}_fixed"), "fixed", parent, name, pose,
                          (1.0, 0.0, 0.0), place)  # fmt: skip
            self._joints.append(fixed)
        self._links.append(self._link(body, name, inherited, shift))
        for child_body in body.all("body"):
            self._body_on(child_body, name, inherited, shift)

    def _body_on(self, body: Element, parent: str, inherited: str, shift: Pose) -> None:
        """A body on another one, whose frame lies in its joint."""
        moved = shift @ self._pose(body)
        attributes = {
            name: text
            for name, text in body.attributes.items()
            if name not in ("pos", "quat", "axisangle", "euler", "xyaxes", "zaxis")
        }
        x, y, z, w = moved.quaternion
        attributes["pos"] = " ".join(map(repr, moved.position))
        attributes["quat"] = " ".join(map(repr, (w, x, y, z)))
        self._body(replace(body, attributes=attributes), parent, inherited)

    def _joint(self, joint: Element, parent: str, child: str, pose: Pose) -> None:
        slides = joint.get("type") == "slide"
        name = self._unused(joint.get("name") or f"{child}_joint")
        axis = elements.numbers(joint.get("axis")) or [0.0, 0.0, 1.0]
        direction: Vec3 = (axis[0], axis[1], axis[2])
        if norm(direction) < 1e-6:
            self._refuse(joint, f"joint {name}", "the axis has no length; write such as 0 0 1")
            return
        ends = elements.numbers(joint.get("range"))
        limited = joint.get("limited") == "true" or (
            joint.get("limited") in (None, "auto") and bool(ends) and self._compiler.autolimits
        )
        kind: JointType = "prismatic" if slides else "revolute" if limited else "continuous"
        lower = upper = None
        if limited and len(ends) == 2:
            lower, upper = (self._angle(value, slides) for value in ends)
        if slides and lower is None:
            self._refuse(joint, f"joint {name}", 'slides without limits; write range="… …"')
            return
        force = elements.numbers(joint.get("actuatorfrcrange"))
        self._places.append((name, joint.get("name") or name))
        self._joints.append(
            ImportedJoint(
                name,
                kind,
                parent,
                child,
                pose,
                unit(direction),
                self._at(joint),
                lower,
                upper,
                abs(force[1]) if len(force) == 2 else None,
                None,
                elements.one_number(joint.get("damping")) or 0.0,
                elements.one_number(joint.get("frictionloss")) or 0.0,
            )
        )

    def _link(self, body: Element, name: str, inherited: str, shift: Pose) -> Link:
        stated = body.first("inertial")
        inertial = None
        if stated is not None:
            full, diagonal = (
                elements.numbers(stated.get("fullinertia")),
                elements.numbers(stated.get("diaginertia")),
            )
            moments = None
            if len(full) == 6:
                xx, yy, zz, xy, xz, yz = full
                moments = (xx, xy, xz, yy, yz, zz)
            elif len(diagonal) == 3:
                moments = (diagonal[0], 0.0, 0.0, diagonal[1], 0.0, diagonal[2])
            inertial = Inertial(
                elements.one_number(stated.get("mass")) or 0.0, shift @ self._pose(stated), moments
            )
        visuals: list[ImportedShape] = []
        collisions: list[ImportedShape] = []
        for geom in body.all("geom"):
            geom = self._with_default(geom, inherited)
            shape = self._geom(geom, name, shift)
            if shape is None:
                continue
            passive = geom.get("contype") == "0" and geom.get("conaffinity") == "0"
            group = geom.get("group") or "0"
            if passive or group in ("1", "2"):
                visuals.append(shape)
            if not passive:
                collisions.append(shape)
        for other in body.children:
            if other.tag not in ("joint", "freejoint", "inertial", "geom", "body", "site"):
                self._changes.leave_out(f"<{other.tag}> of body {name}")
        visuals = visuals or collisions
        return Link(name, inertial, tuple(visuals), tuple(collisions), self._at(body))

    def _geom(self, geom: Element, link: str, shift: Pose) -> ImportedShape | None:
        kind = geom.get("type") or ("mesh" if geom.get("mesh") else "sphere")
        size = elements.numbers(geom.get("size"))
        pose, place = shift @ self._pose(geom), self._at(geom)
        color = self._rgba(geom)
        if kind == "mesh":
            mesh = self._meshes.get(geom.get("mesh") or "")
            if mesh is None or not mesh.get("file"):
                self._refuse(
                    geom, f"link {link}", f"the mesh {quoted(geom.get('mesh') or '')} names no file"
                )
                return None
            given = elements.numbers(mesh.get("scale")) or [1.0, 1.0, 1.0]
            own = Pose(elements.vector(elements.numbers(mesh.get("refpos"))))
            reference = str(Path(self._compiler.meshdir) / (mesh.get("file") or ""))
            factors = (given[0], given[1], given[2])
            return ImportedShape("mesh", factors, pose @ own.inverse(), place, reference, color)
        ends = elements.numbers(geom.get("fromto"))
        if len(ends) == 6 and kind in ("capsule", "cylinder", "box"):
            a, b = elements.vector(ends[:3]), elements.vector(ends[3:])
            along = subtract(b, a)
            turn = turn_onto((0.0, 0.0, 1.0), along) if norm(along) > 1e-9 else NO_TURN
            pose = shift @ Pose(scale(add(a, b), 0.5), turn)
            size = [size[0], norm(along) / 2.0] if size else size
        shapes: dict[str, tuple[ShapeKind, tuple[float, ...]]] = {}
        if len(size) >= 3:
            shapes["box"] = ("box", (2 * size[0], 2 * size[1], 2 * size[2]))
            shapes["ellipsoid"] = ("sphere", (max(size[:3]),))
        if len(size) >= 2:
            shapes["cylinder"] = ("cylinder", (size[0], 2 * size[1]))
            shapes["capsule"] = ("capsule", (size[0], 2 * size[1]))
        if size:
            shapes["sphere"] = ("sphere", (size[0],))
        if kind not in shapes:
            self._changes.leave_out(f"a {kind} of body {link}")
            return None
        name, sizes = shapes[kind]
        if kind == "ellipsoid":
            self._changes.note(f"link {link}", "shape", "ellipsoid", "sphere", "a URDF has none")
        return ImportedShape(name, sizes, pose, place, color=color)

    def _couple(self) -> None:
        """Joints that an equality couples mimic each other."""
        names = {written: name for name, written in self._places}
        for equality in (one for each in self._root.all("equality") for one in each.children):
            one, other = (
                names.get(equality.get("joint1") or ""),
                names.get(equality.get("joint2") or ""),
            )
            if equality.tag != "joint" or one is None or other is None:
                self._changes.leave_out(
                    f"the equality <{equality.tag}> {equality.get('name') or ''}"
                )
                continue
            terms = [*elements.numbers(equality.get("polycoef")), 0.0, 0.0][:2] or [0.0, 1.0]
            if not equality.get("polycoef"):
                terms = [0.0, 1.0]
            if terms[1]:
                mimic = UrdfMimic(other, terms[1], terms[0])
                self._joints = [
                    replace(j, mimic=mimic) if j.name == one else j for j in self._joints
                ]

    def _keyframes(self) -> Iterator[tuple[str, Mapping[str, float]]]:
        """The joint positions of keyframes, where each joint has one number of qpos."""
        for key in (one for each in self._root.all("keyframe") for one in each.children):
            values = elements.numbers(key.get("qpos"))
            extra = len(values) - len(self._places)
            if extra in (0, 7):  # behind the pose of a base that is free
                positions = dict(zip((n for n, _ in self._places), values[extra:], strict=True))
                yield key.get("name") or "key", positions
            elif values:
                self._changes.leave_out(f"the keyframe {key.get('name')}, of more than the robot")

    def _with_default(self, element: Element, inherited: str) -> Element:
        """An element with the attributes of its class."""
        chosen = element.get("class") or inherited
        given = self._defaults.get((chosen, element.tag)) or self._defaults.get(
            ("main", element.tag), {}
        )
        return replace(element, attributes={**given, **element.attributes})

    def _pose(self, element: Element) -> Pose:
        position = elements.vector(elements.numbers(element.get("pos")))
        return Pose(position, self._turn(element))

    def _turn(self, element: Element) -> Quat:
        values = {name: elements.numbers(element.get(name)) for name in _TURNS}
        if len(values["quat"]) == 4:
            w, x, y, z = values["quat"]
            return normalized((x, y, z, w))
        if len(values["axisangle"]) == 4:
            x, y, z, turn = values["axisangle"]
            half = self._angle(turn, False) / 2.0
            ax, ay, az = scale(unit((x, y, z)), math.sin(half))
            return (ax, ay, az, math.cos(half))
        if len(values["euler"]) == 3:
            angles = [self._angle(value, False) for value in values["euler"]]
            turn_ = NO_TURN
            for letter, angle in zip(self._compiler.euler, angles, strict=True):
                rpy = [angle if letter.lower() == axis else 0.0 for axis in "xyz"]
                step = from_rpy(*rpy)
                turn_ = multiply(turn_, step) if letter.islower() else multiply(step, turn_)
            return turn_
        if len(values["xyaxes"]) == 6:
            x_axis = unit(elements.vector(values["xyaxes"][:3]))
            y_raw = elements.vector(values["xyaxes"][3:])
            along = sum(a * b for a, b in zip(x_axis, y_raw, strict=True))
            y_axis = unit(subtract(y_raw, scale(x_axis, along)))
            x, y, z = x_axis
            a, b, c = y_axis
            return from_axes(x_axis, y_axis, (y * c - z * b, z * a - x * c, x * b - y * a))
        if len(values["zaxis"]) == 3:
            return turn_onto((0.0, 0.0, 1.0), elements.vector(values["zaxis"]))
        return NO_TURN

    def _angle(self, value: float, slides: bool) -> float:
        return math.radians(value) if self._compiler.degrees and not slides else value

    def _rgba(self, geom: Element) -> Rgba | None:
        values = elements.numbers(geom.get("rgba"))
        material = self._materials.get(geom.get("material")) if geom.get("material") else None
        if not values and material is not None:
            values = elements.numbers(self._with_default(material, "main").get("rgba"))
            if material.get("texture"):
                self._changes.leave_out(f"the texture of material {material.get('name')}")
        if len(values) != 4:
            return None
        red, green, blue, opacity = (min(1.0, max(0.0, value)) for value in values)
        return (red, green, blue, opacity or 1.0)

    def _unused(self, name: str) -> str:
        found = name
        number = 2
        while found in self._names:
            found, number = f"{name}_{number}", number + 1
        self._names.add(found)
        return found

    def _at(self, element: Element) -> Location:
        return Location(self._file, element.line, element.column)

    def _refuse(self, element: Element, subject: str, message: str) -> None:
        self._findings.append(Finding(codes.NOT_IMPORTED, message, subject, self._at(element)))


_TURNS = ("quat", "axisangle", "euler", "xyaxes", "zaxis")
