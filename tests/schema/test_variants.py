"""Variations, randomisation and instructions: the plain scene with some of its values changed."""

from __future__ import annotations

import pytest
from task_texts import CABINET, TETRAHEDRON

from taskbuilder.errors import UnknownNameError
from taskbuilder.schema.instructions import fill

ROBOT = "left: {model: ur5e, base: {position: [-0.8, 0, 0.4]}}"


def vary(change):
    return ("expert:", f"variations:\n  - {{cube.color: blue}}\n  - {change}\nexpert:")


def randomize(change):
    return ("expert:", f"randomize: {change}\nexpert:")


@pytest.mark.parametrize(
    "change",
    [
        "{cube.color: green}",
        "{cube.mass: 0.2, table.color: wood}",
        "{cube.place.center: [0, 0]}",
        "{cube.place: {surface: table, center: [0, 0], size: [0, 0]}}",
        "{goal.marker: {box: [1, 1, 1]}}",
        "{goal.in: table}",
        "{left.base.position: [-0.7, 0, 0.4]}",
        "{left.home: {joints_deg: [0, -90, 90, -90, -90, 0]}}",
        "{front.fov_deg: 70}",
    ],
)
def test_a_variation_may_change_any_value_of_any_thing(load, change):
    task = load(vary(change))
    assert len(task.scenes) == 3
    assert task.scenes[0] == task.spec.scene
    assert task.scenes[1].objects["cube"].color == "blue"
    assert task.scenes[2] != task.spec.scene


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            "{cub.color: green}",
            '27:6: error[TB205] variations[1].cub.color: the scene has no "cub"; '
            'did you mean "cube"?',
        ),
        (
            "{cube: green}",
            '27:6: error[TB205] variations[1].cube: "cube" names no value; '
            "write thing.key, such as stick.color",
        ),
        (
            "{cube.colour: green}",
            '27:19: error[TB102] variations[1].cube.colour: unknown key; did you mean "color"?',
        ),
        ("{cube.mass: 0.2, cube.color: greeen}", "27:34: error[TB108] variations[1].cube.color: "),
        (
            "{cube.place.surface: tabel}",
            "27:26: error[TB201] variations[1].cube.place.surface: "
            'the scene has no "tabel"; did you mean "table"?',
        ),
        (
            "{goal.in: goal}",
            "27:15: error[TB203] variations[1].goal.in: runs in a circle: goal in goal",
        ),
        (
            "{left.model: panda}",
            "27:5: error[TB205] variations[1]: names another model, mesh or urdf; "
            "a variation changes values, not files",
        ),
        (
            "{left.home: {joints_deg: [1, 2]}}",
            "27:5: error[TB302] variations[1]: scene.robots.left.home.joints_deg: "
            "has 2 values; ur5e has 6 arm joints",
        ),
        (
            "{left.home: {joints_deg: [0, 0, 0, 0, 0, 1000]}}",
            "27:5: error[TB302] variations[1]: scene.robots.left.home.joints_deg[5]: ",
        ),
        ("7", "27:5: error[TB103] variations[1]: is 7; a mapping of names is needed"),
        ("{}", "27:5: error[TB104] variations[1]: is empty; at least one is needed"),
    ],
)
def test_a_wrong_variation_is_marked_where_it_stands(findings, change, message):
    (found,) = findings(vary(change))
    assert found.startswith(message)


def test_what_is_wrong_with_the_plain_scene_is_not_told_again_for_each_variation(findings):
    found = findings(vary("{cube.color: green}"), ("surface: table", "surface: tabel"))
    assert found == [
        '16:24: error[TB201] scene.objects.cube.place.surface: the scene has no "tabel"; '
        'did you mean "table"?'
    ]


