"""`taskbuilder robots import`, `robots poses` and `objects import`."""

from __future__ import annotations

import argparse
import math
import tempfile
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import starmap
from pathlib import Path
from typing import Any

import numpy as np

from taskbuilder.assets import codes
from taskbuilder.assets.model import Urdf
from taskbuilder.assets.paths import AssetError
from taskbuilder.assets.urdf import read_urdf
from taskbuilder.cli.object_figures import (
    ObjectFigures,
    measured,
    print_figures,
    print_lines_of_task,
)
from taskbuilder.cli.output import paint, print_json, print_table, show_finding
from taskbuilder.cli.robot_trials import print_trial, tried, tried_gripper
from taskbuilder.cli.tasks import make_folder
from taskbuilder.errors import FileError, Finding, Location, UsageError, display_path
from taskbuilder.importing.arms import import_arms
from taskbuilder.importing.changes import HEADER
from taskbuilder.importing.folders import (
    ROBOT_NAME,
    Imported,
    ImportSource,
    import_object,
    import_robot,
)
from taskbuilder.importing.geometry import MeshOptions
from taskbuilder.importing.mesh_files import UNITS
from taskbuilder.importing.mounting import Mount
from taskbuilder.importing.postures import read_postures
from taskbuilder.importing.writing import require_replaceable, write_folder
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.object_files import bare_object
from taskbuilder.schema.robots import load_robot
from taskbuilder.trials.findings import untouching_fingers
from taskbuilder.trials.robot_trial import RobotTrial
from taskbuilder.visual.annotations import axes
from taskbuilder.visual.ink import Marks
from taskbuilder.visual.robot_picture import take_robot_picture
from taskbuilder.visual.still import Pixels, save_image
from taskbuilder.world.robot_proposal import Proposal, link_pose


@dataclass(frozen=True)
class _Outcome:
    """What an import came to, and what was found out about it.

    Attributes:
        imported: The files.
        folder: Where they are written.
        findings: What is wrong with them.
        picture: A picture of them.
        trial: What a robot did in physics.
        writable: Whether they are written: what only a trial finds, or is said of fingers, is
            corrected in the files.
    """

    imported: Imported
    folder: Path
    findings: Sequence[Finding]
    picture: Path | None
    trial: RobotTrial | None
    writable: bool

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return not _has_error(self.findings)


def run_import(
    arguments: argparse.Namespace, *, robot: bool, catalogue: Catalogue | None = None
) -> int:
    """Import a robot or an object.

    Args:
        arguments: Of the command line.
        robot: Whether it is a robot.
        catalogue: Where the robots are whose grippers an object is compared with.
    """
    source = _source(arguments, robot=robot)
    if robot and arguments.all_arms:
        return _run_arms(arguments, source)
    try:
        imported = _imported(source, arguments) if robot else import_object(source)
    except FileError as error:
        return _failed(arguments, error)
    default = Path("robots" if robot else "objects", imported.name)
    folder: Path = arguments.out or default
    if robot and folder.name != imported.name:
        imported = _imported(_named(source, folder.name), arguments)
    require_replaceable(folder, overwrite=arguments.overwrite)
    outcome = _outcome(imported, folder, arguments, robot=robot)
    if outcome.writable:
        write_folder(folder, imported.files, overwrite=arguments.overwrite)
    figures = None
    if outcome.writable and not robot:
        model = bare_object(folder / f"{imported.name}.urdf")
        figures = measured(model, catalogue or Catalogue())
    if arguments.json:
        print_json(_data(outcome) | (figures.as_data() if figures else {}))
    else:
        _print(outcome, figures, robot=robot)
        _print_end(outcome)
    return 0 if outcome.ok else 1


