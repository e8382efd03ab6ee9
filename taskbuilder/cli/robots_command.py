"""`taskbuilder robots`, `robots check`, `robots import` and `robots poses`."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskbuilder.assets import codes
from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.assets.paths import PACKAGE, AssetError, packages_named_in, resolve
from taskbuilder.assets.urdf import read_urdf
from taskbuilder.cli.output import paint, print_json, print_table, show_finding
from taskbuilder.cli.robot_trials import print_trial, tried, tried_gripper
from taskbuilder.cli.tasks import catalogue_of, make_folder, tell_of_clashes
from taskbuilder.errors import (
    FileError,
    Finding,
    Location,
    UnknownNameError,
    UsageError,
    display_path,
    in_reading_order,
)
from taskbuilder.kinematics.chain import Chain
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry, similar
from taskbuilder.schema.robot import MOST_JOINTS
from taskbuilder.schema.robots import RobotModel, load_robot
from taskbuilder.trials.findings import untouching_fingers
from taskbuilder.trials.proposing import corrected, proposed_model
from taskbuilder.trials.robot_trial import RobotTrial
from taskbuilder.visual.annotations import arm_reach, axes
from taskbuilder.visual.ink import Marks
from taskbuilder.visual.robot_picture import take_robot_picture
from taskbuilder.visual.still import save_image
from taskbuilder.world.arm_branches import FEW
from taskbuilder.world.reach import longest_reach
from taskbuilder.world.robot_file import robot_file
from taskbuilder.world.robot_proposal import Proposal, propose

_MOST_ROOM_M = 2.0


def run(arguments: argparse.Namespace) -> int:
    """List the robots, check or import one, or list the postures that a file names."""
    if arguments.action in ("import", "poses"):
        from taskbuilder.cli.importing import run_import, run_poses  # which nothing else needs

        if arguments.robot is None:
            raise UsageError(f"{arguments.action} which file? give its path")
        importing = arguments.action == "import"
        return run_import(arguments, robot=True) if importing else run_poses(arguments)
    catalogue = catalogue_of(arguments)
    if arguments.action in (None, "list"):
        return _list(arguments, catalogue)
    if arguments.robot is None:
        raise UsageError("check which robot? give a name, or the path of a robot.yaml or URDF")
    return _check(arguments, catalogue)


def _list(arguments: argparse.Namespace, catalogue: Catalogue) -> int:
    tell_of_clashes(catalogue, "robot")
    robots = [_describe(entry, catalogue) for entry in catalogue.robots.values()]
    if arguments.json:
        print_json({"robots": robots})
        return 0
    rows = [["robot", "joints", "gripper", "summary"]]
    rows += [
        [robot["name"], str(robot["joints"] or "-"), robot["gripper"] or "-", robot["summary"]]
        for robot in robots
    ]
    print_table(rows, prose=True)
    for robot in robots:
        if not robot["joints"]:
            hint = f"to see what is wrong: taskbuilder robots check {robot['path']}"
            print(paint(f"\n{hint}", "dim"))
    return 0


def _describe(entry: CatalogueEntry, catalogue: Catalogue) -> dict[str, Any]:
    known = {"name": entry.name, "path": display_path(entry.file)}
    try:
        robot = load_robot(entry, catalogue.folders)
    except FileError:
        return {**known, "joints": None, "gripper": None, "stroke": None, "summary": "(has errors)"}
    return {
        **known,
        "joints": len(robot.arm),
        "gripper": robot.grip or None,
        "stroke": robot.stroke or None,
        "summary": robot.spec.summary,
    }


def _check(arguments: argparse.Namespace, catalogue: Catalogue) -> int:
    findings: list[Finding] = []
    urdf = robot = None
    try:
        urdf, robot = _read(arguments.robot, catalogue)
    except FileError as error:
        findings += error.findings
    proposal, pictures, trial = None, [], None
    if urdf is not None:
        trusted = robot is not None and robot.entry.trusted
        findings += () if trusted else urdf.warnings
        joints = dict(zip(robot.spec.arm, robot.home, strict=True)) if robot else {}
        joints |= _open_gripper(robot) if robot else {}
        proposal = None if robot else propose(urdf)
        if proposal is not None and proposal.too_long:
            findings.append(_too_long(urdf, proposal))
        joints |= proposal.open if proposal else {}
        arm = _arm(urdf, robot, proposal)
        file = arguments.out or Path("renders", f"{robot.entry.name if robot else urdf.name}.png")
        pictures = _pictures(file, urdf, joints, findings, arm, trusted=trusted)
        if proposal is not None and proposal.too_long:
            pass  # no robot file can say what it is, so there is none to try
        elif arguments.quick:
            findings += _untouching(urdf, robot, proposal)
        elif not _failed(findings):
            trial, proposal = _trial(urdf, robot, proposal, findings)
    ok = not _failed(findings)
    if arguments.json:
        data = _check_data(arguments.robot, ok, urdf, findings, pictures, proposal)
        print_json({**data, "trial": trial.as_data() if trial else None})
        return 0 if ok else 1
    if urdf is not None:
        _print_robot(urdf, robot)
        if trial is not None:
            print_trial(trial)
        if robot is None and not (proposal and proposal.too_long):
            _print_proposal(urdf, proposal)
    for finding in in_reading_order(findings):
        print(show_finding(finding))
    print(paint("ok", "green") if ok else paint("failed", "red"))
    for picture in pictures:
        print(display_path(picture))
    return 0 if ok else 1


def _too_long(urdf: Urdf, proposal: Proposal) -> Finding:
    """What is said of a chain of joints that no robot file may list."""
    first = proposal.arm[MOST_JOINTS].name
    element = next(each for each in urdf.tree.all("joint") if each.get("name") == first)
    place = Location(urdf.path, element.line, element.column)
    return Finding(codes.NOT_IMPORTED, proposal.too_long, f"joint {first}", place)


def _failed(findings: Sequence[Finding]) -> bool:
    return any(finding.severity == "error" for finding in findings)


def _trial(
    urdf: Urdf, robot: RobotModel | None, proposal: Proposal | None, findings: list[Finding]
) -> tuple[RobotTrial | None, Proposal | None]:
    """Try the robot, or what is proposed; the proposal is corrected by what was measured."""
    if robot is None and (proposal is None or len(proposal.arm) < FEW):
        return None, proposal  # of something that is no arm, such as the wheel of a car
    gripper = None
    try:
        if robot is None and proposal is not None and proposal.gripper:
            first, gripper = proposal, tried_gripper(proposed_model(urdf, proposal))
            proposal = corrected(first, gripper)
            gripper = None if proposal is not first else gripper
        model = robot or (proposed_model(urdf, proposal) if proposal else None)
        trial, found = tried(model, gripper) if model is not None else (None, ())
    except FileError as error:
        trial, found = None, tuple(error.findings)
    findings += found
    return trial, proposal


def _untouching(
    urdf: Urdf, robot: RobotModel | None, proposal: Proposal | None
) -> tuple[Finding, ...]:
    """What is wrong with fingers that needs no trial."""
    if robot is None and proposal is not None and proposal.gripper:
        robot = proposed_model(urdf, proposal)
    return untouching_fingers(robot) if robot is not None else ()


def _read(reference: str, catalogue: Catalogue) -> tuple[Urdf, RobotModel | None]:
    if reference.startswith(PACKAGE):
        return _read_packaged(reference, catalogue), None
    if reference.endswith((".urdf", ".xml")):
        path = Path(reference).absolute()
        if not path.exists():
            raise UnknownNameError(f"there is no file {display_path(path)}{similar(path)}")
        return read_urdf(path, (path.parent, *packages_named_in(path)), fixed=True), None
    if Path(reference).is_file() and not reference.endswith((".yaml", ".yml")):
        raise UnknownNameError(f"{reference} is no robot; name a robot.yaml, a .urdf or an .xml")
    robot = load_robot(catalogue.robot(reference, Path()), catalogue.folders)
    return robot.urdf, robot


def _read_packaged(reference: str, catalogue: Catalogue) -> Urdf:
    """A URDF that is named as robot files name it.

    Raises:
        FileError: There is none, or it is wrong.
    """
    here = Path.cwd()
    try:
        path = resolve(reference, here, (here, *catalogue.folders))
    except AssetError as error:
        raise FileError([error.finding()]) from error
    return read_urdf(path, (path.parent,), fixed=True)


def _open_gripper(robot: RobotModel) -> dict[str, float]:
    gripper = robot.spec.gripper
    return {name: ends.open for name, ends in gripper.joints.items()} if gripper else {}


@dataclass(frozen=True)
class _Arm:
    """An arm, as far as it is shown."""

    chain: Chain
    home: tuple[float, ...]


def _arm(urdf: Urdf, robot: RobotModel | None, proposal: Proposal | None) -> _Arm | None:
    """The arm of a robot file, or the proposed one."""
    if robot is not None:
        spec = robot.spec
        return _Arm(Chain.of(urdf, spec.arm, spec.tcp.link, spec.tcp.pose), robot.home)
    if proposal is None:
        return None
    names = [joint.name for joint in proposal.arm]
    return _Arm(Chain.of(urdf, names, proposal.tcp_link, proposal.tcp), proposal.home)


def _pictures(
    file: Path,
    urdf: Urdf,
    joints: Mapping[str, float],
    findings: list[Finding],
    arm: _Arm | None,
    *,
    trusted: bool,
) -> list[Path]:
    """Take the picture, unless the engine does not survive or understand the asset.

    If there is an arm, the picture shows the tool's axes, and another one what the arm reaches.
    """
    marks = Marks()
    if arm is not None:
        room = min(longest_reach(arm.chain), _MOST_ROOM_M)
        marks = axes(arm.chain.forward(arm.home), "tcp", 0.12 * room)
    try:
        pixels, said = take_robot_picture(urdf, joints, trusted=trusted, marks=marks)
    except AssetError as error:
        findings.append(error.finding(location=Location(urdf.path)))
        return []
    if not trusted:
        place = Location(urdf.path)
        # Of missing inertia the check of the URDF tells more, and only where it matters.
        told = [text for text in said if "<inertial>" not in text]
        findings += [Finding("TB407", text, "", place, "warning") for text in told]
    make_folder(file.parent)
    save_image(file, pixels)
    if arm is None or room <= 0.0:  # joints that all turn about the tool itself
        return [file]
    reach = arm_reach(arm.chain, arm.home, room)
    pixels, _ = take_robot_picture(urdf, joints, trusted=True, marks=reach, room_m=room)
    save_image(file.with_stem(f"{file.stem}-reach"), pixels)
    return [file, file.with_stem(f"{file.stem}-reach")]


def _print_proposal(urdf: Urdf, proposal: Proposal | None) -> None:
    """What a robot.yaml beside a bare URDF may say."""
    if proposal is None:
        print("  no arm was found: a robot is a chain of joints from its root to a tool\n")
        return
    folder = urdf.path.parent
    print(f"  proposal for {display_path(folder / 'robot.yaml')}; compare it with the pictures:\n")
    print(robot_file(urdf, proposal))


def _print_robot(urdf: Urdf, robot: RobotModel | None) -> None:
    mass = sum(link.mass or 0.0 for link in urdf.links)
    name = robot.entry.name if robot else urdf.name
    moving = len(urdf.moving_joints)
    joints = "1 joint that moves" if moving == 1 else f"{moving} joints that move"
    parts = f"{len(urdf.links)} links · {joints} · {mass:.1f} kg"
    print(paint(f"{name} · {parts} · {display_path(urdf.path)}", "bold"))
    print()
    roles = _roles(robot)
    rows = [["joint", "type", "from", "to", "effort", "speed", "role"]]
    rows += [_joint_row(joint, roles.get(joint.name, "")) for joint in urdf.moving_joints]
    print_table(rows, indent="  ")
    if robot:
        print()
        held = f"gripper opens {robot.grip}" if robot.stroke else robot.grip or "no gripper"
        print(f"  tcp on {robot.spec.tcp.link}; {held}")
    print()


def _roles(robot: RobotModel | None) -> dict[str, str]:
    if robot is None:
        return {}
    arm = {name: f"arm {number}" for number, name in enumerate(robot.spec.arm, start=1)}
    return arm | dict.fromkeys(_open_gripper(robot), "gripper")


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
    pictures: Sequence[Path],
    proposal: Proposal | None,
) -> dict[str, Any]:
    joints = urdf.moving_joints if urdf else ()
    return {
        "robot": reference,
        "ok": ok,
        "joints": [
            {"name": j.name, "type": j.type, "lower": j.lower, "upper": j.upper} for j in joints
        ],
        "findings": [finding.as_data() for finding in in_reading_order(findings)],
        "picture": display_path(pictures[0]) if pictures else None,
        "reach": display_path(pictures[1]) if len(pictures) > 1 else None,
        "proposal": robot_file(urdf, proposal) if urdf and proposal else None,
    }
