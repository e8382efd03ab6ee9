"""Names in task files: what each place may name, and what is said where nothing has the name."""

from __future__ import annotations

import pytest

from taskbuilder.schema.channels import Channel, parse_channel
from taskbuilder.schema.names import ObjectNames, SceneNames

SCENE = SceneNames(
    robots=("left", "right"),
    objects={
        "tray": ObjectNames(parts=("floor", "handle"), grasps=("rim",)),
        "cabinet": ObjectNames(parts=("drawer",), joints={"slide": "prismatic"}),
        "broken": ObjectNames(unread=True),
    },
    sites={"goal": True, "meeting": False},
    cameras=("front",),
)

PLACES = [
    ("position: [0, 0, 0.38]", "position: [0, 0, 0.38], in: {}", "scene.objects.table.in", "frame"),
    ("position: [0.3, 0, 0.6]", "position: [0.3, 0, 0.6], in: {}", "scene.sites.goal.in", "frame"),
    ("surface: table", "surface: {}", "scene.objects.cube.place.surface", "surface"),
    ("surface: table", "surface: table, in: {}", "scene.objects.cube.place.in", "frame"),
    ("front: {position", "front: {{mount: {}, position", "scene.cameras.front.mount", "frame"),
    ("left: {grasp: cube.middle}", "left: {{grasp: {}}}", "expert[0].left.grasp", "grasp"),
    ("left: {grasp: cube.middle}", "left: {{reach: {}}}", "expert[0].left.reach", "frame"),
    ("left: {grasp: cube.middle}", "left: {{close: {}}}", "expert[0].left.close", "object"),
    ("left: {bring: cube,", "left: {{bring: {},", "expert[1].left.bring", "object"),
    ("to: goal}", "to: goal, touching: [{}]}}", "expert[1].left.touching[0]", "object"),
    (
        "  - left: {bring: cube, to: goal}",
        "  - {{together: [left, right], bring: cube, to: goal, touching: [cube, {}]}}",
        "expert[1].touching[1]",
        "object",
    ),
    ("to: goal", "to: {}", "expert[1].left.to", "frame"),
    (
        "  - left: {bring: cube, to: goal}",
        "  - {{together: [left, {}], bring: cube, to: goal}}",
        "expert[1].together[1]",
        "robot",
    ),
    (
        "  - left: {bring: cube, to: goal}",
        "  - {{together: [left, right], bring: {}, to: goal}}",
        "expert[1].bring",
        "object",
    ),
    (
        "  - left: {bring: cube, to: goal}",
        "  - {{together: [left, right], bring: cube, to: {}}}",
        "expert[1].to",
        "frame",
    ),
    ("  - left: {grasp: cube.middle}", "  - {}: {{grasp: cube.middle}}", "expert[0].{}", "robot"),
    (
        "  - left: {grasp: cube.middle}",
        "  - {{repeat: 2, stages: [{{left: {{reach: {}}}}}]}}",
        "expert[0].stages[0].left.reach",
        "frame",
    ),
    (
        "  - left: {grasp: cube.middle}",
        "  - {{repeat: 2, stages: [{{{}: {{grasp: cube.middle}}}}]}}",
        "expert[0].stages[0].{}",
        "robot",
    ),
    ("  right: [self.tcp]", "  right: [self.tcp]\n  {}: []", "observe.{}", "robot"),
    ("expert:", "observation_noise: {{{}: {{}}}}\nexpert:", "observation_noise.{}", "robot"),
]


@pytest.mark.parametrize(("old", "new", "path", "kind"), PLACES, ids=lambda text: text)
def test_a_name_that_stands_for_nothing_is_found_wherever_it_is(findings, old, new, path, kind):
    (found,) = findings((old, new.format("nobody")))
    assert f'error[TB201] {path.format("nobody")}: the scene has no "nobody"; it has: ' in found


@pytest.mark.parametrize(("old", "new", "path", "kind"), PLACES, ids=lambda text: text)
def test_a_name_of_another_kind_is_told_from_one_that_stands_for_nothing(
    findings, old, new, path, kind
):
    other = {"robot": "meeting", "frame": "front", "object": "goal"}.get(kind, "goal")
    (found,) = findings((old, new.format(other)))
    assert f'error[TB201] {path.format(other)}: "{other}" is no {kind}; ' in found


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("surface: table", "surface: world"),
        ("left: {bring: cube, to: goal}", "left: {bring: cube, to: world}"),
        ("front: {position", "front: {mount: world, position"),
        ("left: {grasp: cube.middle}", "left: {grasp: world}"),
    ],
)
def test_the_world_is_a_frame_to_stand_in_and_nothing_else(findings, old, new):
    (found,) = findings((old, new))
    assert 'the scene has no "world"' in found


