"""Joints are moved by their handles, and buttons pressed, on real physics."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import pytest
from written_experts import made

from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import FileError
from taskbuilder.expert.script.dry_run import dry_run
from taskbuilder.expert.script.player import Expert
from taskbuilder.task import load_task

TASKS = Path(__file__).resolve().parents[2] / "tasks"
URDFS = Path(__file__).resolve().parents[1] / "proven_tasks"
CHEST = """\
    chest:
      shape: {urdf: lid_by_its_knob.urdf}
      position: [-0.05, -0.2, 0.401]
      rpy_deg: [0, 0, 90]
      fixed: true
      grasps: {grip: {at: [0.16, 0, 0.06], link: lid, across: y}}
"""
CABINET = """\
    cabinet:
      shape: {urdf: drawer_by_its_knob.urdf}
      position: [-0.05, -0.15, 0.401]
      fixed: true
      grasps: {knob: {at: [-0.09, -0.135, 0.05], link: drawer, across: x}}
"""
BUTTON = """\
    button:
      shape: {urdf: hatch_by_a_button.urdf}
      position: [-0.1, -0.2, 0.401]
      fixed: true
      joints: {press: {spring: {stiffness: 300, rest: -0.005}, damping: 2, friction: 0.2}}
"""
HANDLE = "arm: {grasp: chest.grip}"
KNOB = "arm: {grasp: cabinet.knob}"


@pytest.fixture
def begin(tmp_path):
    """An environment with the given stages, and its expert."""
    experts = []
    for file in URDFS.glob("*.urdf"):
        shutil.copy(file, tmp_path)

    def make(*stages, **scene):
        env = made(tmp_path, *stages, **scene)
        experts.append(Expert(env))
        return env, experts[-1]

    yield make
    for expert in experts:
        expert.close()
        expert.env.close()


@pytest.fixture
def play(begin):
    """Plays stages to their end and leaves the world as it is then."""

    def play_stages(*stages, **scene):
        env, expert = begin(*stages, **scene)
        return expert.play(0, finish=False), env.episode.world

    return play_stages


@pytest.fixture
def said(begin):
    """The findings of stages that are refused."""

    def findings(*stages, **scene):
        with pytest.raises(FileError) as caught:
            begin(*stages, **scene)
        return [f"{each.code} {each.path}: {each.message}" for each in caught.value.findings]

    return findings


@pytest.mark.parametrize("angle", [30, 75])
def test_a_lid_turns_to_its_angle_and_the_tool_stays_upright(play, angle):
    turn = f"arm: {{turn: chest.hinge, to_deg: {angle}, turn_tool: false}}"
    demonstration, world = play(HANDLE, turn, objects=CHEST)
    assert demonstration.trouble is None
    assert math.degrees(world.joint("chest.hinge")) == pytest.approx(angle, abs=5)
    assert world.pose("arm.tcp").axis(2)[2] < -0.99


def test_the_tool_turns_with_the_handle_if_its_actions_can(play):
    turn = "arm: {turn: chest.hinge, to_deg: 50}"
    demonstration, world = play(HANDLE, turn, objects=CHEST, action="turn: full")
    assert demonstration.trouble is None
    assert math.degrees(world.joint("chest.hinge")) == pytest.approx(50, abs=5)
    tilt = math.degrees(math.acos(-world.pose("arm.tcp").axis(2)[2]))
    assert tilt == pytest.approx(50, abs=4)
    refused, _ = play(HANDLE, turn, objects=CHEST)
    assert refused.trouble.cause == "out of reach"
    assert "turn_tool: false" in refused.trouble.message


@pytest.mark.parametrize("to", [0.05, 0.14])
def test_a_drawer_slides_to_its_position_and_back(play, to):
    out = f"arm: {{slide: cabinet.runner, to: {to}, speed: 0.5}}"
    demonstration, world = play(KNOB, out, objects=CABINET)
    assert demonstration.trouble is None
    assert world.joint("cabinet.runner") == pytest.approx(to, abs=0.02)
    demonstration, world = play(KNOB, out, "arm: {slide: cabinet.runner, to: 0}", objects=CABINET)
    assert demonstration.trouble is None
    assert world.joint("cabinet.runner") == pytest.approx(0.0, abs=0.02)


def test_a_joint_is_moved_by_its_handle_only(play):
    demonstration, _ = play("arm: {slide: cabinet.runner, to: 0.1}", objects=CABINET)
    assert demonstration.trouble.cause == "lost on the way"
    assert demonstration.trouble.message == (
        "arm holds no handle of cabinet.runner: it holds nothing"
    )
    grasp = "arm: {grasp: block.middle}"
    demonstration, _ = play(grasp, "arm: {slide: cabinet.runner, to: 0.1}", objects=CABINET)
    assert demonstration.trouble.message == "arm holds no handle of cabinet.runner: it holds block"


@pytest.mark.parametrize(
    ("scene", "handle", "order", "frame"),
    [
        (CHEST, HANDLE, "{turn: chest.hinge, to_deg: 60, turn_tool: false}", "chest.grip"),
        (CABINET, KNOB, "{slide: cabinet.runner, to: 0.1}", "cabinet.knob"),
        (BUTTON, "arm: {reach: spot}", "{press: button, to: 0.01}", "button.cap"),
    ],
)
def test_the_dry_run_foresees_where_a_joint_then_is(begin, scene, handle, order, frame):
    env, expert = begin(handle, f"arm: {order}", f"arm: {{reach: {frame}}}", objects=scene)
    env.reset(seed=0)
    (*_, last) = dry_run(env.episode.world)
    places = []
    expert.play(0, after_stage=lambda _: places.append(env.episode.world.position(frame)))
    assert last.guess == ""
    assert math.dist(last.choices[0].position, places[1]) < 0.02
    assert math.dist(places[0], places[1]) > 0.007


@pytest.mark.parametrize(
    ("order", "travel"), [("{press: button, to: 0.012}", 0.012), ("{press: button.cap}", 0.01)]
)
def test_a_button_is_pressed_and_stays_so(play, order, travel):
    demonstration, world = play(f"arm: {order}", objects=BUTTON)
    assert demonstration.trouble is None
    assert world.joint("button.press") == pytest.approx(travel, abs=0.003)
    assert world.robots["arm"].opening() < 0.1


def test_what_is_wrong_with_a_joint_is_said_before_anything_moves(said):
    assert said("arm: {turn: chest.hinge, to_deg: 120}", objects=CHEST) == [
        "TB302 expert[0].arm.to_deg: 120° is beyond the limits of hinge; from 0° to 108.9°"
    ]
    assert said("arm: {slide: cabinet.runner, to: 0.2}", objects=CABINET) == [
        "TB302 expert[0].arm.to: 0.2 m is beyond the limits of runner; from 0 m to 0.16 m"
    ]
    assert said("arm: {slide: chest.hinge, to: 0.2}", objects=CHEST) == [
        "TB110 expert[0].arm.slide: chest.hinge turns; write turn: chest.hinge, and to_deg in "
        "degrees"
    ]
    assert said("arm: {turn: cabinet.runner, to_deg: 20}", objects=CABINET) == [
        "TB110 expert[0].arm.turn: cabinet.runner slides; write slide: cabinet.runner, and to in "
        "metres"
    ]
    assert said("arm: {turn: chest.hinge, to: 70}", objects=CHEST) == [
        "TB106 expert[0].arm: turn and to_deg go together; turn takes degrees: "
        "{turn: chest.lid_hinge, to_deg: 70}"
    ]
    assert said("arm: {slide: cabinet.runner, to_deg: 20}", objects=CABINET) == [
        "TB106 expert[0].arm: slide and to go together; slide takes metres: "
        "{slide: cabinet.runner, to: 0.2}"
    ]
    assert said("arm: {turn: chest.hing, to_deg: 20}", objects=CHEST) == [
        'TB201 expert[0].arm.turn: "chest" has no joint "hing"; did you mean "hinge"?'
    ]
    assert said("arm: {turn: chest.stands_on_lid, to_deg: 20}", objects=CHEST) == [
        'TB201 expert[0].arm.turn: "chest.stands_on_lid" is fixed; joints that move: chest.hinge'
    ]
    assert said("arm: {press: button, to: 0.02}", objects=BUTTON) == [
        "TB302 expert[0].arm.to: 0.02 m is beyond the limits of press; from 0 m to 0.015 m"
    ]


def test_a_handle_stays_held_while_gripper_and_leaf_turn_together(tmp_path):
    """Bullet leaves the normals of a contact as they were when it began."""
    files = [*TASKS.glob("double_door.*"), TASKS / "objects" / "double_door_cabinet.urdf"]
    for file in files:
        made_of = file.read_text(encoding="utf-8")
        for said, instead in (("friction: 0.6", "friction: 1.2"), ("to_deg: 65", "to_deg: 75")):
            made_of = made_of.replace(said, instead)
        copied = tmp_path / file.relative_to(TASKS)
        copied.parent.mkdir(exist_ok=True)
        copied.write_text(made_of, encoding="utf-8")
    env = parallel_env(load_task(tmp_path / "double_door.yaml"))
    expert = Expert(env)
    rollout = expert.play(900_007)
    expert.close()
    env.close()
    assert rollout.success, rollout.log
