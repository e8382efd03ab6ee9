"""`taskbuilder robots` and `taskbuilder robots check`."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.assets.paths import AssetError
from taskbuilder.assets.urdf import read_urdf
from taskbuilder.cli.output import paint, print_json, print_table, show_finding
from taskbuilder.cli.tasks import catalogue_of
from taskbuilder.errors import (
    FileError,
    Finding,
    Location,
    UnknownNameError,
    UsageError,
    display_path,
    in_reading_order,
)
from taskbuilder.portrait import take_portrait
from taskbuilder.render import save_image
from taskbuilder.spec.catalogue import Catalogue
from taskbuilder.spec.robots import RobotModel, load_robot


def run(arguments: argparse.Namespace) -> int:
    """List the robots, or check one."""
    catalogue = catalogue_of(arguments)
    if arguments.action is None:
        return _list(arguments, catalogue)
    if arguments.robot is None:
        raise UsageError("check which robot? give a name, or the path of a robot.yaml or URDF")
    return _check(arguments, catalogue)


def _list(arguments: argparse.Namespace, catalogue: Catalogue) -> int:
    robots = [load_robot(entry) for entry in catalogue.robots.values()]
    if arguments.json:
        print_json({"robots": [_robot_data(robot) for robot in robots]})
        return 0
    rows = [["robot", "joints", "gripper", "summary"]]
    for robot in robots:
        stroke = f"{robot.spec.gripper.stroke * 1000:.0f} mm"
        rows.append([robot.entry.name, str(len(robot.arm)), stroke, robot.spec.summary])
    print_table(rows)
    return 0


def _robot_data(robot: RobotModel) -> dict[str, Any]:
    return {
        "name": robot.entry.name,
        "path": display_path(robot.entry.file),
        "joints": len(robot.arm),
        "stroke": robot.spec.gripper.stroke,
        "summary": robot.spec.summary,
    }


def _check(arguments: argparse.Namespace, catalogue: Catalogue) -> int:
    findings: list[Finding] = []
    urdf = robot = None
    try:
        urdf, robot = _read(arguments.robot, catalogue)
    except FileError as error:
        findings += error.findings
    picture = None
    if urdf is not None:
        trusted = robot is not None and robot.entry.trusted
        findings += () if trusted else urdf.warnings
        joints = dict(zip(robot.spec.arm, robot.home, strict=True)) if robot else {}
        joints |= _open_gripper(robot) if robot else {}
        file = arguments.out or Path("renders", f"{robot.entry.name if robot else urdf.name}.png")
        picture = _portrait(file, urdf, joints, findings, trusted=trusted)
    ok = not any(finding.severity == "error" for finding in findings)
    if arguments.json:
        print_json(_check_data(arguments.robot, ok, urdf, findings, picture))
        return 0 if ok else 1
    if urdf is not None:
        _print_robot(urdf, robot)
    for finding in in_reading_order(findings):
        print(show_finding(finding))
    print(paint("ok", "green") if ok else paint("failed", "red"))
    if picture is not None:
        print(display_path(picture))
    return 0 if ok else 1


def _read(reference: str, catalogue: Catalogue) -> tuple[Urdf, RobotModel | None]:
    if reference.endswith((".urdf", ".xml")):
        path = Path(reference).absolute()
        if not path.is_file():
            raise UnknownNameError(f"there is no file {display_path(path)}")
        return read_urdf(path, (path.parent,)), None
    robot = load_robot(catalogue.robot(reference, Path()), catalogue.folders)
    return robot.urdf, robot


def _open_gripper(robot: RobotModel) -> dict[str, float]:
    return {name: ends.open for name, ends in robot.spec.gripper.joints.items()}


def _portrait(
    file: Path,
    urdf: Urdf,
    joints: Mapping[str, float],
    findings: list[Finding],
    *,
    trusted: bool,
) -> Path | None:
    """Take the picture, unless the engine does not survive or understand the asset."""
    try:
        pixels, said = take_portrait(urdf, joints, trusted=trusted)
    except AssetError as error:
        findings.append(error.finding(location=Location(urdf.path)))
        return None
    if not trusted:
        place = Location(urdf.path)
        findings += [Finding("TB407", text, "", place, "warning") for text in said]
    file.parent.mkdir(parents=True, exist_ok=True)
    save_image(file, pixels)
    return file


def _print_robot(urdf: Urdf, robot: RobotModel | None) -> None:
    mass = sum(link.mass or 0.0 for link in urdf.links)
    name = robot.entry.name if robot else urdf.name
    parts = f"{len(urdf.links)} links · {len(urdf.moving_joints)} joints that move · {mass:.1f} kg"
    print(paint(f"{name} · {parts} · {display_path(urdf.path)}", "bold"))
    print()
    roles = _roles(robot)
    rows = [["joint", "type", "from", "to", "effort", "speed", "role"]]
    rows += [_joint_row(joint, roles.get(joint.name, "")) for joint in urdf.moving_joints]
    print_table(rows, indent="  ")
    if robot:
        grip = robot.spec.gripper
        print()
        print(f"  tcp on {robot.spec.tcp.link}; gripper opens {grip.stroke * 1000:.0f} mm")
    print()


def _roles(robot: RobotModel | None) -> dict[str, str]:
    if robot is None:
        return {}
    arm = {name: f"arm {number}" for number, name in enumerate(robot.spec.arm, start=1)}
    return arm | dict.fromkeys(robot.spec.gripper.joints, "gripper")


def _joint_row(joint: UrdfJoint, role: str) -> list[str]:
    slides = joint.type == "prismatic"

    def shown(value: float | None, unit: str, turns: bool) -> str:
        if value is None:
            return "-"
        return f"{math.degrees(value) if turns else value:.4g} {unit}"

    length, effort = ("m", "N") if slides else ("°", "Nm")
    return [
        joint.name,
        joint.type,
        shown(joint.lower, length, not slides),
        shown(joint.upper, length, not slides),
        shown(joint.effort, effort, False),
        shown(joint.velocity, f"{length}/s", not slides),
        role,
    ]


def _check_data(
    reference: str,
    ok: bool,
    urdf: Urdf | None,
    findings: list[Finding],
    picture: Path | None,
) -> dict[str, Any]:
    joints = urdf.moving_joints if urdf else ()
    return {
        "robot": reference,
        "ok": ok,
        "joints": [
            {"name": j.name, "type": j.type, "lower": j.lower, "upper": j.upper} for j in joints
        ],
        "findings": [finding.as_data() for finding in in_reading_order(findings)],
        "picture": display_path(picture) if picture else None,
    }