def test_things_may_stand_in_the_world_by_name(findings):
    assert not findings(
        ("position: [0, 0, 0.38]", "position: [0, 0, 0.38], in: world"),
        ("surface: table", "surface: table, in: world"),
    )


@pytest.mark.parametrize(
    ("kind", "name", "problem"),
    [
        ("frame", "left", '"left" is a robot; name a frame of it: left.tcp or left.base'),
        ("object", "left", '"left" is no object; objects: tray, cabinet, broken'),
        ("body", "tray.handel", '"tray" has no body "handel"; did you mean "handle"?'),
        ("frame", "left.wrist", '"left" has no frame "wrist"; it has: tcp, base'),
        ("joint", "tray.slide", '"tray" has no joint "slide"; it has no joints'),
        ("robot", "rigth", 'the scene has no "rigth"; did you mean "right"?'),
        ("robot", "LEFT", 'the scene has no "LEFT"; did you mean "left"?'),
        (
            "container",
            "meeting",
            '"meeting" is no container; containers: tray, cabinet, broken, '
            "tray.floor, tray.handle, cabinet.drawer, goal",
        ),
        ("camera", "top", 'the scene has no "top"; it has: front'),
        ("grasp", "tray.handle", '"tray.handle" is no grasp; grasps: tray.rim'),
    ],
)
def test_a_problem_says_what_would_be_right(kind, name, problem):
    assert SCENE.problem(kind, name).message == problem


def test_a_scene_without_anything_of_a_kind_says_so():
    assert (
        SceneNames((), {}, {}).problem("site", "goal").message
        == 'the scene has no "goal"; there are none'
    )


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("robot", ["left", "right"]),
        ("object", ["tray", "cabinet"]),
        ("body", ["tray", "tray.handle", "cabinet.drawer", "broken.anything"]),
        ("solid", ["left", "tray", "tray.handle", "cabinet.drawer", "broken.anything"]),
        ("surface", ["tray", "tray.floor"]),
        ("site", ["goal", "meeting"]),
        ("frame", ["tray", "goal", "left.tcp", "right.base", "tray.rim", "tray.floor", "broken.x"]),
        ("container", ["tray", "goal", "cabinet.drawer"]),
        ("grasp", ["tray.rim"]),
        ("joint", ["cabinet.slide", "broken.hinge"]),
        ("camera", ["front"]),
    ],
)
def test_names_of_the_right_kind_have_no_problem(kind, names):
    for name in names:
        assert SCENE.problem(kind, name) is None


def test_what_can_be_in_an_unread_urdf_is_no_grasp_and_no_robot():
    assert SCENE.problem("grasp", "broken.x")
    assert SCENE.problem("robot", "broken.x")


def test_the_type_of_a_joint_is_known_where_its_urdf_was_read():
    assert SCENE.joint_type("cabinet.slide") == "prismatic"
    assert SCENE.joint_type("broken.slide") is None
    assert SCENE.joint_type("nobody.slide") is None


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "goal: {marker",
            "cube: {marker",
            '18:5: error[TB202] scene.sites.cube: "cube" is also scene.objects.cube; '
            "every name stands for one thing",
        ),
        (
            "table: {shape",
            "left: {shape",
            '10:5: error[TB202] scene.objects.left: "left" is also scene.robots.left; '
            "every name stands for one thing",
        ),
        (
            "front: {position",
            "goal: {position",
            '21:5: error[TB202] scene.cameras.goal: "goal" is also scene.sites.goal; '
            "every name stands for one thing",
        ),
    ],
)
def test_one_name_for_two_things_is_a_clash(findings, old, new, message):
    assert message in findings((old, new))


def test_a_circle_of_frames_is_told_once_with_all_that_is_in_it(findings):
    assert findings(
        ("position: [0, 0, 0.38]", "position: [0, 0, 0.38], in: goal"),
        ("position: [0.3, 0, 0.6]", "position: [0.3, 0, 0.6], in: cube.middle"),
    ) == [
        "10:82: error[TB203] scene.objects.table.in: runs in a circle: "
        "table in goal in cube in table; give one a world position"
    ]


def test_a_thing_in_its_own_frame_is_a_circle(findings):
    (found,) = findings(("position: [0, 0, 0.6]}", "position: [0, 0, 0.6], in: meeting}"))
    assert "runs in a circle: meeting in meeting" in found


