"""What an import came to: tried in physics, shown in a picture, and printed."""

from __future__ import annotations

import tempfile
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from taskbuilder.assets import codes
from taskbuilder.assets.model import Urdf
from taskbuilder.assets.paths import AssetError
from taskbuilder.assets.urdf import read_urdf
from taskbuilder.cli.object_figures import ObjectFigures, print_figures, print_lines_of_task
from taskbuilder.cli.output import paint, print_table, show_finding
from taskbuilder.cli.robot_trials import print_trial, tried
from taskbuilder.cli.tasks import make_folder
from taskbuilder.errors import Finding, Location, display_path
from taskbuilder.importing.changes import HEADER
from taskbuilder.importing.folders import Imported
from taskbuilder.importing.writing import write_folder
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.schema.robots import load_robot
from taskbuilder.trials.findings import untouching_fingers
from taskbuilder.trials.robot_trial import RobotTrial
from taskbuilder.visual.annotations import axes
from taskbuilder.visual.ink import Marks
from taskbuilder.visual.robot_picture import take_robot_picture
from taskbuilder.visual.still import Pixels, save_image
from taskbuilder.world.robot_proposal import Proposal, link_pose


@dataclass(frozen=True)
class ImportOutcome:
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


def outcome_of(imported: Imported, folder: Path, *, robot: bool, quick: bool) -> ImportOutcome:
    """Try what was imported, and take its picture.

    Args:
        imported: The files.
        folder: Where they are to be written.
        robot: Whether it is a robot.
        quick: Whether a robot is not tried in physics.
    """
    arm = robot and imported.proposal is not None
    findings, pixels, trial = _tried(imported, fixed=robot, arm=arm, quick=quick)
    others = [finding for finding in findings if finding.code != codes.UNTOUCHING]
    writable = trial is not None or not _has_error(others)
    picture = None
    if writable and pixels is not None:
        picture = Path("renders", f"{imported.name}-import.png")
        make_folder(picture.parent)
        save_image(picture, pixels)
    return ImportOutcome(imported, folder, findings, picture, trial, writable)


def _has_error(findings: Sequence[Finding]) -> bool:
    return any(finding.severity == "error" for finding in findings)


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


def print_outcome(outcome: ImportOutcome, figures: ObjectFigures | None, *, robot: bool) -> None:
    """Print what was changed, what was proposed and measured, and what is wrong."""
    imported, folder, trial = outcome.imported, outcome.folder, outcome.trial
    changes = imported.changes
    print(paint(f"{imported.name} · {display_path(folder)}", "bold"))
    print()
    if changes.rows:
        print_table([HEADER, *(row.cells() for row in changes.rows)], indent="  ", prose=True)
    else:
        print("  nothing had to be changed")
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


def print_end(outcome: ImportOutcome) -> None:
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


def outcome_data(outcome: ImportOutcome) -> dict[str, Any]:
    """What ``--json`` prints of it."""
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
