"""`taskbuilder robots import`, `robots poses` and `objects import`."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import starmap
from pathlib import Path

from taskbuilder.cli.import_outcomes import outcome_data, outcome_of, print_end, print_outcome
from taskbuilder.cli.object_figures import measured
from taskbuilder.cli.output import paint, print_json, print_table, show_finding
from taskbuilder.cli.robot_trials import tried_gripper
from taskbuilder.errors import FileError, UsageError, display_path
from taskbuilder.importing.arms import import_arms
from taskbuilder.importing.folders import Imported, ImportSource, import_object, import_robot
from taskbuilder.importing.mesh_files import UNITS
from taskbuilder.importing.mesh_options import MeshOptions
from taskbuilder.importing.mounting import Mount
from taskbuilder.importing.naming import ROBOT_NAME
from taskbuilder.importing.postures import read_postures
from taskbuilder.importing.writing import require_replaceable, write_folder
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.object_files import bare_object


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
    outcome = outcome_of(imported, folder, robot=robot, quick=robot and arguments.quick)
    if outcome.writable:
        write_folder(folder, imported.files, overwrite=arguments.overwrite)
    figures = None
    if outcome.writable and not robot:
        model = bare_object(folder / f"{imported.name}.urdf")
        figures = measured(model, catalogue or Catalogue())
    if arguments.json:
        print_json(outcome_data(outcome) | (figures.as_data() if figures else {}))
    else:
        print_outcome(outcome, figures, robot=robot)
        print_end(outcome)
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
        agent: outcome_of(imported, folders[agent], robot=True, quick=arguments.quick)
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
        robots = {agent: outcome_data(outcome) for agent, outcome in outcomes.items()}
        print_json({"ok": ok, "robots": robots, "scene": {"robots": entries}})
        return 0 if ok else 1
    for outcome in outcomes.values():
        print_outcome(outcome, None, robot=True)
        print_end(replace(outcome, writable=writable))
        print()
    if writable:
        print("  in a task file, they form the body where their bases are the same:\n")
        print("    robots:")
        for agent, entry in entries.items():
            base = f"{{position: [0, 0, {arms.height:g}]}}"
            print(f"      {agent}: {{model: {entry['model']}, base: {base}}}")
    return 0 if ok else 1


def _imported(source: ImportSource, arguments: argparse.Namespace) -> Imported:
    return import_robot(source, None if arguments.quick else tried_gripper)


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
        scale=getattr(arguments, "scale", 1.0),
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
