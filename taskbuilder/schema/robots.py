"""Load a robot: its robot.yaml and, checked against it, its URDF."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.assets.paths import AssetError, resolve
from taskbuilder.assets.urdf import read_urdf
from taskbuilder.errors import FileError, Finding
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.schema.explain import parse
from taskbuilder.schema.robot import GripperJoint, GripperSpec, RobotSpec
from taskbuilder.schema.source import Path_, Source, dotted, read_source
from taskbuilder.wording import suggestion


@dataclass(frozen=True)
class RobotModel:
    """A robot that can be put into scenes: its file, its URDF, and what follows from both."""

    entry: CatalogueEntry
    spec: RobotSpec
    urdf: Urdf

    @property
    def name(self) -> str:
        """Its id in the catalogue."""
        return self.spec.robot

    @cached_property
    def arm(self) -> tuple[UrdfJoint, ...]:
        """The arm's joints, base to wrist."""
        return tuple(self.urdf.joint(name) for name in self.spec.arm)

    @property
    def home(self) -> tuple[float, ...]:
        """Home position of the arm's joints, in rad or m."""
        return joint_values(self.arm, self.spec.home_deg)

    @property
    def takes_hold(self) -> bool:
        """Whether it can hold objects."""
        return self.spec.gripper is not None or self.spec.suction is not None

    @property
    def grip(self) -> str:
        """What it holds with, in a table: stroke or suction force; empty if it holds nothing."""
        if self.spec.suction is not None:
            return f"suction {self.spec.suction.force:g} N"
        return f"{self.stroke * 1000:.0f} mm" if self.takes_hold else ""

    @property
    def stroke(self) -> float:
        """Opening of its fingers when open, in metres; 0 without fingers."""
        return self.spec.gripper.stroke if self.spec.gripper else 0.0

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """What is doubtful about the robot without keeping it from being used."""
        return self.urdf.warnings


def joint_values(joints: Sequence[UrdfJoint], written: Sequence[float]) -> tuple[float, ...]:
    """Joint values as files write them (degrees, or m where a joint slides), in rad or m."""
    return tuple(
        value if joint.type == "prismatic" else math.radians(value)
        for joint, value in zip(joints, written, strict=True)
    )


def load_robot(entry: CatalogueEntry, roots: Sequence[Path] = ()) -> RobotModel:
    """Read and check a robot file and its URDF.

    Args:
        entry: The robot's entry in the catalogue.
        roots: Folders, besides its own, in which its assets may lie.

    Raises:
        FileError: With every finding of robot.yaml, or of the URDF where robot.yaml is right.
    """
    if entry.trusted:  # robots of one package may share meshes
        roots = (*roots, entry.root.parent)
    source = read_source(entry.file)
    spec, wrong = parse(RobotSpec, source)
    findings = [*source.findings, *wrong]
    urdf = None
    try:
        urdf = _read_urdf(source, entry, roots)
    except AssetError as error:
        findings.append(error.finding("urdf", source.locate(("urdf",))))
    except FileError as error:
        findings += error.findings
    if spec is not None and urdf is not None:
        findings += _check(source, spec, urdf, entry)
    if spec is None or urdf is None or any(f.severity == "error" for f in findings):
        raise FileError(findings)
    return RobotModel(entry, spec, urdf)


def _read_urdf(source: Source, entry: CatalogueEntry, roots: Sequence[Path]) -> Urdf | None:
    reference = source.get("urdf")
    if not isinstance(reference, str) or not reference:
        return None
    allowed = (entry.root, *roots)
    return read_urdf(
        resolve(reference, entry.root, allowed), allowed, fixed=True, trusted=entry.trusted
    )


def _check(source: Source, spec: RobotSpec, urdf: Urdf, entry: CatalogueEntry) -> Iterator[Finding]:
    """What of a robot file does not fit its URDF."""

    def finding(path: Path_, message: str, *, key: bool = False) -> Finding:
        return Finding("TB301", message, dotted(path), source.locate(path, key=key))

    if spec.robot != entry.file.parent.name and entry.file.name == "robot.yaml":
        message = f'is "{spec.robot}"; the folder is "{entry.file.parent.name}": use one name'
        yield Finding("TB109", message, "robot", source.locate(("robot",)))
    links = [link.name for link in urdf.links]
    moving = {joint.name: joint for joint in urdf.moving_joints}
    for path, name in _link_names(spec):
        if name not in links:
            help_ = suggestion(name, links, what="its links")
            yield finding(path, f'the URDF has no link "{name}"; {help_}')
    unknown = False
    for path, name in _joint_names(spec):
        if name not in moving:
            unknown = True
            what = "does not move" if name in [j.name for j in urdf.joints] else "does not exist"
            help_ = suggestion(name, moving, what="joints that move")
            yield finding(path, f'the URDF\'s joint "{name}" {what}; {help_}', key=path[0] != "arm")
    if len(spec.home_deg) != len(spec.arm):
        given = f"{len(spec.home_deg)} value{'s' * (len(spec.home_deg) != 1)}"
        message = f"has {given} for {len(spec.arm)} arm joints; give one each"
        yield finding(("home_deg",), message)
    elif not unknown:
        joints = [moving[name] for name in spec.arm]
        yield from check_joint_values(source, ("home_deg",), joints, spec.home_deg)
    if unknown:
        return
    yield from (finding(path, misfit) for path, misfit in _misfits(spec, urdf))
    for name, ends in _gripper_joints(spec).items():
        for key, value in (("open", ends.open), ("closed", ends.closed)):
            path = ("gripper", "joints", name, key)
            if problem := beyond_limits(moving[name], value):
                yield finding(path, problem)


