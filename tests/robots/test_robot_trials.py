"""`robots check` tries a robot: what is wrong is found, with what was measured and the key."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from made_arms import MadeArm

from taskbuilder.errors import Finding
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.robots import RobotModel, load_robot
from taskbuilder.trials.findings import judge, untouching_fingers
from taskbuilder.trials.robot_trial import RobotTrial, try_gripper, try_robot

Write = Callable[..., RobotModel]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write_robot(made: MadeArm, name: str = "mine") -> RobotModel:
        return load_robot(CatalogueEntry(name, made.write(tmp_path / name)))

    return write_robot


def of_gripper(model: RobotModel) -> list[Finding]:
    return list(judge(RobotTrial(try_gripper(model), ()), model))


def test_a_sound_robot_gives_figures_and_no_finding(write):
    model = write(MadeArm())
    trial = try_robot(model)
    assert judge(trial, model) == ()
    assert trial.gripper.opened.width == pytest.approx(0.085, abs=1e-3)
    assert trial.gripper.closed.width == pytest.approx(0.0, abs=2e-3)
    assert trial.gripper.expected == pytest.approx(20.0, rel=0.01)
    assert [grip.width for grip in trial.gripper.grips] == pytest.approx(
        [0.017, 0.0425, 0.072], abs=1e-3
    )
    assert all(grip.held and grip.load > 20.0 for grip in trial.gripper.grips)
    # Gravity asks of the shoulder what the links beyond it weigh, stretched out.
    needed = {joint.joint: joint.needed for joint in trial.arm}
    stretched = 9.81 * (0.15 + 0.45 + 0.64 + 0.72 + 0.79 + 2 * 0.05 * 0.855)
    assert needed["j1"] == pytest.approx(0.0, abs=1e-6)
    assert 0.85 * stretched < needed["j2"] <= stretched
    assert all(joint.sag < 0.01 and joint.lag < 0.05 for joint in trial.arm)


@pytest.mark.parametrize(
    ("made", "code", "path", "said"),
    [
        (
            MadeArm(finger_kg=0.01, damping=100.0),
            "TB443",
            "gripper.joints.slide_",
            "damping of 100",
        ),
        (MadeArm(finger_kg=0.001, damping=100.0), "TB444", "gripper.fingers", "weigh 1 g"),
        (MadeArm(stroke=0.139), "TB442", "gripper.stroke", "139 mm are declared, and 85 mm"),
        (MadeArm(touching=False), "TB441", "gripper.fingers[0]", "no <collision>"),
        (MadeArm(force=0.5), "TB440", "gripper.force", "raise force from 0.5 to 20"),
        (MadeArm(tcp=0.2), "TB445", "tcp", "no finger is met from it along -y and +y"),
        (MadeArm(tcp=0.065), "TB445", "tcp", "no block fits"),
        (MadeArm(closed=0.04), "TB440", "gripper.joints", "stay 80 mm apart"),
    ],
    ids=lambda value: value if isinstance(value, str) and value.startswith("TB") else "",
)
def test_what_is_wrong_with_a_gripper_is_found(made, code, path, said, write):
    found = of_gripper(write(made))
    assert found[0].code == code
    assert found[0].path.startswith(path)
    assert said in found[0].message
    assert found[0].location.file.name == "robot.yaml"
    assert found[0].location.line > 1


def test_following_the_advice_mends_the_robot(write, tmp_path):
    weak = MadeArm(force=0.5, stroke=0.139)
    assert {finding.code for finding in of_gripper(write(weak))} == {"TB440", "TB442"}
    mended = replace(weak, force=20.0, stroke=0.085)
    file = mended.write(tmp_path / "other")
    assert of_gripper(load_robot(CatalogueEntry("other", file))) == []


def test_a_mass_mends_fingers_that_press_on_wide_blocks_only(write, tmp_path):
    light = MadeArm(finger_kg=0.016, force=30.0)
    (finding,) = of_gripper(write(light))
    assert finding.code == "TB444"
    assert "too little for the engine to press with 30 N on narrow objects" in finding.message
    written = float(re.search(r"<mass> of ([0-9.]+) kg", finding.message)[1])
    file = replace(light, finger_kg=written).write(tmp_path / "other")
    assert of_gripper(load_robot(CatalogueEntry("other", file))) == []


def test_fingers_that_pass_through_everything_are_found_without_a_trial(write):
    model = write(MadeArm(touching=False))
    found = untouching_fingers(model)
    assert [finding.path for finding in found] == ["gripper.fingers[0]", "gripper.fingers[1]"]
    assert all("robots import makes it from the visual meshes" in one.message for one in found)
    assert untouching_fingers(write(MadeArm(), "other")) == ()


def test_a_mount_without_a_finger_is_called_so(write):
    model = write(MadeArm(touching=False))
    text = model.urdf.path.read_text()
    begin = text.index('<link name="finger_a">')
    seen = text[text.index("<visual>", begin) : text.index("</visual>", begin) + len("</visual>")]
    model.urdf.path.write_text(text.replace(seen, ""))
    (finding, _) = untouching_fingers(load_robot(model.entry))
    assert "the URDF has the mounts of fingers and no fingers" in finding.message
    assert "robots import" not in finding.message


def test_an_arm_that_sags_is_found(write):
    model = write(MadeArm(effort=8.0))
    trial = RobotTrial(None, try_robot(model, try_gripper(model)).arm)
    found = {finding.path: finding for finding in judge(trial, model)}
    assert set(found) == {"joint j2", "joint j3"}
    assert found["joint j2"].code == "TB446"
    assert "of 8 Nm" in found["joint j2"].message
    assert found["joint j2"].location.file.name == "arm.urdf"
    assert (
        'name="j2"' in model.urdf.path.read_text().splitlines()[found["joint j2"].location.line - 1]
    )


def test_the_force_of_a_linkage_follows_from_its_lever():
    catalogue = Catalogue.discover()
    trial = try_gripper(load_robot(catalogue.robots["xarm6"], catalogue.folders))
    assert trial.expected == pytest.approx(20.0, rel=0.1)  # of 1.1 Nm
    assert [grip.force for grip in trial.grips] == pytest.approx([trial.expected] * 3, rel=0.2)


def test_three_fingers_hold_cylinders_though_none_is_opposite_of_another(write):
    model = write(MadeArm(fingers=3))
    trial = try_gripper(model)
    assert trial.opened.width == pytest.approx(0.085, abs=1e-3)
    assert all(grip.held and grip.slip < 2e-3 for grip in trial.grips)
    assert all(grip.force == pytest.approx(20.0, rel=0.2) for grip in trial.grips)
    assert judge(RobotTrial(trial, ()), model) == ()
