"""From a bare URDF to a robot file that works, by pasting what `robots check` proposes."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from taskbuilder import parallel_env
from taskbuilder.assets.urdf import read_urdf
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import play
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.robots import load_robot
from taskbuilder.world.hands import link_points
from taskbuilder.world.robot_proposal import propose

LINKS = (  # length of each link along z, and the axis of the joint that carries it
    (0.15, "0 0 1"),
    (0.40, "0 1 0"),
    (0.35, "0 1 0"),
    (0.08, "0 0 1"),
    (0.08, "0 1 0"),
    (0.06, "0 0 1"),
)

INERTIAL = """<inertial><origin xyz="0 0 {half}"/><mass value="{mass}"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>"""
SHAPE = """<{kind}><origin xyz="0 0 {half}"/><geometry><box size="{width} {width} {length}"/>
</geometry></{kind}>"""


def link(name: str, length: float, width: float = 0.06, mass: float = 1.0) -> str:
    values = {"half": length / 2, "length": length, "width": width, "mass": mass}
    shapes = "".join(SHAPE.format(kind=kind, **values) for kind in ("visual", "collision"))
    return f'<link name="{name}">{INERTIAL.format(**values)}{shapes}</link>\n'


def joint(name: str, parent: str, child: str, at: str, axis: str, kind: str, limits: str) -> str:
    limit = f'<limit {limits} effort="150" velocity="3"/>' if limits else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="{axis}"/>{limit}</joint>\n'
    )


def arm() -> str:
    """Six joints that turn; the last link is l6."""
    text = link("l0", 0.05, 0.15, 5.0)
    below = 0.05
    for number, (length, axis) in enumerate(LINKS, start=1):
        at = f"0 0 {below}"
        limits = 'lower="-2.9" upper="2.9"'
        text += link(f"l{number}", length)
        text += joint(f"j{number}", f"l{number - 1}", f"l{number}", at, axis, "revolute", limits)
        below = length
    return text


def fingers(axis: str = "1 0 0") -> str:
    """Two fingers that slide apart along x, one with limits the other way round."""
    text = ""
    for side, sign, limits in (
        ("a", 1, 'lower="0" upper="0.04"'),
        ("b", -1, 'lower="-0.04" upper="0"'),
    ):
        text += link(f"finger_{side}", 0.07, 0.012, 0.05)
        at = f"{0.006 * sign} 0 0.06"
        text += joint(f"slide_{side}", "l6", f"finger_{side}", at, axis, "prismatic", limits)
    return text


def turning_fingers(length: float = 0.08, turn: float = 0.5) -> str:
    text = ""
    for side, sign in (("a", 1), ("b", -1)):
        text += link(f"finger_{side}", length, 0.012, 0.05)
        limits = f'lower="0" upper="{turn}"'
        at, axis = f"{0.01 * sign} 0 0.06", f"0 {sign} 0"
        text += joint(f"turn_{side}", "l6", f"finger_{side}", at, axis, "revolute", limits)
    return text


@pytest.fixture
def urdf(tmp_path: Path) -> Callable[[str], Path]:
    def write(inside: str) -> Path:
        folder = tmp_path / "mine"
        folder.mkdir()
        file = folder / "arm.urdf"
        file.write_text(f'<robot name="arm">{inside}</robot>')
        return file

    return write


TASK = """\
task: lift
summary: A robot of one's own lifts a block.
timing: {episode_steps: 60}
scene:
  robots:
    arm: {model: mine/robot.yaml, base: {position: [0, 0, 0]}}
  objects:
    block:
      shape: {box: [0.04, 0.04, 0.04]}
      mass: 0.05
      position: [0.5, 0, 0.02]
      grasps: {middle: {across: y}}
expert:
  - arm: {grasp: block.middle}
  - arm: {bring: block, to: [0.45, 0, 0.2]}
"""
DESCRIPTION = """\
from taskbuilder.description import Above, Bonus, Description


class Lift(Description):
    success = Above("block", height=0.1)
    reward = (Bonus("up", success, 1.0),)
