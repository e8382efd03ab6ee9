"""Grippers that are imported hold things: their forces are proposed, tried and corrected."""

from __future__ import annotations

import pytest
from made_robots import INERTIAL, arm, jaw, joint, link, two_fingers

from taskbuilder.importing.folders import ImportSource, import_robot
from taskbuilder.importing.writing import write_folder
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.schema.robots import load_robot
from taskbuilder.trials.findings import judge
from taskbuilder.trials.robot_trial import RobotTrial, try_gripper

SMALL = """<inertial><origin xyz="0 0 0.02"/><mass value="0.03"/>
<inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial>"""


def written(imported, folder):
    write_folder(folder / imported.name, imported.files, overwrite=True)
    return load_robot(CatalogueEntry(imported.name, folder / imported.name / "robot.yaml"))


def linkage() -> str:
    """Two fingers on parallelograms, as of a Robotiq 2F-85: knuckles turn, fingers stay parallel.

    All joints mimic one of them; the fingers open by 90 mm.
    """
    text = ""
    for side, sign in (("left", 1), ("right", -1)):
        limit = '<limit lower="-0.8" upper="0.8" effort="1000" velocity="2"/>'
        follow = "" if side == "left" else '<mimic joint="left_knuckle_joint" multiplier="-1"/>'
        back = f'<mimic joint="left_knuckle_joint" multiplier="{-sign}"/>'
        bar = '<box size="0.01 0.02 0.04"/>'
        text += link(f"{side}_knuckle", bar, inertial=SMALL).replace("0 0 0.05", "0 0 0.025")
        text += joint(
            f"{side}_knuckle_joint", "l6", f"{side}_knuckle", f"{0.0125 * sign} 0 0.1", "0 1 0",
            extra=limit + follow,
        )  # fmt: skip
        text += link(f"{side}_finger", bar, inertial=SMALL).replace("0 0 0.05", "0 0 0.02")
        text += joint(
            f"{side}_finger_joint", f"{side}_knuckle", f"{side}_finger", "0 0 0.05", "0 1 0",
            extra=limit + back,
        )  # fmt: skip
    return text


def test_an_adaptive_linkage_holds_blocks_of_every_width(write, tmp_path):
    imported = import_robot(ImportSource(write(arm() + linkage())), try_gripper)
    model = written(imported, tmp_path)
    assert len(model.spec.gripper.joints) == 4
    trial = try_gripper(model)
    assert trial.expected == pytest.approx(20.0, rel=0.15)
    assert all(grip.held and grip.load > 5.0 for grip in trial.grips)
    assert model.spec.gripper.stroke == pytest.approx(trial.opened.width, abs=2e-3)
    assert judge(RobotTrial(trial, ()), model) == ()


def test_fingers_that_would_fly_are_steadied_and_the_change_is_a_row(write, tmp_path):
    fingers = two_fingers().replace('value="0.02"', 'value="0.002"')
    fingers = fingers.replace('velocity="0.1"/>', 'velocity="0.1"/><dynamics damping="100"/>')
    imported = import_robot(ImportSource(write(arm() + fingers)), try_gripper)
    changed = {(row.subject, row.what) for row in imported.changes.rows}
    assert {("joint slide_a", "damping"), ("joint slide_b", "damping")} <= changed
    assert {("link finger_a", "mass"), ("link finger_b", "mass")} <= changed
    model = written(imported, tmp_path)
    trial = try_gripper(model)
    assert trial.motion.fastest < 2.0
    assert all(grip.held for grip in trial.grips)


def test_damping_with_which_a_jaw_would_fly_is_lowered(write, tmp_path):
    light = INERTIAL.replace('value="1"', 'value="0.05"').replace("0.01", "1e-5")
    end = 'effort="5" velocity="2"/>'
    damped = jaw().replace(INERTIAL, light).replace(end, f'{end}<dynamics damping="1"/>')
    imported = import_robot(ImportSource(write(arm() + damped)), try_gripper)
    (row,) = [row for row in imported.changes.rows if row.what == "damping"]
    assert (row.before, row.after) == ("1 Nm s/rad", "0.03 Nm s/rad")
    trial = try_gripper(written(imported, tmp_path))
    assert trial.motion.left < 0.01
    assert trial.motion.still < 0.01
    assert all(grip.held for grip in trial.grips if grip.fits)


def test_a_force_is_bounded_by_an_effort_that_is_sane(write, tmp_path):
    def proposed(effort: str) -> tuple[float, str]:
        fingers = two_fingers().replace('effort="10"', f'effort="{effort}"')
        imported = import_robot(ImportSource(write(arm() + fingers)))
        remarks = " ".join(imported.proposal.remarks)
        return imported.proposal.force, remarks

    assert proposed("60")[0] == pytest.approx(20.0)
    force, remarks = proposed("10")
    assert force == pytest.approx(10.0)
    assert "force is the effort of the URDF" in remarks
    assert "What does the data sheet say? For 20 N, write force: 20 in robot.yaml" in remarks
    force, remarks = proposed("0.1")
    assert force == pytest.approx(20.0)
    assert "What does the data sheet say?" in remarks
