"""Writing what was imported: whole or not at all, and the same bytes each time."""

from __future__ import annotations

import math
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from taskbuilder.assets.markup import Element, serialized
from taskbuilder.errors import UsageError, display_path
from taskbuilder.geometry import Pose
from taskbuilder.importing.description import (
    ImportedBody,
    ImportedJoint,
    ImportedShape,
    Inertial,
    Link,
)

MARK = "imported by taskbuilder"


def urdf_text(description: ImportedBody, comment: Sequence[str]) -> str:
    """The URDF of a description, with a comment at its beginning."""
    children = [*map(_link, description.links), *map(_joint, description.joints)]
    robot = _element("robot", {"name": description.name}, children)
    head, _, rest = serialized(robot).partition("\n")
    said = "\n".join(f"  {_without_dashes(line)}" for line in comment)
    return f"{head}\n<!--\n{said}\n-->\n{rest}"


def write_folder(folder: Path, files: Mapping[str, bytes], *, overwrite: bool) -> None:
    """Write files into a folder that is there whole or not at all.

    Args:
        folder: It must not exist, or be the folder of an earlier import.
        files: Content by relative path.
        overwrite: Whether to replace an earlier import.

    Raises:
        UsageError: There is something else.
        OSError: It cannot be written.
    """
    if folder.exists():
        require_replaceable(folder, overwrite=overwrite)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".importing-", dir=folder.parent) as aside:
        made = Path(aside) / folder.name
        for name, content in sorted(files.items()):
            path = made / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        if folder.exists():
            folder.rename(Path(aside) / "before")
        shutil.move(str(made), str(folder))


def require_replaceable(folder: Path, *, overwrite: bool) -> None:
    """Check that a folder may be written.

    Raises:
        UsageError: It holds something that no import wrote, or may not be overwritten.
    """
    if not folder.exists():
        return
    if not folder.is_dir():
        raise UsageError(f"{display_path(folder)} is a file; name another folder with --out")
    ours = any(MARK in _beginning(file) for file in folder.glob("*.urdf"))
    if not ours and any(folder.iterdir()):
        raise UsageError(
            f"{display_path(folder)} is there and was not written by an import; "
            "give another name with --name, or another folder with --out"
        )
    if ours and not overwrite:
        raise UsageError(
            f"{display_path(folder)} is there, by an earlier import; give this one another name "
            "with --name, or replace that one with --overwrite"
        )


def _beginning(file: Path) -> str:
    with file.open(encoding="utf-8", errors="replace") as opened:
        return opened.read(500)


def _link(link: Link) -> Element:
    children = [_inertial(link.inertial)] if link.inertial else []
    children += [_shape(shape, "visual") for shape in link.visuals]
    children += [_shape(shape, "collision") for shape in link.collisions]
    return _element("link", {"name": link.name}, children)


def _inertial(inertial: Inertial) -> Element:
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    moments = inertial.moments or (0.0,) * 6
    return _element(
        "inertial",
        {},
        [
            *_origin(inertial.pose),
            _element("mass", {"value": _number(inertial.mass)}),
            _element("inertia", dict(zip(names, map(_number, moments), strict=True))),
        ],
    )


def _shape(shape: ImportedShape, role: str) -> Element:
    solid = {
        "box": lambda: {"size": _spaced(shape.size)},
        "sphere": lambda: {"radius": _number(shape.size[0])},
        "cylinder": lambda: dict(zip(("radius", "length"), map(_number, shape.size), strict=True)),
        "capsule": lambda: dict(zip(("radius", "length"), map(_number, shape.size), strict=True)),
        "mesh": lambda: {"filename": shape.file},
    }[shape.kind]()
    children = [*_origin(shape.pose), _element("geometry", {}, [_element(shape.kind, solid)])]
    if role == "visual" and shape.color is not None:
        color = _element("color", {"rgba": _spaced(shape.color)})
        name = "color_" + "_".join(f"{round(part * 255):02x}" for part in shape.color)
        children.append(_element("material", {"name": name}, [color]))
    return _element(role, {}, children)


def _joint(joint: ImportedJoint) -> Element:
    children = [
        *_origin(joint.pose),
        _element("parent", {"link": joint.parent}),
        _element("child", {"link": joint.child}),
    ]
    if joint.moves:
        children.append(_element("axis", {"xyz": _spaced(joint.axis)}))
        ends = {} if joint.type == "continuous" else {"lower": joint.lower, "upper": joint.upper}
        limits = {**ends, "effort": joint.effort, "velocity": joint.velocity}
        given = {name: _number(value) for name, value in limits.items() if value is not None}
        children.append(_element("limit", given))
        if joint.damping or joint.friction:
            resistance = {"damping": joint.damping, "friction": joint.friction}
            children.append(
                _element("dynamics", {name: _number(value) for name, value in resistance.items()})
            )
        if joint.mimic:
            follows = {"multiplier": joint.mimic.multiplier, "offset": joint.mimic.offset}
            numbers = {name: _number(value) for name, value in follows.items()}
            children.append(_element("mimic", {"joint": joint.mimic.joint, **numbers}))
    return _element("joint", {"name": joint.name, "type": joint.type}, children)


def _origin(pose: Pose) -> Iterator[Element]:
    rpy = rpy_of(pose)
    if any(abs(value) > 1e-12 for value in (*pose.position, *rpy)):
        yield _element("origin", {"xyz": _spaced(pose.position), "rpy": _spaced(rpy)})


def rpy_of(pose: Pose) -> tuple[float, float, float]:
    """Roll, pitch and yaw about the fixed axes, in radians."""
    (a, b, c), (d, e, f), (_, _, i) = (pose.axis(0), pose.axis(1), pose.axis(2))
    pitch = math.asin(min(1.0, max(-1.0, -c)))
    if abs(c) > 1.0 - 1e-12:  # roll and yaw turn about the same axis
        return 0.0, pitch, math.atan2(-d, e)
    return math.atan2(f, i), pitch, math.atan2(b, a)


def _element(tag: str, attributes: Mapping[str, str], children: Sequence[Element] = ()) -> Element:
    return Element(tag, dict(attributes), 0, 0, tuple(children))


def _spaced(values: Sequence[float]) -> str:
    return " ".join(map(_number, values))


def _number(value: float) -> str:
    rounded = float(f"{value:.10g}")
    return f"{0.0 if abs(rounded) < 1e-13 else rounded:.10g}"


def _without_dashes(line: str) -> str:
    printable = "".join(c if c.isprintable() else "?" for c in line)
    return re.sub("-(?=-)", "- ", printable).rstrip("-")
