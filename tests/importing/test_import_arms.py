"""Bodies with several arms: each arm becomes a robot, and together they form the body."""

from __future__ import annotations

import json

import numpy as np
import pytest
from made_robots import BOX, INERTIAL, arm, joint, link, two_fingers

from taskbuilder.assets.urdf import read_urdf
from taskbuilder.cli import main
from taskbuilder.errors import FileError
from taskbuilder.importing.arms import import_arms
from taskbuilder.importing.folders import ImportSource, import_robot
from taskbuilder.importing.writing import write_folder
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.load import read_task
from taskbuilder.schema.robots import load_robot
from taskbuilder.sim.contacts import closest_distance
from taskbuilder.world.arm_branches import arms_of_body
from taskbuilder.world.building import build_world
from taskbuilder.world.hands import link_pose

TORSO = '<box size="0.2 0.3 0.5"/>'


def an_arm(side: str, sign: int) -> str:
    """Six joints with fingers on the torso, under names of their own; the shoulder is in it."""
    text = arm() + two_fingers()
    for name in [*(f"l{n}" for n in range(7)), *(f"j{n}" for n in range(1, 7))]:
        text = text.replace(f'"{name}"', f'"{side}_{name}"')
    for name in ("finger_", "pad_", "slide_", "glue_"):
        text = text.replace(f'"{name}', f'"{side}_{name}')
    mount = joint(
        f"{side}_mount", "torso", f"{side}_l0", f"0.08 {0.12 * sign} 0.1", kind="fixed", extra=""
    )
    return text + mount


def body(lift: bool = True) -> str:
    """A torso that is lifted, with a head and two arms."""
    kind, limit = ("prismatic", '<limit lower="0" upper="0.3" effort="900" velocity="0.1"/>')
    text = link("wheels", '<box size="0.4 0.4 0.1"/>') + link("torso", TORSO)
    text += joint(
        "lift", "wheels", "torso", "0 0 0.3", "0 0 1", kind if lift else "fixed", limit * lift
    )
    text += link("head", '<box size="0.1 0.1 0.1"/>')
    text += joint("pan", "torso", "head", "0 0 0.4", "0 0 1")
    return text + an_arm("left", 1) + an_arm("right", -1)


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("arms")


@pytest.fixture(scope="module")
def arms(home):
    """Both arms, written."""
    file = home / "urdf" / "body.urdf"
    file.parent.mkdir()
    file.write_text(f'<robot name="my_arm">{body()}</robot>')
    imported = import_arms(ImportSource(file))
    for robot in imported.robots.values():
        write_folder(home / "robots" / robot.name, robot.files, overwrite=False)
    return imported


def loaded(robot, home):
    return load_robot(CatalogueEntry(robot.name, home / "robots" / robot.name / "robot.yaml"))


def rows(robot, what):
    return {row.subject: row for row in robot.changes.rows if row.what == what}


def test_each_arm_is_a_robot_of_its_own_joints(arms, home):
    assert list(arms.robots) == ["left", "right"]
    assert [robot.name for robot in arms.robots.values()] == ["my_arm_left", "my_arm_right"]
    for side, robot in arms.robots.items():
        model = loaded(robot, home)
        assert [one.name for one in model.arm] == [f"{side}_j{n}" for n in range(1, 7)]
        assert set(model.spec.gripper.joints) == {f"{side}_slide_a", f"{side}_slide_b"}
        assert all(one.name.startswith(side) for one in model.urdf.moving_joints)


def test_the_first_arm_keeps_the_body_and_what_is_lost_is_in_the_table(arms, home):
    left, right = arms.robots.values()
    shapes = {
        robot.name: {one.name for one in loaded(robot, home).urdf.links if one.collisions}
        for robot in arms.robots.values()
    }
    assert {"torso", "wheels", "head"} <= shapes["my_arm_left"]
    assert not {"torso", "wheels", "head"} & shapes["my_arm_right"]
    for robot in (left, right):
        assert "robots share no joint" in rows(robot, "type")["joint lift"].reason
    assert "robot my_arm_right" in rows(left, "left out")["arm right"].reason
    assert "robot my_arm_left" in rows(right, "left out")["arm left"].reason
    assert "robot my_arm_left" in rows(right, "left out")["body"].reason
    assert "always in the body" in rows(right, "collision")["link right_l1"].reason
    assert not any(row.subject.startswith("link left") for row in right.changes.rows)
    assert "my_arm_right belongs to it" in left.files["robot.yaml"].decode().replace("\n#  ", "")


