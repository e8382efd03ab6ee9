"""What is said of a task file whose shapes are wrong: the words, and the places."""

from __future__ import annotations

import pytest

LEFT = "left: {model: ur5e, base: {position: [-0.8, 0, 0.4]}}"
CUBE = "shape: {box: [0.05, 0.05, 0.05]}"
PALETTE = (
    "black, blue, brown, cyan, gray, green, lightgray, maroon, navy, olive, orange, pink, purple, "
    "red, silver, teal, white, wood, yellow"
)


def test_the_plain_task_has_no_findings(findings):
    assert findings() == []


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        # keys
        (
            "left: {model: ur5e, base",
            "left: {modle: ur5e, base",
            '7:12: error[TB102] scene.robots.left.modle: unknown key; did you mean "model"?',
        ),
        (
            "mass: 0.1",
            "mass: 0.1\n      MASS: 2",
            '14:7: error[TB102] scene.objects.cube.MASS: unknown key; did you mean "mass"?',
        ),
        (
            "sites:",
            "zzz: 1\n  sites:",
            "17:3: error[TB102] scene.zzz: unknown key; "
            "known keys: robots, objects, sites, cameras, floor",
        ),
        (
            "summary: Two arms and a cube.\n",
            "",
            "1:1: error[TB101] summary: missing; one sentence: who does what",
        ),
        (
            LEFT,
            "left: {base: {position: [-0.8, 0, 0.4]}}",
            "7:5: error[TB101] scene.robots.left.model: missing; "
            "a robot of the catalogue, or the path of a robot.yaml",
        ),
        (
            LEFT,
            "left: {model: ur5e}",
            "7:5: error[TB101] scene.robots.left.base: missing; "
            "pose of its base, such as {position: [0, 0, 0.4]}",
        ),
        # types
        (
            "mass: 0.1",
            'mass: "0.1"',
            '13:13: error[TB103] scene.objects.cube.mass: is the text "0.1"; '
            "a number is needed, without quotation marks",
        ),
        (
            "control_hz: 10,",
            "control_hz: 10.5,",
            "4:22: error[TB103] timing.control_hz: is 10.5; a whole number is needed",
        ),
        (
            "fixed: true",
            "fixed: yes",
            '10:48: error[TB103] scene.objects.table.fixed: is the text "yes"; '
            "true or false is needed",
        ),
        (
            "summary: Two arms and a cube.",
            "summary: 5",
            "2:10: error[TB103] summary: is 5; text is needed",
        ),
        (
            "mass: 0.1",
            "mass: .nan",
            "13:13: error[TB103] scene.objects.cube.mass: is nan; a finite number is needed",
        ),
        (
            "summary: Two arms and a cube.",
            "summary:",
            "2:9: error[TB103] summary: is nothing; text is needed",
        ),
        (
            CUBE,
            "shape: [1, 2]",
            "12:14: error[TB103] scene.objects.cube.shape: is a list of 2; a mapping is needed",
        ),
        (
            "left: [self.tcp, cube.pose]",
            "left: {self.tcp: 1}",
            "23:9: error[TB103] observe.left: is a mapping; a list is needed",
        ),
        # ranges
        (
            "mass: 0.1",
            "mass: -1",
            "13:13: error[TB104] scene.objects.cube.mass: is -1; must be at least 0.0001",
        ),
        (
            "mass: 0.1",
            "mass: 1e9",
            "13:13: error[TB104] scene.objects.cube.mass: is 1000000000.0; must be at most 1000",
        ),
        (
            "sphere: 0.03",
            "sphere: 0",
            "18:29: error[TB104] scene.sites.goal.marker.sphere: is 0; must be at least 0.0005",
        ),
        # lengths
        (
            "box: [0.05, 0.05, 0.05]",
            "box: [0.05, 0.05]",
            "12:20: error[TB104] scene.objects.cube.shape.box: has 2 values; 3 are needed",
        ),
        (
            "box: [0.05, 0.05, 0.05]",
            "box: [0.05, 0.05, 0.05, 0.05]",
            "12:20: error[TB104] scene.objects.cube.shape.box: has 4 values; 3 are needed",
        ),
        (
            "center: [-0.3, 0]",
            "center: [-0.3]",
            "16:39: error[TB104] scene.objects.cube.place.center: has 1 value; "
            "at least 2 are needed",
        ),
        (
            "center: [-0.3, 0]",
            "center: [1, 2, 3, 4]",
            "16:39: error[TB104] scene.objects.cube.place.center: has 4 values; "
            "at most 3 are allowed",
        ),
        (
            "summary: Two arms and a cube.",
            'summary: ""',
            "2:10: error[TB104] summary: is empty; at least one is needed",
        ),
        # choices
        (
            "grasps: {middle: {}}",
            "grasps: {middle: {approach: upp}}",
            '15:35: error[TB105] scene.objects.cube.grasps.middle.approach: "upp" is no choice '
            "here; choices: down, +x, -x, +y, -y, +z, -z",
        ),
        (
            "physics_hz: 120",
            "physics_hz: 120, ends_on: [succes]",
            '4:53: error[TB105] timing.ends_on[0]: "succes" is no choice here; '
            'did you mean "success"? (one of success, failure)',
        ),
        (
            "left: {bring: cube, to: goal}",
            "left: {release: false}",
            "27:21: error[TB105] expert[1].left.release: false is no choice here; choices: true",
        ),
        # what goes together
        (
            "cube:\n      shape: {box: [0.05, 0.05, 0.05]}",
            "cube:\n      shape: {}",
            "12:14: error[TB106] scene.objects.cube.shape: a shape has none; give exactly one of "
            "box, sphere, cylinder, capsule, mesh, urdf",
        ),
        (
            CUBE,
            "shape: {box: [1, 1, 1], sphere: 1}",
            "12:14: error[TB106] scene.objects.cube.shape: a shape has box and sphere; "
            "give exactly one of box, sphere, cylinder, capsule, mesh, urdf",
        ),
        (
            CUBE,
            "shape: {sphere: 1, scale: 2}",
            "12:14: error[TB106] scene.objects.cube.shape: scale goes with mesh or urdf only",
        ),
        (
            "marker: {sphere: 0.03}, position: [0.3, 0, 0.6]",
            "marker: {sphere: 0.03}",
            "18:11: error[TB106] scene.sites.goal: it has none; "
            "give exactly one of position, place",
        ),
        (
            "position: [0.3, 0, 0.6]",
            "place: {center: [0.3, 0, 0.6], size: [0, 0, 0], clearance: 0.1}",
            "18:11: error[TB106] scene.sites.goal: a site has no body and keeps no clearance",
        ),
        (
            "surface: table, center: [-0.3, 0]",
            "surface: table, center: [-0.3, 0, 1]",
            "16:14: error[TB106] scene.objects.cube.place: center and size on a surface: [x, y]",
        ),
        (
            "size: [0.1, 0.2]",
            "size: [0.1, 0.2], yaw_deg: [5, -5]",
            "16:14: error[TB106] scene.objects.cube.place: yaw_deg is [least, greatest]; swap them",
        ),
        (
            "physics_hz: 120",
            "physics_hz: 125",
            "4:9: error[TB106] timing: physics_hz 125 is no multiple of control_hz 10; 120 is",
        ),
        (
            "left: {bring: cube, to: goal}",
            "left: {bring: cube}",
            "27:11: error[TB106] expert[1].left: bring and to go together: "
            "{bring: stick, to: goal}",
        ),
        (
            "left: {bring: cube, to: goal}",
            "left: {to: goal}",
            "27:11: error[TB106] expert[1].left: an order has none; give exactly one of grasp, "
            "reach, bring, retreat, release, close, turn, slide, push, press, home, posture",
        ),
        (
            "front: {position: [0, -1.4, 1.3], look_at: [0, 0, 0.5]}",
            "front: {position: [0, -1.4, 1.3]}",
            "21:12: error[TB106] scene.cameras.front: "
            "a camera has position and look_at, or a mount",
        ),
        (
            "      mass: 0.1\n",
            "",
            "12:7: error[TB101] scene.objects.cube: "
            "mass is missing; give kilograms, or fixed: true",
        ),
        # names and colours
        (
            "meeting: {",
            "meeting-place: {",
            "19:5: error[TB107] scene.sites.meeting-place: not a name; "
            "a letter, then letters, digits and _, at most 40 in all",
        ),
        (
            "meeting: {",
            "world: {",
            "19:5: error[TB107] scene.sites.world: a reserved word; choose another name",
        ),
        (
            "color: red",
            "color: rde",
            f"14:14: error[TB108] scene.objects.cube.color: no such colour; one of {PALETTE}, "
            'or [r, g, b] from 0 to 1, or "#rrggbb"',
        ),
        (
            "color: red",
            "color: [255, 0, 0]",
            "14:14: error[TB108] scene.objects.cube.color: a colour is a name, "
            '[r, g, b] with each from 0 to 1, or "#rrggbb"',
        ),
        (
            "task: plain",
            "task: simple",
            '1:7: error[TB109] task: is "simple"; the file is "plain.yaml": use one name',
        ),
        (
            "  right: [self.tcp]\n",
            "",
            '22:1: error[TB101] observe: has no entry for the robot "right"; '
            "list what it observes, if only []",
        ),
    ],
)
def test_one_slip_gives_one_finding_in_plain_words(findings, old, new, message):
    assert findings((old, new)) == [message]