def _run_arms(arguments: argparse.Namespace, source: ImportSource) -> int:
    """Import every arm of a body as a robot of its own."""
    if arguments.arm:
        raise UsageError("--arm names one arm, and --all-arms means all of them; give one of them")
    try:
        arms = import_arms(source, None if arguments.quick else tried_gripper)
    except FileError as error:
        return _failed(arguments, error)
    inside: Path = arguments.out.parent if arguments.out else Path("robots")
    folders = {agent: inside / imported.name for agent, imported in arms.robots.items()}
    for folder in folders.values():
        require_replaceable(folder, overwrite=arguments.overwrite)
    outcomes = {
        agent: _outcome(imported, folders[agent], arguments, robot=True)
        for agent, imported in arms.robots.items()
    }
    writable = all(outcome.writable for outcome in outcomes.values())
    for outcome in outcomes.values() if writable else ():
        write_folder(outcome.folder, outcome.imported.files, overwrite=arguments.overwrite)
    ok = all(outcome.ok for outcome in outcomes.values())
    entries = {
        agent: {
            "model": display_path(folder / "robot.yaml"),
            "base": {"position": [0.0, 0.0, arms.height]},
        }
        for agent, folder in folders.items()
    }
    if arguments.json:
        robots = {agent: _data(outcome) for agent, outcome in outcomes.items()}
        print_json({"ok": ok, "robots": robots, "scene": {"robots": entries}})
        return 0 if ok else 1
    for outcome in outcomes.values():
        _print(outcome, None, robot=True)
        _print_end(replace(outcome, writable=writable))
        print()
    if writable:
        print("  in a task file, they form the body where their bases are the same:\n")
        print("    robots:")
        for agent, entry in entries.items():
            base = f"{{position: [0, 0, {arms.height:g}]}}"
            print(f"      {agent}: {{model: {entry['model']}, base: {base}}}")
    return 0 if ok else 1


def _outcome(
    imported: Imported, folder: Path, arguments: argparse.Namespace, *, robot: bool
) -> _Outcome:
    """Try what was imported."""
    arm = robot and imported.proposal is not None
    findings, pixels, trial = _tried(
        imported, fixed=robot, arm=arm, quick=robot and arguments.quick
    )
    others = [finding for finding in findings if finding.code != codes.UNTOUCHING]
    writable = trial is not None or not _has_error(others)
    picture = None
    if writable and pixels is not None:
        picture = Path("renders", f"{imported.name}-import.png")
        make_folder(picture.parent)
        save_image(picture, pixels)
    return _Outcome(imported, folder, findings, picture, trial, writable)


def _imported(source: ImportSource, arguments: argparse.Namespace) -> Imported:
    return import_robot(source, None if arguments.quick else tried_gripper)


def _has_error(findings: Sequence[Finding]) -> bool:
    return any(finding.severity == "error" for finding in findings)


def run_poses(arguments: argparse.Namespace) -> int:
    """Print the postures that an SRDF or MJCF file names."""
    given = dict(arguments.arg or ())
    postures = read_postures(Path(arguments.robot), _folders(arguments), given)
    if arguments.json:
        print_json({"file": arguments.robot, "postures": {n: dict(p) for n, p in postures.items()}})
        return 0
    for name, joints in postures.items():
        print(paint(name, "bold"))
        rows = [["joint", "rad or m", "degrees"]]
        rows += [
            [joint, f"{value:.5g}", f"{math.degrees(value):.5g}"] for joint, value in joints.items()
        ]
        print_table(rows, indent="  ")
    return 0


def _named(source: ImportSource, name: str) -> ImportSource:
    return replace(source, name=name)