def _misfits(spec: RobotSpec, urdf: Urdf) -> Iterator[tuple[Path_, str]]:
    """Joints and links that are there, but not where arm, tcp and fingers need them."""
    links = {link.name for link in urdf.links}
    for index, name in enumerate(spec.arm):
        if name in spec.arm[:index] or name in _gripper_joints(spec):
            yield ("arm", index), f'"{name}" stands twice; a joint is of the arm or of the gripper'
            return
    if spec.tcp.link in links:
        above = [joint.name for joint in _joints_above(urdf, spec.tcp.link)]
        moving = tuple(name for name in reversed(above) if name in spec.arm)
        for index, name in enumerate(spec.arm):
            if name not in above:
                yield ("arm", index), f'"{name}" does not move the tcp; name the joints that do'
                return
        if moving != spec.arm:
            yield ("arm",), f"not from base to wrist; that is {', '.join(moving)}"
    if spec.gripper is not None:
        yield from _gripper_misfits(spec.gripper, urdf)
    elif (
        spec.suction is None and spec.tcp.link in links and not urdf.link(spec.tcp.link).collisions
    ):
        message = f'without a gripper, "{spec.tcp.link}" is what the robot pushes with'
        advice = "and it has no collision shape; name a link that has one"
        yield ("tcp", "link"), f"{message}, {advice}"


def _gripper_misfits(gripper: GripperSpec, urdf: Urdf) -> Iterator[tuple[Path_, str]]:
    """Fingers that no joint moves, and joints that go nowhere."""
    links = {link.name for link in urdf.links}
    above = {
        link: {joint.name for joint in _joints_above(urdf, link) if joint.moves}
        for finger in gripper.fingers
        for link in finger
        if link in links
    }
    moved = {link for link, joints in above.items() if joints & set(gripper.joints)}
    # One finger may stand still on what carries the others: a fixed jaw.
    carriers = set.union(*(above[link] for link in moved)) - set(gripper.joints) if moved else set()
    fixed = [
        i
        for i, finger in enumerate(gripper.fingers)
        if all(link in above and link not in moved for link in finger)
        and carriers
        and all(carriers <= above[link] for link in finger)
    ]
    for i, finger in enumerate(gripper.fingers):
        for j, link in enumerate(finger):
            if link in links and link not in moved and i not in fixed[:1]:
                yield ("gripper", "fingers", i, j), f'no joint of the gripper moves "{link}"'
    if all(ends.open == ends.closed for ends in gripper.joints.values()):
        yield ("gripper", "joints"), "open and closed are the same; write where its joints go"


def _joints_above(urdf: Urdf, link: str) -> Iterator[UrdfJoint]:
    """The joints from a link up to the root."""
    joint = urdf.joint_above(link)
    while joint is not None:
        yield joint
        joint = urdf.joint_above(joint.parent)


def check_joint_values(
    source: Source, path: Path_, joints: Sequence[UrdfJoint], written: Sequence[float]
) -> Iterator[Finding]:
    """Joint values, as files write them, that lie beyond the joints' limits."""
    values = joint_values(joints, written)
    for index, (joint, value) in enumerate(zip(joints, values, strict=True)):
        if problem := beyond_limits(joint, value):
            place = (*path, index)
            yield Finding("TB302", problem, dotted(place), source.locate(place))


def beyond_limits(joint: UrdfJoint, value: float) -> str | None:
    """What is wrong with a position (rad or m) beyond a joint's limits, or None."""
    if joint.lower is None or joint.upper is None:
        return None
    slack = 1e-4  # degrees are written rounded
    if joint.lower - slack <= value <= joint.upper + slack:
        return None
    degrees = joint.type != "prismatic"
    shown = [math.degrees(v) if degrees else v for v in (value, joint.lower, joint.upper)]
    unit = "°" if degrees else " m"
    return (
        f"{shown[0]:.4g}{unit} is beyond the limits of {joint.name}; "
        f"from {shown[1]:.4g}{unit} to {shown[2]:.4g}{unit}"
    )


def _gripper_joints(spec: RobotSpec) -> Mapping[str, GripperJoint]:
    return spec.gripper.joints if spec.gripper else {}


def _link_names(spec: RobotSpec) -> Iterator[tuple[Path_, str]]:
    yield ("tcp", "link"), spec.tcp.link
    for i, finger in enumerate(spec.gripper.fingers if spec.gripper else ()):
        for j, link in enumerate(finger):
            yield ("gripper", "fingers", i, j), link

    if spec.suction is not None:
        yield ("suction", "cup"), spec.suction.cup


def _joint_names(spec: RobotSpec) -> Iterator[tuple[Path_, str]]:
    for index, name in enumerate(spec.arm):
        yield ("arm", index), name
    for name in _gripper_joints(spec):
        yield ("gripper", "joints", name), name
