"""Suction cups that are mounted on imported arms take plates."""

from __future__ import annotations

import re

import pytest
from made_robots import INERTIAL, arm, joint, link

from taskbuilder.errors import FileError
from taskbuilder.importing.folders import ImportSource, import_robot
from taskbuilder.importing.mounting import Mount
from taskbuilder.importing.writing import write_folder
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.schema.robots import load_robot
from taskbuilder.trials.findings import judge
from taskbuilder.trials.robot_trial import RobotTrial
from taskbuilder.trials.stand import stand
from taskbuilder.trials.sucking import try_cup

SMALL = INERTIAL.replace('value="1"', 'value="0.1"').replace("0.01", "1e-4")


def cup(part: str = "cup", tip: str = "0 0 0.1") -> str:
    """An ejector with a cup of 30 mm at its end, as makers sell it: nothing moves."""
    text = link("ejector", '<cylinder radius="0.03" length="0.1"/>', inertial=SMALL)
    shape = '<cylinder radius="0.015" length="0.03"/>'
    text += link(part, shape, inertial=SMALL).replace("0 0 0.05", "0 0 0.015", 3)
    return text + joint("screw", "ejector", part, tip, kind="fixed", extra="")


@pytest.fixture
def mount(write, package):
    """Imports the arm with a part on its last link."""

    def imported(inside, at="l6@0,0,0.1", name="picker", **options):
        part = package / "urdf" / f"{name}.urdf"
        part.write_text(f'<robot name="{name}">{inside}</robot>')
        return import_robot(ImportSource(write(arm()), mounts=(Mount(part, at),), **options))

    return imported


def loaded(imported, folder):
    write_folder(folder / imported.name, imported.files, overwrite=True)
    return load_robot(CatalogueEntry(imported.name, folder / imported.name / "robot.yaml"))


def tried(model):
    with stand(model, rigid=True) as rigid:
        return try_cup(rigid, model.spec.suction)


def test_a_cup_is_found_by_its_name_and_holds_plates_of_three_widths(mount, tmp_path):
    imported = mount(cup())
    model = loaded(imported, tmp_path)
    assert model.spec.gripper is None
    assert model.spec.suction.cup == model.spec.tcp.link == "cup"
    assert model.spec.tcp.position == pytest.approx((0.0, 0.0, 0.032), abs=1e-4)
    assert model.spec.tcp.pose.axis(2) == pytest.approx((0.0, 0.0, 1.0))
    # a vacuum of 50 kPa over a mouth of 30 mm
    assert model.spec.suction.force == pytest.approx(35.0, rel=0.05)
    assert any("What does the data sheet say?" in text for text in imported.proposal.remarks)
    trial = tried(model)
    assert trial.width == pytest.approx(0.03, abs=1e-3)
    assert all(grip.held and grip.slip < 1e-3 for grip in trial.grips)
    for grip in trial.grips:
        assert grip.load == pytest.approx(model.spec.suction.force, rel=0.2)
    assert judge(RobotTrial(None, (), trial), model) == ()


def test_the_axis_of_a_cup_is_the_way_from_its_flange(mount, tmp_path):
    model = loaded(mount(cup(), at="l6@0.05,0,0.05,0,90,0"), tmp_path)
    assert model.spec.tcp.pose.axis(2) == pytest.approx((0.0, 0.0, 1.0))
    assert all(grip.held for grip in tried(model).grips)


def test_a_part_that_is_called_nothing_is_a_cup_if_its_force_is_given(mount, tmp_path):
    nameless = cup("end").replace('"ejector"', '"block"')
    with pytest.raises(FileError, match=r"TB411.*no gripper.*--suction NEWTONS"):
        mount(nameless, name="thing")
    imported = mount(nameless, name="thing", suction=12.0)
    model = loaded(imported, tmp_path)
    assert model.spec.suction.force == 12.0
    assert not any("data sheet" in text for text in imported.proposal.remarks)
    assert max(grip.load for grip in tried(model).grips) == pytest.approx(12.0, rel=0.3)


def test_an_arm_that_ends_in_a_cup_in_its_own_file(write, tmp_path):
    text = arm() + cup() + joint("bolts", "l6", "ejector", kind="fixed", extra="")
    assert loaded(import_robot(ImportSource(write(text))), tmp_path).spec.suction.cup == "cup"


@pytest.mark.parametrize(
    ("position", "said"),
    [
        ("0.02", r"TB445.*cup reaches 10 mm beyond it"),
        ("0.06", r"TB445.*cup ends 30 mm before it"),
    ],
    ids=["in the cup", "far before it"],
)
def test_a_tcp_that_is_not_at_the_mouth(mount, tmp_path, position, said):
    imported = mount(cup())
    text = imported.files["robot.yaml"].decode().replace("0, 0, 0.032]", f"0, 0, {position}]")
    files = {**imported.files, "robot.yaml": text.encode()}
    write_folder(tmp_path / imported.name, files, overwrite=True)
    model = load_robot(CatalogueEntry(imported.name, tmp_path / imported.name / "robot.yaml"))
    assert model.spec.tcp.position[2] == float(position)
    (finding,) = judge(RobotTrial(None, (), tried(model)), model)
    assert re.search(said, f"{finding.code} {finding.path}: {finding.message}")


def test_a_cup_too_weak_for_the_plate_is_told_to_be_stronger(mount, tmp_path):
    model = loaded(mount(cup(), suction=0.5), tmp_path)
    (finding,) = judge(RobotTrial(None, (), tried(model)), model)
    assert finding.code == "TB440"
    assert "raise force from 0.5" in finding.message
