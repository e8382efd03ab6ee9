"""What files say of grasping: the rule, the distance and the force of a gripper with fingers."""

from __future__ import annotations

import pytest

from taskbuilder.errors import UsageError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.grasping import Grasping, grasp_rules, grasping, with_grasp
from taskbuilder.schema.load import read_task
from taskbuilder.schema.other_robots import with_robots

LEFT = "left: {model: ur5e,"
CATALOGUE = Catalogue.discover()


def left(text):
    return (LEFT, f"left: {{model: ur5e, grasp: {text},")


def of(task, name="left"):
    return grasping(task.spec.scene.robots[name], task.robots[name])


def test_by_default_objects_are_held_by_friction(load):
    assert of(load()) == Grasping("friction", 0.04, None)
    assert grasp_rules(load()) == {"left": "friction", "right": "friction"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("attach", Grasping("attach", 0.04, None)),
        ("{rule: attach, distance: 0.02}", Grasping("attach", 0.02, None)),
        ("{rule: attach, force: 30}", Grasping("attach", 0.04, 30.0)),
        ("{distance: 0.2}", Grasping("friction", 0.2, None)),
    ],
)
def test_a_scene_says_how_a_robot_holds(load, text, expected):
    task = load(left(text))
    assert of(task) == expected
    assert of(task, "right") == Grasping()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("magnet", '"magnet" is no choice here; choices: friction, attach'),
        ("{rule: attach, distance: 0}", "is 0; must be more than 0"),
        ("{rule: attach, distance: 1.0}", "is 1.0; must be at most 0.2"),
        ("{rule: attach, force: 0}", "is 0; must be more than 0"),
        ("{rule: attach, reach: 0.1}", "unknown key; known keys: rule, distance, force"),
        ("3", "is 3; a mapping is needed"),
    ],
)
def test_what_is_wrong_is_said_where_it_stands(findings, text, message):
    (finding,) = findings(left(text))
    assert finding.startswith("7:")
    assert "scene.robots.left.grasp" in finding
    assert message in finding


@pytest.mark.parametrize(
    ("model", "has"), [("ur5e_suction", "a suction cup"), ("ur5e_pusher", "no gripper")]
)
def test_a_robot_without_fingers_has_no_rule(findings, model, has):
    first = findings((LEFT, f"left: {{model: {model}, grasp: attach,"))[0]
    assert first.startswith("7:")
    assert f"left is a {model}, which has {has}, and grasp is for fingers; leave it out" in first


def test_what_the_scene_leaves_open_is_as_in_the_robot_file(load, folder):
    folder = folder / "claw"
    folder.mkdir()
    written = CATALOGUE.robot("panda", folder).file.read_text()
    text = written.replace("robot: panda", "robot: claw")
    (folder / "robot.yaml").write_text(f"{text}  grasp: {{rule: attach, distance: 0.07}}\n")
    changed = load((LEFT, "left: {model: claw/robot.yaml, grasp: {force: 12},"))
    assert of(changed) == Grasping("attach", 0.07, 12.0)
    plain = with_robots(load(), (("left", str(folder / "robot.yaml")),), CATALOGUE)
    assert of(plain) == Grasping("attach", 0.07, None)
    assert of(with_grasp(plain, "friction")).rule == "friction"


def test_a_choice_holds_in_all_variations_and_leaves_the_task_as_it_is():
    task = read_task(CATALOGUE.task("pick_push_place"), CATALOGUE)
    chosen = with_grasp(task, "attach")
    for scene in (*chosen.scenes, chosen.spec.scene, chosen.written.scene):
        assert {entry.grasp.rule for entry in scene.robots.values()} == {"attach"}
    assert all(entry.grasp is None for entry in task.spec.scene.robots.values())
    assert with_grasp(task, "task") is task


def test_a_choice_keeps_the_distance_and_the_force(load):
    task = with_grasp(load(left("{distance: 0.02, force: 9}")), "attach")
    assert of(task) == Grasping("attach", 0.02, 9.0)


def test_robots_without_fingers_stay_what_they_are(load):
    task = with_robots(load(left("attach")), (("left", "ur5e_suction"),), CATALOGUE)
    assert grasp_rules(task, "attach") == {"right": "attach"}


@pytest.mark.parametrize("rule", ["friction", "attach"])
def test_a_choice_that_no_robot_can_have_is_refused(load, rule):
    models = (("left", "ur5e_suction"), ("right", "ur5e_pusher"))
    task = read_task(CATALOGUE.task("handover"), CATALOGUE)
    with pytest.raises(UsageError, match="no robot of handover has fingers to hold objects by"):
        with_grasp(with_robots(task, models, CATALOGUE), rule)


def test_an_unknown_choice_is_refused(load):
    with pytest.raises(UsageError, match='grasp "attached": did you mean "attach"'):
        with_grasp(load(), "attached")