"""


@pytest.mark.parametrize("hand", [fingers, pytest.param(turning_fingers, marks=pytest.mark.slow)])
def test_the_proposal_is_a_robot_that_grasps(hand, urdf, run, tmp_path):
    file = urdf(arm() + hand())
    data = run("robots", "check", str(file), "--json").data
    assert data["ok"], data["findings"]
    (file.parent / "robot.yaml").write_text(data["proposal"])
    assert run("robots", "check", "mine/robot.yaml", "--json").data["ok"]
    (tmp_path / "lift.yaml").write_text(TASK)
    (tmp_path / "lift.py").write_text(DESCRIPTION)
    with closing(parallel_env("lift.yaml")) as env, closing(Expert(env)) as expert:
        played = play(env, expert, 0)
    assert played.success, played.trouble


def test_the_tcp_of_fingers_that_swing_is_where_they_meet(urdf):
    file = urdf(arm() + turning_fingers(0.11, 1.3))  # the tips come out by 80 mm
    model = read_urdf(file, [file.parent])
    proposal = propose(model)
    opened, closed = (
        [link_points(model, proposal.tcp_link, finger, at)[:, 2] for (finger,) in proposal.fingers]
        for at in (
            {name: ends[number] for name, ends in proposal.gripper.items()} for number in (0, 1)
        )
    )
    tcp = proposal.tcp.position[2]
    assert max(map(np.max, opened)) < tcp
    assert all(finger.min() < tcp < finger.max() for finger in closed)


def jaw() -> str:
    """One jaw that turns beside a fixed one."""
    text = link("palm", 0.11, 0.012, 0.3) + link("jaw", 0.09, 0.012, 0.05)
    text += joint("roll", "l6", "palm", "0 0 0.06", "0 0 1", "revolute", 'lower="-2" upper="2"')
    limits = 'lower="0" upper="1.5"'
    return text + joint("gripper", "palm", "jaw", "0.013 0 0.02", "0 1 0", "revolute", limits)


def test_a_jaw_that_closes_on_a_fixed_one_holds_things(urdf, run, tmp_path):
    data = run("robots", "check", str(urdf(arm() + jaw())), "--json").data
    assert data["ok"], data["findings"]
    (tmp_path / "mine" / "robot.yaml").write_text(data["proposal"])
    written = yaml.safe_load(data["proposal"])
    assert written["arm"] == [*(f"j{number}" for number in range(1, 7)), "roll"]
    assert written["gripper"]["fingers"] == [["jaw"], ["palm"]]
    (tmp_path / "lift.yaml").write_text(TASK)
    (tmp_path / "lift.py").write_text(DESCRIPTION)
    with closing(parallel_env("lift.yaml")) as env, closing(Expert(env)) as expert:
        played = play(env, expert, 0)
    assert played.success, played.trouble


def test_what_is_printed_is_what_is_to_be_pasted(urdf, run):
    file = urdf(arm() + fingers())
    ran = run("robots", "check", str(file), "--out", "arm.png")
    proposal = run("robots", "check", str(file), "--json").data["proposal"]
    assert proposal in ran.out
    assert "proposal for mine/robot.yaml" in ran.out
    written = yaml.safe_load(proposal)
    assert written["arm"] == [f"j{number}" for number in range(1, 7)]
    assert written["gripper"]["joints"] == {
        "slide_a": {"open": 0.04, "closed": 0},
        "slide_b": {"open": -0.04, "closed": 0},
    }
    assert written["gripper"]["stroke"] == pytest.approx(0.08, abs=1e-3)
    assert ran.out.splitlines()[-3:] == ["ok", "arm.png", "arm-reach.png"]


def test_the_reach_is_a_figure_of_its_own(urdf, run):
    file = urdf(arm() + fingers())
    data = run("robots", "check", str(file), "--json").data
    picture, reach = cv2.imread(data["picture"]), cv2.imread(data["reach"])
    assert picture.shape == reach.shape == (480, 480, 3)
    assert (picture != reach).any()


def test_a_quick_check_sees_fingers_that_pass_through_everything(urdf, run):
    bare = re.sub("<collision>.*?</collision>", "", fingers(), flags=re.DOTALL)
    ran = run("robots", "check", str(urdf(arm() + bare)), "--quick")
    assert ran.status == 1
    assert ran.out.count("error[TB441]") == 2


@pytest.mark.parametrize(
    ("places", "said"),
    [
        ([], "on which link? --gripper needs --at"),
        (["--at", "l6"], "--gripper is given twice and --at once; write one --at for each"),
    ],
)
def test_every_gripper_and_adapter_needs_a_place(places, said, urdf, run):
    pytest.importorskip("trimesh")
    file = str(urdf(arm()))
    ran = run("robots", "import", file, "--gripper", file, "--gripper", file, *places)
    assert ran.status == 2
    assert said in " ".join(ran.err.split())


def test_a_robot_without_a_gripper_is_said_to_have_none(urdf, run):
    file = urdf(
        arm() + link("tool0", 0.02) + joint("fix", "l6", "tool0", "0 0 0.06", "0 0 1", "fixed", "")
    )
    ran = run("robots", "check", str(file))
    assert ran.status == 0
    assert "no gripper was found" in ran.out
    assert "tcp: {link: tool0}" in ran.out
    assert "gripper:" not in ran.out


def test_of_two_arms_one_is_proposed_and_the_other_asked_about(urdf, run):
    second = (
        arm().replace('name="j', 'name="k').replace('"l', '"m').replace('name="m0"', 'name="x"')
    )
    both = link("root", 0.1)
    both += arm() + joint("left", "root", "l0", "0 0.5 0", "0 0 1", "fixed", "")
    both += second.replace('name="x"', 'name="m0"')
    both += joint("right", "root", "m0", "0 -0.5 0", "0 0 1", "fixed", "")
    ran = run("robots", "check", str(urdf(both)))
    words = " ".join(ran.out.replace("#", "").split())
    assert "several arms begin on root; this is the one from l0 on" in words
    assert "--arm m0" in words
    assert "arm: [j1, j2, j3, j4, j5, j6]" in ran.out


@pytest.mark.parametrize("name", sorted(Catalogue.discover().robots))
def test_the_robots_of_the_library_are_found_out(name):
    robot = load_robot(Catalogue.discover().robots[name])
    proposal = propose(robot.urdf)
    assert tuple(joint.name for joint in proposal.arm) == robot.spec.arm
    fixed = {j.child: j.parent for j in robot.urdf.joints if j.type == "fixed"}
    tcp = robot.spec.tcp.link
    assert proposal.tcp_link in (tcp, fixed.get(tcp))  # a link for the tcp alone, or its parent
    if robot.spec.gripper is None:
        assert not proposal.gripper
        return
    found = {link for finger in proposal.fingers for link in finger}
    assert found == {link for finger in robot.spec.gripper.fingers for link in finger}
    one_jaw = len(robot.spec.gripper.joints) == 1
    for key, ends in robot.spec.gripper.joints.items():
        # Where fingers touch is measured; how far a jaw that turns opens, its robot file decides.
        span = abs(ends.closed - ends.open)
        within = (0.2 if one_jaw else 0.05) * span
        assert proposal.gripper[key] == pytest.approx((ends.open, ends.closed), abs=within)
    assert proposal.stroke == pytest.approx(
        robot.spec.gripper.stroke, abs=1e-2 if one_jaw else 5e-3
    )
