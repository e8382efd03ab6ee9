"""One description mounted on another: a gripper on the flange of an arm."""

from __future__ import annotations

import math
from dataclasses import replace
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


def mounted(
    arm: ImportedBody, gripper: ImportedBody, flange: str, pose: Pose, changes: Changes
) -> ImportedBody:
    """An arm with a gripper on one of its links.

    Args:
        arm: The arm.
        gripper: The gripper, whose root is put on the flange; with absolute references.
        flange: A link of the arm.
        pose: The root of the gripper in the frame of the flange.
        changes: Where changes are noted.

    Raises:
        FileError: The arm has no such link, or the gripper nothing to be mounted by.
    """
    links = [link.name for link in arm.links]
    if flange not in links:
        leaves = [name for name in links if all(joint.parent != name for joint in arm.joints)]
        right = suggestion(flange, links, otherwise=f"its outermost links are {', '.join(leaves)}")
        message = f"has no link {quoted(flange)} to mount a gripper on; {right}"
        raise FileError([Finding(codes.STRUCTURE, message, "", Location(arm.file))])
    if not any(joint.moves for joint in gripper.joints):
        message = "has no joint that moves, so it is no gripper; mount another file"
        raise FileError([Finding(codes.STRUCTURE, message, "", Location(gripper.file))])
    taken = {*links, *(joint.name for joint in arm.joints)}
    mine = [link.name for link in gripper.links] + [joint.name for joint in gripper.joints]
    prefix = "" if not taken & set(mine) else "gripper_"
    while prefix and any(f"{prefix}{name}" in taken for name in mine):
        prefix = f"{prefix}_"
    if prefix:
        changes.note(
            "gripper", "names", "some are taken", f"{prefix}…", "every name may be there once"
        )
    renamed = [replace(link, name=f"{prefix}{link.name}") for link in gripper.links]
    joints = [_renamed_joint(joint, prefix) for joint in gripper.joints]
    root = f"{prefix}{gripper.root}"
    name = f"{root}_mount"
    place = Location(gripper.file)
    mount = ImportedJoint(name, "fixed", flange, root, pose, (1.0, 0.0, 0.0), place)
    changes.note(
        "gripper", "mounted", gripper.file.name, f"{root} on {flange}",
        "at " + " ".join(f"{value:g}" for value in pose.position) + " m",
    )  # fmt: skip
    postures: dict[str, dict[str, float]] = {name: dict(p) for name, p in arm.postures.items()}
    return replace(
        arm,
        links=(*arm.links, *renamed),
        joints=(*arm.joints, mount, *joints),
        postures=postures,
    )


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