@pytest.mark.parametrize(
    "change",
    [
        "{cube.mass: {uniform: [0.05, 0.2]}}",
        "{cube.friction: {uniform: [0, 1]}}",
        "{cube.rolling_friction: {choice: [0, 0.1]}}",
        "{cube.restitution: {choice: [0.5]}}",
        "{cube.color: {choice: [red, '#123456', [0, 0, 1]]}}",
        "{goal.color: {choice: [red, blue]}}",
        "{left.gains: {uniform: [0.7, 1.3]}}",
        "{left.gains: {choice: [1, 2]}}",
        "{left.delay: {choice: [0, 1, 2]}}",
    ],
)
def test_looks_and_dynamics_can_be_randomised(findings, change):
    assert not findings(randomize(change))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            "{left.gains: {uniform: [0, 1]}}",
            "25:25: error[TB205] randomize.left.gains: 0.0 is no factor for gains; above 0 to 2",
        ),
        (
            "{left.gains: {choice: [fast]}}",
            "25:25: error[TB205] randomize.left.gains: 'fast' is no factor for gains; above 0 to 2",
        ),
        (
            "{left.delay: {uniform: [0, 2]}}",
            "25:25: error[TB205] randomize.left.delay: a delay is a whole number of control steps; "
            "write choice: [0, 1, 2]",
        ),
        (
            "{left.delay: {choice: [0, 1.5]}}",
            "25:25: error[TB205] randomize.left.delay: 1.5 is no delay; a whole number of control "
            "steps, 0 to 50",
        ),
        (
            "{left.delai: {choice: [0, 1]}}",
            '25:13: error[TB205] randomize.left.delai: "left.delai" cannot be randomised; '
            'did you mean "delay"?',
        ),
        (
            "{cube.mas: {uniform: [1, 2]}}",
            '25:13: error[TB205] randomize.cube.mas: "cube.mas" cannot be randomised; '
            'did you mean "mass"?',
        ),
        (
            "{cube.place.center: {choice: [[0, 0]]}}",
            '25:13: error[TB205] randomize.cube.place.center: "cube.place.center" cannot be '
            "randomised; of cube, these can: mass, friction, rolling_friction, restitution, color",
        ),
        (
            "{goal.mass: {uniform: [1, 2]}}",
            '25:13: error[TB205] randomize.goal.mass: "goal.mass" cannot be randomised; '
            "of goal, these can: color",
        ),
        (
            "{left.base.position: {choice: [[0, 0, 0]]}}",
            '25:13: error[TB205] randomize.left.base.position: "left.base.position" cannot be '
            "randomised; of left, these can: gains, delay",
        ),
        (
            "{front.fov_deg: {uniform: [40, 60]}}",
            '25:13: error[TB205] randomize.front.fov_deg: "front.fov_deg" cannot be randomised; '
            "only what objects, sites and robots have can be",
        ),
        (
            "{cub.mass: {uniform: [1, 2]}}",
            '25:13: error[TB205] randomize.cub.mass: the scene has no "cub"; did you mean "cube"?',
        ),
        ("{cube: {uniform: [1, 2]}}", '25:13: error[TB205] randomize.cube: "cube" names no value'),
        (
            "{cube.mass: {uniform: [-1, 2]}}",
            "25:24: error[TB104] randomize.cube.mass: is -1.0; must be at least 0.0001",
        ),
        (
            "{cube.mass: {uniform: [2, 1]}}",
            "25:24: error[TB106] randomize.cube.mass: uniform is [least, greatest]; swap them",
        ),
        ("{cube.color: {choice: [red, rde]}}", "25:25: error[TB108] randomize.cube.color: no such"),
        (
            "{cube.mass: {}}",
            "25:24: error[TB106] randomize.cube.mass: give exactly one of uniform, choice",
        ),
    ],
)
def test_what_cannot_be_randomised_is_refused(findings, change, message):
    (found,) = findings(randomize(change))
    assert found.startswith(message)


@pytest.mark.parametrize(
    ("instruction", "filled"),
    [
        ("take the {cube.color} cube", "take the red cube"),
        ("{cube.mass} kg by {left.model}", "0.1 kg by ur5e"),
        ("{goal.color} goal", "green goal"),
        ("no {{fields}}", "no {fields}"),
    ],
)
def test_an_instruction_is_filled_in_from_the_scene(load, instruction, filled):
    assert fill(instruction, load().spec.scene) == filled


@pytest.mark.parametrize(
    ("instruction", "problem"),
    [
        ("{cub.color}", '"{cub.color}" is no value; did you mean "cube.color"?'),
        ("{cube.colour}", '"{cube.colour}" is no value; did you mean "cube.color"?'),
        ("{cube}", '"{cube}" is no value; try: table.color'),
        ("{}", '"{}" is no value; try: table.color, cube.color, goal.color, meeting.color'),
        ("{cube.shape}", '"{cube.shape}" is no value; try: table.color'),
        ("{cube.fixed}", '"{cube.fixed}" is no value; '),
        ("{cube.model_fields}", '"{cube.model_fields}" is no value; '),
        ("{cube.__class__}", '"{cube.__class__}" is no value; '),
        ("{cube.color", "expected '}' before end of string"),
        ("cube}", "Single '}' encountered in format string"),
    ],
)
def test_an_instruction_of_unknown_fields_is_refused(findings, instruction, problem):
    (found,) = findings(('"take the {cube.color} cube"', f'"{instruction}"'))
    assert found.startswith(f"3:16: error[TB205] instructions[0]: {problem}")


def test_an_instruction_must_be_sayable_of_every_variation(findings):
    assert not findings(vary("{cube.color: [1, 0, 0]}"))  # which is "red"