def test_a_name_that_is_a_value_is_marked_at_the_value(findings):
    assert findings(("task: plain", "task: 5 plain")) == [
        "1:7: error[TB107] task: not a name; "
        "a letter, then letters, digits and _, at most 40 in all",
    ]


def test_a_key_spelt_like_the_models_own_mark_for_keys_is_a_key_like_any_other(findings):
    known = "task, version, summary, instructions, cooperation, timing, scene, observe, "
    known += "observation_noise, state, expert, variations, randomize, looks"
    assert findings(("task: plain", 'task: plain\n"[key]": 1')) == [
        f"2:1: error[TB102] [key]: unknown key; known keys: {known}"
    ]


def test_a_misspelt_required_key_is_reported_once_in_each_model(findings):
    changes = ("summary:", "sumary:"), ("left: {model: ur5e", "left: {modl: ur5e")
    assert [line.partition(";")[0] for line in findings(*changes)] == [
        "2:1: error[TB102] sumary: unknown key",
        "7:12: error[TB102] scene.robots.left.modl: unknown key",
    ]


def test_all_slips_of_a_file_are_told_in_one_run_from_top_to_bottom(findings):
    found = findings(
        ("left: {grasp: cube.middle}", "left: {grab: x}"),
        ("summary:", "sumary:"),
        ("color: red", "color: rde"),
        ("mass: 0.1", "mass: heavy"),
        ("surface: table", "surface: tabel"),
        ("[self.tcp, cube.pose]", "[self.tpc, cube.pose]"),
    )
    assert [line.partition(" ")[0] for line in found] == [
        "2:1:",
        "13:13:",
        "14:14:",
        "16:24:",
        "23:10:",
        "26:12:",
    ]


def test_wrong_shapes_do_not_hide_wrong_names_nor_duplicate_keys(findings):
    found = findings(("mass: 0.1", "mass: []\n      mass: 1\n      in: nowhere"))
    assert [line.split(" ")[1] for line in found] == [
        "error[TB103]",
        "error[TB004]",
        "error[TB201]",
    ]


@pytest.mark.parametrize("stage", ["7", "release", "[]", "~"])
def test_a_stage_that_is_no_mapping_is_refused(findings, stage):
    (found,) = findings(("  - left: {bring: cube, to: goal}", f"  - {stage}"))
    assert found.startswith("27:5: error[TB103] expert[1]: is ")


def test_a_key_of_a_stage_of_several_is_explained_by_that_kind_of_stage(findings):
    together = "{together: [left, right], brings: cube, to: goal}"
    assert findings(("left: {bring: cube, to: goal}", together)) == [
        '27:31: error[TB102] expert[1].brings: unknown key; did you mean "bring"?'
    ]