def _source(arguments: argparse.Namespace, *, robot: bool) -> ImportSource:
    file = Path(arguments.robot if robot else arguments.file)
    if not file.exists():
        raise UsageError(f"there is no file {display_path(file)}")
    if arguments.root is not None and not arguments.root.is_dir():
        raise UsageError(f"--root {display_path(arguments.root)}: there is no such folder")
    if robot and arguments.out and not ROBOT_NAME.fullmatch(arguments.out.name):
        raise UsageError(
            f'--out {display_path(arguments.out)}: "{arguments.out.name}" is no name of a robot; '
            "write letters, digits and _, beginning with a letter"
        )
    unit = getattr(arguments, "unit", None)
    meshes = MeshOptions(
        triangles=arguments.triangles,
        collision=arguments.collision,
        unit=UNITS[unit] if unit else None,
        up=arguments.up,
    )
    out: Path | None = arguments.out
    return ImportSource(
        file,
        _folders(arguments),
        dict(arguments.arg or ()),
        arguments.root,
        arguments.name or (out.name if out and robot else ""),
        meshes,
        getattr(arguments, "mass", None),
        arguments.density,
        _mounts(arguments) if robot else (),
        getattr(arguments, "arm", None),
        getattr(arguments, "suction", None),
    )


def _mounts(arguments: argparse.Namespace) -> tuple[Mount, ...]:
    """Each --gripper with its --at.

    Raises:
        UsageError: There are more of one than of the other.
    """
    files: list[Path] = arguments.gripper or []
    places: list[str] = arguments.at or []
    if files and not places:
        raise UsageError("on which link? --gripper needs --at LINK[@x,y,z[,roll,pitch,yaw]]")
    if len(files) != len(places):
        raise UsageError(
            f"--gripper is given {_times(len(files))} and --at {_times(len(places))}; write one "
            "--at for each --gripper, in the order in which they are mounted on one another"
        )
    return tuple(starmap(Mount, zip(files, places, strict=True)))


def _times(count: int) -> str:
    return {0: "not at all", 1: "once", 2: "twice"}.get(count, f"{count} times")


def _folders(arguments: argparse.Namespace) -> Mapping[str, Path]:
    folders = {name: Path(folder) for name, folder in arguments.package or ()}
    for name, folder in folders.items():
        if not folder.is_dir():
            raise UsageError(f"--package {name}={folder}: there is no such folder")
    return folders


def _failed(arguments: argparse.Namespace, error: FileError) -> int:
    if arguments.json:
        findings = [finding.as_data() for finding in error.findings]
        print_json({"ok": False, "findings": findings})
        return 1
    for finding in error.findings:
        print(show_finding(finding))
    print(paint("failed", "red") + "; nothing was written")
    return 1


def _tried(
    imported: Imported, *, fixed: bool, arm: bool, quick: bool
) -> tuple[list[Finding], Pixels | None, RobotTrial | None]:
    """What the physics engine says of the files, the picture, and the trial of a robot that moves.

    The files lie in a folder that is removed again.
    """
    trial = None
    with tempfile.TemporaryDirectory(prefix="taskbuilder-") as aside:
        folder = Path(aside).resolve() / imported.name
        write_folder(folder, imported.files, overwrite=False)
        urdf = read_urdf(folder / f"{imported.name}.urdf", (folder,), fixed=fixed)
        findings = list(imported.warnings)
        picture = _picture(folder, urdf, imported, findings)
        if arm and not _has_error(findings):
            model = load_robot(CatalogueEntry(imported.name, folder / "robot.yaml"))
            trial, found = (None, untouching_fingers(model)) if quick else tried(model)
            findings += found
    return [_in_folder(one, imported.name) for one in findings], picture, trial


def _in_folder(finding: Finding, name: str) -> Finding:
    """The finding at the file that will be in the folder that is written."""
    where = finding.location
    if where is None or where.file.suffix != ".yaml":
        line, column = (where.line, where.column) if where else (0, 0)
        return replace(finding, location=Location(Path(f"{name}.urdf"), line, column))
    return replace(finding, location=replace(where, file=Path(where.file.name)))