def test_filling_in_what_is_not_there_names_what_is(load):
    with pytest.raises(UnknownNameError, match=r'"\{cup.color\}" is no value; did you mean'):
        fill("the {cup.color} cup", load().spec.scene)


@pytest.fixture
def cabinet(folder):
    (folder / "cabinet.urdf").write_text(CABINET)
    (folder / "pebble.obj").write_text(TETRAHEDRON)
    thing = "cabinet: {shape: {urdf: cabinet.urdf}, fixed: true, position: [0, 1, 0], joints: {}}"
    return lambda joints: ("  sites:", f"    {thing.replace('joints: {}', joints)}\n  sites:")


def test_joint_values_are_checked_against_the_urdf(findings, cabinet):
    assert not findings(cabinet("joints: {slide: 0.3, hinge: 90}"))
    assert findings(cabinet("joints: {slid: 0.1, hinge: 100}")) == [
        '17:87: error[TB301] scene.objects.cabinet.joints.slid: the URDF has no joint "slid" that '
        'moves; did you mean "slide"?',
        "17:105: error[TB302] scene.objects.cabinet.joints.hinge: 100° is beyond the limits of "
        "hinge; from 0° to 91.67°",
    ]


def test_joint_values_of_variations_are_checked_too(findings, cabinet):
    (found,) = findings(cabinet("joints: {}"), vary("{cabinet.joints: {slide: 0.5}}"))
    assert "error[TB302] variations[1]: scene.objects.cabinet.joints.slide: 0.5 m is bey" in found


def test_joint_values_of_a_scaled_urdf_are_checked_as_it_is_built(findings, cabinet):
    half = ("urdf: cabinet.urdf}", "urdf: cabinet.urdf, scale: 0.5}")
    (found,) = findings(cabinet("joints: {slide: 0.2, hinge: 90}"), half)
    assert "0.2 m is beyond the limits of slide; from 0 m to 0.15 m" in found


HERE = "scene.objects.cabinet.joints"


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        (
            "{slid: {start: 0.1}}",
            f'error[TB301] {HERE}.slid: the URDF has no joint "slid" that moves; did you mean',
        ),
        (
            "{slide: {strat: 0.1}}",
            f'error[TB102] {HERE}.slide.strat: unknown key; did you mean "st',
        ),
        ("{slide: {damping: -1}}", f"error[TB104] {HERE}.slide.damping: is -1; must be at least 0"),
        ("{slide: {friction: -1}}", f"error[TB104] {HERE}.slide.friction: is -1; must be at le"),
        ("{slide: open}", f'error[TB103] {HERE}.slide: is the text "open"; a mapping is needed'),
        ("{slide: {start: 3 cm}}", f'error[TB103] {HERE}.slide.start: is the text "3 cm"; a num'),
        (
            "{slide: {start_deg: 10}}",
            f"error[TB110] {HERE}.slide.start_deg: slide slides; write start, in metres",
        ),
        (
            "{hinge: {limits: [0, 0.5]}}",
            f"error[TB110] {HERE}.hinge.limits: hinge turns; write limits_deg, in degrees",
        ),
        (
            "{hinge: {spring: {stiffness: 1, rest: 0.5}}}",
            f"error[TB110] {HERE}.hinge.spring.rest: hinge turns; write rest_deg, in degrees",
        ),
        (
            "{hinge: {start: 0.1, start_deg: 5}}",
            f"error[TB106] {HERE}.hinge: start is for a prismatic joint and start_deg for a revo",
        ),
        (
            "{hinge: {start_deg: 10, start_range_deg: [0, 20]}}",
            f"error[TB106] {HERE}.hinge: it has both a start and a range of starts; keep one",
        ),
        (
            "{hinge: {start_range_deg: [20, 0]}}",
            f"error[TB106] {HERE}.hinge: start_range_deg is [least, greatest]; swap them",
        ),
        (
            "{slide: {start_range_deg: [0, 20]}}",
            f"error[TB110] {HERE}.slide.start_range_deg: slide slides; write start_range, in met",
        ),
        (
            "{slide: {start_range: [0, 0.4]}}",
            f"error[TB302] {HERE}.slide.start_range: 0.4 m is beyond the limits of slide; from 0",
        ),
        (
            "{sl*t: {damping: 1}}",
            f'error[TB301] {HERE}.sl*t: the URDF has no joint "sl*t" that moves',
        ),
        (
            "{sl*: {start_deg: 10}}",
            f"error[TB110] {HERE}.sl*.start_deg: slide slides; write start, in metres",
        ),
        (
            "{slide: {limits: [0.2, 0.1]}}",
            f"error[TB106] {HERE}.slide: limits is [least, greatest]; swap them",
        ),
        (
            "{slide: {limits: [0, 0.4]}}",
            f"error[TB302] {HERE}.slide.limits: 0.4 m is beyond the limits of slide; from 0",
        ),
        (
            "{slide: {start: 0.2, limits: [0, 0.1]}}",
            f"error[TB302] {HERE}.slide.start: 0.2 m is beyond the limits of slide; from 0",
        ),
        (
            "{hinge: {limits_deg: [10, 20]}}",
            f"error[TB302] {HERE}.hinge.limits_deg: it starts at 0, and 0° is beyond the limits of "
            "hinge; from 10° to 20°; write start_deg",
        ),
        (
            "{slide: {spring: {rest: 0}}}",
            f"error[TB101] {HERE}.slide.spring.stiffness: missing; in N/m, or N m/rad",
        ),
    ],
)
def test_what_is_wrong_with_a_joint_is_marked_where_it_stands(findings, cabinet, joints, message):
    (found,) = findings(cabinet(f"joints: {joints}"))
    assert found.startswith("17:")
    assert message in found