def test_the_arms_are_where_they_are_in_the_body(arms, home, write):
    urdf = read_urdf(write(body()), (), fixed=True)
    for side, robot in arms.robots.items():
        own = loaded(robot, home).urdf
        for name in (f"{side}_l0", f"{side}_l6"):
            expected = link_pose(urdf, urdf.root, name, {})
            assert link_pose(own, own.root, name, {}).position == pytest.approx(expected.position)


def test_two_agents_of_one_body_stand_still_beside_each_other(arms, home):
    entries = "".join(
        f"    {side}: {{model: robots/{robot.name}/robot.yaml, "
        f"base: {{position: [0, 0, {arms.height}]}}}}\n"
        for side, robot in arms.robots.items()
    )
    file = home / "pair.yaml"
    file.write_text(f"task: pair\nsummary: Two arms.\nscene:\n  robots:\n{entries}")
    world = build_world(read_task(CatalogueEntry("pair", file), Catalogue.discover()))
    try:
        world.reset(0)
        left, right = world.robots.values()
        for _ in range(20):
            world.step()
        for robot in (left, right):
            np.testing.assert_allclose(robot.arm_state()[0], robot.home, atol=2e-3)
        apart = closest_distance(left.body, right.body, 0.05)
        assert apart is None or apart > 0.0
    finally:
        world.close()


def test_legs_and_heads_are_no_arms(write):
    legs = ""
    for side, sign in (("left", 1), ("right", -1)):
        above = "wheels"
        for number in range(1, 6):
            legs += link(f"{side}_leg{number}", BOX)
            place = f"0 {0.1 * sign} -0.1" if number == 1 else "0 0 -0.1"
            legs += joint(f"{side}_hip{number}", above, f"{side}_leg{number}", place)
            above = f"{side}_leg{number}"
    imported = read_urdf(write(body() + legs), (), fixed=True)
    assert [one.child for one in arms_of_body(imported)] == ["left_l0", "right_l0"]


def test_a_robot_with_one_arm_has_no_several(write):
    with pytest.raises(FileError, match=r"TB433.*no several arms; import it without --all-arms"):
        import_arms(ImportSource(write(arm() + two_fingers())))


def test_an_arm_that_is_not_there_is_no_choice(write):
    with pytest.raises(FileError, match=r'no link "left_l00".*did you mean "left_l0"'):
        import_robot(ImportSource(write(body()), arm="left_l00"))


def test_the_command_prints_the_lines_of_a_task(write, capfd):
    file = str(write(body()))
    assert main(["robots", "import", file, "--all-arms", "--quick", "--out", "robots/twin"]) == 0
    said = capfd.readouterr().out
    assert "left: {model: robots/twin_left/robot.yaml, base: {position: [0, 0, " in said
    assert "right: {model: robots/twin_right/robot.yaml, base: {position: [0, 0, " in said
    again = ["robots", "import", file, "--all-arms", "--quick", "--out", "robots/twin"]
    assert main([*again, "--overwrite", "--json"]) == 0
    data = json.loads(capfd.readouterr().out)
    assert list(data["robots"]) == list(data["scene"]["robots"]) == ["left", "right"]
    assert main([*again, "--overwrite", "--arm", "left_l0"]) == 2
    assert "give one of them" in capfd.readouterr().err


def a_hand(fingers: int = 4) -> str:
    """A hand of fingers with seven joints each, as people have."""
    small = INERTIAL.replace('value="1"', 'value="0.02"').replace("0.01", "1e-5")
    bone = '<box size="0.012 0.012 0.02"/>'
    text = ""
    for finger in range(fingers):
        above = "l6"
        for number in range(7):
            name = f"bone_{finger}_{number}"
            text += link(name, bone, inertial=small).replace("0 0 0.05", "0 0 0.01")
            place = f"{0.02 * finger - 0.03} 0 0.1" if number == 0 else "0 0 0.02"
            text += joint(f"bend_{finger}_{number}", above, name, place)
            above = name
    return text


def test_an_arm_ends_where_a_hand_of_many_joints_begins(write, tmp_path):
    imported = import_robot(ImportSource(write(arm() + a_hand())))
    assert [one.name for one in imported.proposal.arm] == [f"j{n}" for n in range(1, 7)]
    assert not imported.proposal.gripper
    (said,) = [remark for remark in imported.proposal.remarks if "hand of 28 joints" in remark]
    assert "--gripper FILE --at LINK" in said
    write_folder(tmp_path / "hand", imported.files, overwrite=False)
    urdf = read_urdf(tmp_path / "hand" / "my_arm.urdf", (tmp_path / "hand",), fixed=True)
    assert len(urdf.moving_joints) == 6
    assert arms_of_body(urdf) == ()
