"""Robots that are only proposed: tried as they are, and corrected by what was measured."""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from pathlib import Path

from taskbuilder.assets.model import Urdf
from taskbuilder.errors import FileError
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.schema.explain import parse
from taskbuilder.schema.robot import RobotSpec
from taskbuilder.schema.robots import RobotModel
from taskbuilder.schema.source import read_source
from taskbuilder.trials.robot_trial import GripperTrial
from taskbuilder.world.grip_force import FINGERTIP_N
from taskbuilder.world.robot_file import robot_file
from taskbuilder.world.robot_proposal import Proposal

_OFF_SHARE, _OFF_M = 0.1, 1e-3


def proposed_model(urdf: Urdf, proposal: Proposal) -> RobotModel:
    """The robot that the proposed robot file would make.

    Raises:
        FileError: It would make none.
    """
    with tempfile.TemporaryDirectory(prefix="taskbuilder-") as folder:
        file = Path(folder) / "robot.yaml"
        file.write_text(robot_file(urdf, proposal), encoding="utf-8")
        spec, findings = parse(RobotSpec, read_source(file))
    if spec is None:
        raise FileError(findings)
    return RobotModel(CatalogueEntry(spec.robot, urdf.path), spec, urdf)


def corrected(proposal: Proposal, trial: GripperTrial) -> Proposal:
    """A proposal with the stroke that was measured, and the force that the fingers need for it.

    A force that the URDF bounds is only lowered.
    """
    width = trial.opened.width
    if math.isfinite(width) and abs(width - proposal.stroke) > _OFF_M and width > _OFF_M:
        proposal = replace(proposal, stroke=width)
    if trial.expected <= 0.0 or not math.isfinite(trial.expected):
        return proposal
    factor = FINGERTIP_N / trial.expected
    if abs(factor - 1.0) <= _OFF_SHARE or (factor > 1.0 and proposal.bounded):
        return proposal
    return replace(proposal, force=float(f"{factor * proposal.force:.2g}"))