def test_a_joint_may_say_all_there_is(findings, cabinet):
    said = "limits: [0, 0.1], start: 0.1, spring: {stiffness: 9, rest: -1}, damping: 2, friction: 0"
    assert not findings(cabinet(f"joints: {{slide: {{{said}}}, hinge: {{start_deg: 90}}}}"))


@pytest.mark.parametrize(
    ("grasps", "message"),
    [
        (
            "{knob: {link: drawr}}",
            "17:100: error[TB301] scene.objects.cabinet.grasps.knob.link: the URDF has no link "
            '"drawr"; did you mean "drawer"?',
        ),
        (
            "{knob: {link: 3}}",
            "17:100: error[TB103] scene.objects.cabinet.grasps.knob.link: is 3; text is needed",
        ),
        (
            "{drawer: {at: [0.1, 0, 0]}}",
            '17:87: error[TB202] scene.objects.cabinet.grasps.drawer: "drawer" is also a link of '
            "cabinet; every name stands for one thing",
        ),
    ],
)
def test_the_link_of_a_grasp_point_is_checked(findings, cabinet, grasps, message):
    assert findings(cabinet(f"grasps: {grasps}")) == [message]


def test_a_grasp_point_of_what_is_no_urdf_has_no_link(findings):
    (found,) = findings(("{middle: {", "{middle: {link: cube, "))
    assert "error[TB106] scene.objects.cube.grasps.middle.link: cube is no URDF and has no" in found


@pytest.mark.parametrize(
    ("stage", "path", "meant"),
    [
        ("left: {reach: cabinet.drawr}", "expert[1].left.reach", "drawer"),
        ("left: {reach: cabinet.knbo}", "expert[1].left.reach", "knob"),
    ],
)
def test_a_misspelt_link_or_point_of_one_is_told_apart(findings, cabinet, stage, path, meant):
    (found,) = findings(
        cabinet("grasps: {knob: {link: drawer}}"), ("left: {bring: cube, to: goal}", stage)
    )
    assert f"error[TB201] {path}" in found
    assert f'did you mean "{meant}"?' in found


def test_an_unread_urdf_does_not_make_its_names_wrong(findings, cabinet, folder):
    (folder / "cabinet.urdf").write_text("<robot")
    found = findings(
        cabinet("joints: {slide: 0.1}"), ("[self.tcp, cube.pose]", "[cabinet.slide, cabinet.pose]")
    )
    assert [line.split()[1] for line in found] == ["error[TB410]"]


@pytest.mark.parametrize(
    ("shape", "code"),
    [
        ("{mesh: missing.obj}", "TB401"),
        ("{mesh: ../outside.obj}", "TB402"),
        ("{mesh: cabinet.urdf}", "TB405"),
    ],
)
def test_an_asset_that_cannot_be_used_is_marked_where_it_is_named(findings, cabinet, shape, code):
    (found,) = findings(("shape: {box: [0.05, 0.05, 0.05]}", f"shape: {shape}"))
    assert found.startswith(f"12:21: error[{code}] scene.objects.cube.shape.")


@pytest.mark.parametrize(
    ("model", "message"),
    [
        ("ur5", '7:19: error[TB009] scene.robots.left.model: no robot "ur5"; did you mean "ur5e"?'),
        ("./robot.yaml", "7:19: error[TB401] scene.robots.left.model: "),
        ("../robot.yaml", "7:19: error[TB402] scene.robots.left.model: "),
    ],
)
def test_a_robot_that_is_not_there_is_marked_where_it_is_named(findings, model, message):
    (found,) = findings(("left: {model: ur5e", f"left: {{model: {model}"))
    assert found.startswith(message)