def _picture(
    folder: Path, urdf: Urdf, imported: Imported, findings: list[Finding]
) -> Pixels | None:
    """Take the picture: the looks, with the axes of the tcp, beside the collision shapes."""
    proposal = imported.proposal
    joints = proposal.open if proposal else {}
    marks = Marks()
    if proposal is not None:
        pose = link_pose(urdf, urdf.root, proposal.tcp_link, joints) @ proposal.tcp
        marks = axes(pose, "tcp", 0.1)
    try:
        looks, said = take_robot_picture(urdf, joints, trusted=False, marks=marks)
        findings += [
            Finding("TB407", text, "", Location(urdf.path), "warning")
            for text in said
            if "<inertial>" not in text
        ]
        shown = folder / "collisions.urdf"
        shown.write_text(imported.collisions, encoding="utf-8")
        collisions = read_urdf(shown, (folder,), fixed=True)
        shapes, _ = take_robot_picture(collisions, joints, trusted=True)
    except AssetError as error:
        findings.append(error.finding(location=Location(urdf.path)))
        return None
    return np.concatenate([looks, shapes], axis=1)


def _print(outcome: _Outcome, figures: ObjectFigures | None, *, robot: bool) -> None:
    imported, folder, trial = outcome.imported, outcome.folder, outcome.trial
    changes = imported.changes
    print(paint(f"{imported.name} · {display_path(folder)}", "bold"))
    print()
    print_table([HEADER, *(row.cells() for row in changes.rows)], indent="  ", prose=True)
    print()
    if changes.left_out:
        print(f"  left out: {'; '.join(changes.left_out)}\n")
    if imported.proposal is not None:
        for remark in imported.proposal.remarks:
            for line in textwrap.wrap(remark, 76, subsequent_indent="  "):
                print(f"  {line}")
        print(f"  {_words(imported.proposal)}\n")
        if trial is not None:
            print_trial(trial)
    elif robot:
        print("  no arm was found; if it is a gripper, mount it:")
        print(f"  taskbuilder robots import ARM --gripper {imported.name}.urdf --at LINK\n")
    elif figures is not None:
        urdf = read_urdf(folder / f"{imported.name}.urdf", (folder,))
        print_figures(figures, sum(link.mass or 0.0 for link in urdf.links))
        print_lines_of_task(imported.name, folder / f"{imported.name}.urdf", figures)
    for finding in outcome.findings:
        print(show_finding(finding))


def _print_end(outcome: _Outcome) -> None:
    """Whether all is well, and what was written."""
    if not outcome.writable:
        print(paint("failed", "red") + "; nothing was written")
        return
    said = paint("ok", "green") if outcome.ok else paint("failed", "red") + "; what was written is:"
    print(said)
    imported = outcome.imported
    written = "robot.yaml" if imported.proposal else f"{imported.name}.urdf"
    for path in (outcome.folder / written, outcome.picture):
        if path is not None:
            print(display_path(path))


def _words(proposal: Proposal) -> str:
    opens = f"the gripper opens {proposal.stroke * 1000:.0f} mm" if proposal.gripper else ""
    if proposal.cup is not None:
        opens = f"the suction cup {proposal.cup.link} holds {proposal.cup.force:g} N"
    joints = f"{len(proposal.arm)} joints in the arm"
    return "; ".join(filter(None, (joints, opens)))


def _data(outcome: _Outcome) -> dict[str, Any]:
    imported, picture = outcome.imported, outcome.picture
    proposal = imported.proposal
    return {
        "name": imported.name,
        "folder": display_path(outcome.folder),
        "ok": outcome.ok,
        "changes": [dict(zip(HEADER, row.cells(), strict=True)) for row in imported.changes.rows],
        "left_out": list(imported.changes.left_out),
        "arm": [joint.name for joint in proposal.arm] if proposal else None,
        "suction": proposal.cup.force if proposal and proposal.cup else None,
        "stroke": round(proposal.stroke, 4) if proposal and proposal.gripper else None,
        "questions": list(proposal.remarks) if proposal else [],
        "findings": [finding.as_data() for finding in outcome.findings],
        "picture": display_path(picture) if picture else None,
        "trial": outcome.trial.as_data() if outcome.trial else None,
    }
