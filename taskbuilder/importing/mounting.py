"""Descriptions mounted on one another: a gripper on the flange of an arm, or on an adapter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import quote

from taskbuilder.assets import codes
from taskbuilder.assets.model import UrdfMimic
from taskbuilder.assets.paths import AssetError
from taskbuilder.errors import FileError, Finding, Location, UsageError
from taskbuilder.geometry import Pose
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import ImportedBody, ImportedJoint, ImportedShape, Link
from taskbuilder.importing.packages import Packages
from taskbuilder.wording import quoted, suggestion
from taskbuilder.world.suction_proposal import names_cup


def parse_flange(text: str) -> tuple[str, Pose]:
    """The link and the pose of ``FLANGE[@x,y,z[,roll,pitch,yaw]]``, in metres and degrees.

    Raises:
        UsageError: It has another form.
    """
    link, _, written = text.partition("@")
    try:
        numbers = [float(word) for word in written.split(",")] if written else []
    except ValueError:
        numbers = [math.nan]
    if not link or len(numbers) not in (0, 3, 6) or not all(map(math.isfinite, numbers)):
        raise UsageError(
            f"--at {text}: write the link, or LINK@x,y,z or LINK@x,y,z,roll,pitch,yaw, in metres "
            "and degrees"
        )
    x, y, z, roll, pitch, yaw = (numbers + [0.0] * 6)[:6]
    return link, Pose.from_rpy_deg((x, y, z), (roll, pitch, yaw))


@dataclass(frozen=True)
class Mount:
    """Something to mount on a robot.

    Attributes:
        file: Its description.
        flange: Where, as ``LINK[@pose]``: a link of the arm, or of what was mounted before it.
    """

    file: Path
    flange: str


def is_cup(part: ImportedBody) -> bool:
    """Whether a part without joints is a suction cup, by the names of it and of its links."""
    texts = [part.name, part.file.stem, *(link.name for link in part.links)]
    return names_cup(texts) and not any(joint.moves for joint in part.joints)


def mounted(
    arm: ImportedBody,
    parts: Sequence[tuple[ImportedBody, str]],
    changes: Changes,
    *,
    suction: bool = False,
) -> ImportedBody:
    """An arm with a gripper on one of its links, or with adapters and a gripper on one another.

    Args:
        arm: The arm.
        parts: The parts with absolute references, and where the root of each is put.
        changes: Where changes are noted.
        suction: Whether the last part is a suction cup, of which nothing has to move.

    Raises:
        FileError: There is no such link, or nothing moves that could be a gripper.
        UsageError: A place has another form.
    """
    if parts and not suction and not any(joint.moves for part, _ in parts for joint in part.joints):
        last = parts[-1][0]
        message = (
            "has no joint that moves, so it is no gripper; mount another file, or mount the "
            "gripper on it with another --gripper and --at. If it is a suction cup, say what it "
            "holds with --suction NEWTONS"
        )
        raise FileError([Finding(codes.STRUCTURE, message, "", Location(last.file))])
    called: dict[str, str] = {}
    for part, place in parts:
        flange, pose = parse_flange(place)
        arm, called = _with_part(arm, part, called.get(flange, flange), pose, changes)
    return arm


def _with_part(
    arm: ImportedBody, part: ImportedBody, flange: str, pose: Pose, changes: Changes
) -> tuple[ImportedBody, dict[str, str]]:
    """The arm with a part on it, and how the links of the part are called there."""
    links = [link.name for link in arm.links]
    if flange not in links:
        leaves = [name for name in links if all(joint.parent != name for joint in arm.joints)]
        right = suggestion(flange, links, otherwise=f"its outermost links are {', '.join(leaves)}")
        message = f"has no link {quoted(flange)} to mount {part.file.name} on; {right}"
        raise FileError([Finding(codes.STRUCTURE, message, "", Location(arm.file))])
    taken = {*links, *(joint.name for joint in arm.joints)}
    mine = [link.name for link in part.links] + [joint.name for joint in part.joints]
    what = "gripper" if any(joint.moves for joint in part.joints) else "adapter"
    prefix = "" if not taken & set(mine) else f"{what}_"
    while prefix and any(f"{prefix}{name}" in taken for name in mine):
        prefix = f"{prefix}_"
    if prefix:
        changes.note(what, "names", "some are taken", f"{prefix}…", "every name may be there once")
    renamed = [replace(link, name=f"{prefix}{link.name}") for link in part.links]
    joints = [_renamed_joint(joint, prefix) for joint in part.joints]
    root = f"{prefix}{part.root}"
    name = f"{root}_mount"
    mount = ImportedJoint(name, "fixed", flange, root, pose, (1.0, 0.0, 0.0), Location(part.file))
    changes.note(
        what, "mounted", part.file.name, f"{root} on {flange}",
        "at " + " ".join(f"{value:g}" for value in pose.position) + " m",
    )  # fmt: skip
    postures: dict[str, dict[str, float]] = {name: dict(p) for name, p in arm.postures.items()}
    whole = replace(
        arm,
        links=(*arm.links, *renamed),
        joints=(*arm.joints, mount, *joints),
        postures=postures,
    )
    return whole, {link.name: f"{prefix}{link.name}" for link in part.links}


def with_located_meshes(description: ImportedBody, packages: Packages) -> ImportedBody:
    """The description with absolute references, so that another folder and package may hold it.

    Raises:
        FileError: Meshes are not there.
    """
    findings: list[Finding] = []

    def located(shape: ImportedShape, link: Link) -> ImportedShape:
        if not shape.mesh:
            return shape
        try:
            return replace(
                shape, mesh=f"file://{quote(str(packages.locate(shape.mesh, description.folder)))}"
            )
        except AssetError as error:
            findings.append(error.finding(f"link {link.name}", shape.place))
            return shape

    links = tuple(
        replace(
            link,
            visuals=tuple(located(shape, link) for shape in link.visuals),
            collisions=tuple(located(shape, link) for shape in link.collisions),
        )
        for link in description.links
    )
    if findings:
        raise FileError(findings)
    return replace(description, links=links)


def _renamed_joint(joint: ImportedJoint, prefix: str) -> ImportedJoint:
    mimic = joint.mimic
    if mimic is not None:
        mimic = UrdfMimic(f"{prefix}{mimic.joint}", mimic.multiplier, mimic.offset)
    return replace(
        joint,
        name=f"{prefix}{joint.name}",
        parent=f"{prefix}{joint.parent}",
        child=f"{prefix}{joint.child}",
        mimic=mimic,
    )