def test_what_hangs_on_a_circle_is_not_part_of_it(findings):
    (found,) = findings(
        ("position: [0, 0, 0.38]", "position: [0, 0, 0.38], in: table"),
        ("position: [0.3, 0, 0.6]", "position: [0.3, 0, 0.6], in: table"),
    )
    assert "table in table" in found


@pytest.mark.parametrize(
    ("text", "channel"),
    [
        ("self.tcp", Channel("left", "tcp")),
        ("right.gripper", Channel("right", "gripper")),
        ("self.tcp_velocity", Channel("left", "tcp_velocity")),
        ("tray.pose", Channel("tray", "pose")),
        ("tray.velocity", Channel("tray", "velocity")),
        ("tray.handle.velocity", Channel("tray.handle", "velocity")),
        ("tray.rim.position", Channel("tray.rim", "position")),
        ("left.tcp.pose", Channel("left.tcp", "pose")),
        ("goal.orientation", Channel("goal", "orientation")),
        ("cabinet.slide", Channel("cabinet", "slide")),
        ("broken.anything", Channel("broken", "anything")),
        ("front.depth", Channel("front", "depth")),
        ("time_left", Channel("", "time_left")),
        ("tray.pose in self.tcp", Channel("tray", "pose", "left.tcp")),
        ("tray.pose  in  goal", Channel("tray", "pose", "goal")),
        ("tray.pose in world", Channel("tray", "pose", "world")),
    ],
)
def test_a_channel_is_a_quantity_of_a_subject_seen_from_a_frame(text, channel):
    assert parse_channel(text, "left", SCENE) == channel


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("tray", '"tray" is no channel; write subject.quantity, such as self.tcp or stick.pose'),
        ("self", '"self" is no channel; write subject.quantity, such as self.tcp or stick.pose'),
        ("tary.pose", 'the scene has no "tary"; did you mean "tray"?'),
        ("tray.poze", '"tray" has no "poze" to observe; did you mean "pose"?'),
        (
            "goal.velocity",
            '"goal" has no "velocity" to observe; it has: pose, position, orientation',
        ),
        (
            "self.pose",
            '"left" has no "pose" to observe; it has: joints, joint_velocities, tcp, '
            "tcp_velocity, gripper, holding, force, previous_action",
        ),
        ("front.x", '"front" has no "x" to observe; it has: rgb, depth, mask, points'),
        ("tray.pose in goall", 'the scene has no "goall"; did you mean "goal"?'),
        ("tray.pose in self", '"left" is a robot; name a frame of it: left.tcp or left.base'),
        ("cabinet.slyde", '"cabinet" has no "slyde" to observe; did you mean "slide"?'),
    ],
)
def test_a_wrong_channel_says_what_would_be_right(text, problem):
    assert parse_channel(text, "left", SCENE).message == problem


@pytest.mark.parametrize("text", ["self.tcp", "tray.pose in self.tcp"])
def test_the_state_belongs_to_nobody_so_self_means_nothing_in_it(text):
    assert parse_channel(text, None, SCENE).message == (
        '"self" means nothing in the state; name the robot'
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "left: [self.tcp, cube.pose]",
            "left: [self.tcp, cub.pose]",
            '23:20: error[TB204] observe.left[1]: the scene has no "cub"; did you mean "cube"?',
        ),
        (
            "expert:",
            "state: [cube.pose, self.tcp]\nexpert:",
            '25:20: error[TB204] state[1]: "self" means nothing in the state; name the robot',
        ),
        (
            "expert:",
            "observation_noise: {left: {cube.pos: {std: 1}}}\nexpert:",
            '25:28: error[TB204] observation_noise.left.cube.pos: "cube" has no "pos" to observe; '
            'did you mean "pose"?',
        ),
    ],
)
def test_wrong_channels_are_found_in_every_list_of_them(findings, old, new, message):
    assert findings((old, new)) == [message]


def test_the_whole_state_may_be_asked_for_in_a_word_or_in_a_list(load):
    assert load(("expert:", "state: all\nexpert:")).spec.state == ("all",)
    assert load(("expert:", "state: [all]\nexpert:")).spec.state == ("all",)


def test_a_scene_without_cameras_of_its_own_has_one_in_front(load, findings):
    block = "  cameras:\n    front: {position: [0, -1.4, 1.3], look_at: [0, 0, 0.5]}\n"
    task = load((block, ""))
    assert task.names.cameras == ("front",) == tuple(task.spec.scene.cameras)
    task = load((block, "  cameras: {}\n"))
    assert task.names.cameras == () == tuple(task.spec.scene.cameras)
    assert findings((block, "  cameras: {}\n"), ("[self.tcp, cube.pose]", "[front.rgb]"))
