"""Joints are moved by their handles, and buttons pressed, on real physics."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import pytest
from written_experts import DESCRIPTION, RIGHT, made

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
VALVE_URDF = """<robot name="valve">
  <link name="pipe"><inertial><mass value="2"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="wheel"><inertial><mass value="0.2"/>
    <inertia ixx="4e-4" iyy="2e-4" izz="4e-4" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.14 0.022 0.04"/></geometry></collision></link>
  <joint name="spin" type="revolute"><parent link="pipe"/><child link="wheel"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="3" effort="20" velocity="5"/></joint>
</robot>
"""
VALVE = """\
    valve:
      shape: {urdf: valve.urdf}
      position: [-0.1, -0.15, 0.5]
      fixed: true
      joints: {spin: {friction: 0.15, LOCK}}
      grasps: {bar: {link: wheel, across: y}}
"""
STUCK, LOOSE = VALVE.replace("LOCK", "lock: {unless: near}"), VALVE.replace(", LOCK", "")
BAR = "arm: {grasp: valve.bar}"
HANDLE = "arm: {grasp: chest.grip}"
KNOB = "arm: {grasp: cabinet.knob}"


@pytest.fixture
def begin(tmp_path):
    """An environment with the given stages, and its expert."""
    experts = []
    for file in URDFS.glob("*.urdf"):
        shutil.copy(file, tmp_path)
    (tmp_path / "valve.urdf").write_text(VALVE_URDF, encoding="utf-8")

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


@pytest.mark.parametrize(
    "tolerance", ["", ", tolerance: 0.005", ", tolerance: 0.02", ", tolerance_deg: 80"]
)
def test_a_joint_that_has_not_turned_has_not_arrived(play, tolerance):
    """The handle is on the axis: however far the joint must turn, the handle stays where it is."""
    turn = f"arm: {{turn: valve.spin, to_deg: 70{tolerance}}}"
    demonstration, world = play(BAR, turn, objects=STUCK)
    assert demonstration.trouble.cause == "not arrived"
    assert demonstration.trouble.message.endswith('valve.spin is locked unless "near" holds')
    assert "0.0 cm" not in demonstration.trouble.message
    assert abs(math.degrees(world.joint("valve.spin"))) < 0.5


@pytest.mark.parametrize("to", [0.015, 0.1])
def test_a_joint_that_has_not_slid_has_not_arrived(play, to):
    stuck = CABINET + "      joints: {runner: {lock: {unless: near}}}\n"
    out = f"arm: {{slide: cabinet.runner, to: {to}, tolerance: 0.1}}"
    demonstration, world = play(KNOB, out, objects=stuck)
    assert demonstration.trouble.cause in ("not arrived", "lost on the way")
    assert abs(world.joint("cabinet.runner")) < 0.001


@pytest.mark.parametrize("order", ["to: 0.0015", "depth: 0.001", "to: 0.004, tolerance: 0.02"])
def test_a_joint_that_is_not_pressed_down_has_not_arrived(play, order):
    stuck = BUTTON.replace("{press: {", "{press: {lock: {unless: near}, ")
    demonstration, world = play(f"arm: {{press: button, {order}}}", objects=stuck)
    assert demonstration.trouble.cause == "not arrived"
    assert abs(world.joint("button.press")) < 0.001


@pytest.mark.parametrize("tolerance", [2, 5])
def test_a_turn_arrives_within_its_tolerance_in_degrees(play, tolerance):
    turn = f"arm: {{turn: valve.spin, to_deg: 60, tolerance_deg: {tolerance}}}"
    demonstration, world = play(BAR, turn, objects=LOOSE)
    assert demonstration.trouble is None
    assert abs(math.degrees(world.joint("valve.spin")) - 60) <= tolerance


HALF = f"""{DESCRIPTION.replace(" Held, Near", " Held, JointAngle, JointPosition, Near")}
    half = JointAngle("chest.hinge", above_deg=40)
"""
OUT = HALF.replace(
    'JointAngle("chest.hinge", above_deg=40)', 'JointPosition("cabinet.runner", above=0.06)'
)
UNTIL = "turn: chest.hinge, to_deg: 80, turn_tool: false, speed: 0.5, until: half"


def test_a_turn_stops_when_its_condition_becomes_true(play):
    stages = HANDLE, f"arm: {{{UNTIL}}}", "arm: release"
    demonstration, world = play(*stages, objects=CHEST, description=HALF)
    assert demonstration.trouble is None
    assert len(demonstration.stage_ends) == 3
    assert 38 < math.degrees(world.joint("chest.hinge")) < 55


def test_a_slide_stops_when_its_condition_becomes_true(play):
    stages = KNOB, "arm: {slide: cabinet.runner, to: 0.14, speed: 0.3, until: half}"
    demonstration, world = play(*stages, objects=CABINET, description=OUT)
    assert demonstration.trouble is None
    assert 0.06 <= world.joint("cabinet.runner") < 0.09


def test_a_turn_whose_condition_never_becomes_true_is_not_done(play):
    turn = f"arm: {{{UNTIL.replace('80', '30')}}}"
    demonstration, world = play(HANDLE, turn, objects=CHEST, description=HALF)
    assert demonstration.trouble.cause == "not arrived"
    assert '"half" does not hold' in demonstration.trouble.message
    assert math.degrees(world.joint("chest.hinge")) == pytest.approx(30, abs=5)


def test_a_turn_whose_condition_holds_already_does_not_move(play):
    stages = HANDLE, f"arm: {{{UNTIL}}}", f"arm: {{{UNTIL}}}"
    demonstration, _ = play(*stages, objects=CHEST, description=HALF)
    assert demonstration.trouble is None
    assert demonstration.stage_ends[2] == demonstration.stage_ends[1]


def test_others_go_on_when_one_stops(play):
    both = f"{{arm: {{{UNTIL}}}, right: {{reach: [0.4, 0.3, 0.6]}}}}"
    demonstration, world = play(HANDLE, both, objects=CHEST, description=HALF, robots=RIGHT)
    assert demonstration.trouble is None
    assert math.dist(world.position("right.tcp"), (0.4, 0.3, 0.6)) < 0.01
    assert 38 < math.degrees(world.joint("chest.hinge")) < 55


def test_a_condition_that_an_order_names_must_be_there(said):
    turn = "arm: {turn: chest.hinge, to_deg: 70, until: haf}"
    assert said(turn, objects=CHEST, description=HALF) == [
        'TB214 expert[0].arm.until: "haf" is no condition; did you mean "half"?'
    ]


def test_a_tolerance_is_in_metres_or_in_degrees(said):
    turn = "arm: {turn: chest.hinge, to_deg: 70, tolerance: 0.01, tolerance_deg: 3}"
    assert said(turn, objects=CHEST) == [
        "TB106 expert[0].arm: turn has tolerance, in metres, and tolerance_deg, in degrees; give "
        "one of them"
    ]


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
