"""The stages of experts: what may be written, and what is said of what may not."""

from __future__ import annotations

import pytest

from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.dump import as_yaml
from taskbuilder.schema.expert import (
    Repeat,
    Together,
    Wait,
    kind_of_stage,
    stage_labels,
    waits,
)
from taskbuilder.schema.load import read_task
from taskbuilder.schema.order import Order

LAST = "  - left: {bring: cube, to: goal}\n"
VERBS = "grasp, reach, bring, retreat, release, close, turn, slide, push, press, home, posture"
OWN_STAGES = "together, until, repeat and orders for robots are stages of their own"
ORDER = "an order is needed: release, home, or a mapping such as {grasp: stick.left_end}"
OF_A_ROBOT = "without a robot; an order is some robot's: {left: {grasp: stick.left_end}}"


@pytest.fixture
def said(findings):
    """What is found wrong with a stage, in place of the plain task's last."""
    return lambda stage: findings((LAST, f"  - {stage}\n"))


@pytest.fixture
def stages(load):
    """The stages of the plain task, the last replaced by others."""
    return lambda *texts: load((LAST, "".join(f"  - {t}\n" for t in texts))).spec.expert[1:]


# --- what may be written


@pytest.mark.parametrize(
    ("stage", "kind"),
    [
        ("{left: release}", "each"),
        ("{left: {reach: goal}, right: {close: nothing}}", "each"),
        ("{left: [release, {reach: goal}], right: release}", "each"),
        ("{together: [left, right], bring: cube, to: goal}", "together"),
        ("{until: success}", "until"),
        ("{until: release}", "until"),
        ("{repeat: 2, stages: [{left: release}]}", "repeat"),
    ],
)
def test_a_stage_is_what_its_keys_say(stages, stage, kind):
    (found,) = stages(stage)
    assert kind_of_stage(found) == kind
    model = {"together": Together, "until": Wait, "repeat": Repeat}.get(kind, dict)
    assert isinstance(found, model)


def test_stages_repeat_in_stages_that_repeat(stages):
    (outer,) = stages(
        "{repeat: 3, unless: success, stages: [{repeat: 2, stages: [{left: release}]}]}"
    )
    (inner,) = outer.stages
    assert (outer.repeat, outer.unless, inner.repeat, inner.unless) == (3, "success", 2, None)
    assert inner.stages == ({"left": Order(release=True)},)


def test_every_condition_that_is_waited_for_has_its_place(stages):
    found = stages(
        "{until: lifted}",
        "{left: release}",
        "{repeat: 2, unless: done, stages: [{left: release}, {until: near}]}",
    )
    turn = Order(turn="box.lid", to_deg=9.0, until="open")
    slide = Order(slide="box.tray", to=0.1, until="out")
    repeat = Repeat(repeat=2, stages=({"left": (Order(release=True), slide)},))
    found = (*found, {"left": turn}, repeat)
    assert list(waits(found)) == [
        (("expert", 0, "until"), "lifted"),
        (("expert", 2, "unless"), "done"),
        (("expert", 2, "stages", 1, "until"), "near"),
        (("expert", 3, "left", "until"), "open"),
        (("expert", 4, "stages", 0, "left", 1, "until"), "out"),
    ]


@pytest.mark.parametrize(
    ("stage", "words"),
    [
        ("{left: {grasp: cube.middle}}", "grasp cube.middle"),
        ("{left: {bring: cube, to: goal}}", "bring cube to goal"),
        ("{left: {retreat: 0.1}}", "retreat by 0.1 m"),
        ("{left: release}", "release"),
        ("{left: {close: nothing}}", "close nothing"),
        ("{left: {push: cube, to: goal}}", "push cube to goal"),
        ("{left: home}", "go home"),
        ("{left: {press: goal}}", "press goal"),
        ("{left: {reach: [0.1, 0, 0.5]}}", "reach [0.1, 0, 0.5]"),
        ("{left: {bring: cube, to: [0.1, 0, 0.5]}}", "bring cube to [0.1, 0, 0.5]"),
        ("{together: [left, right], bring: cube, to: goal}", "bring cube to goal"),
        ("{until: at goal}", "until at goal"),
        ("{repeat: 3, stages: [{left: release}]}", "repeat 3 times"),
    ],
)
def test_stages_and_orders_say_in_words_what_they_are(stages, stage, words):
    (found,) = stages(stage)
    assert str(found["left"] if isinstance(found, dict) else found) == words


@pytest.mark.parametrize("name", ["within", "stages", "unless", "grasp", "to", "untilted"])
def test_a_robot_may_be_called_as_keys_of_stages_are(load, name):
    spec = load(
        ("right: {model", f"{name}: {{model"),
        ("right: [self.tcp]", f"{name}: [self.tcp]"),
        (LAST, f"  - {name}: release\n  - {{{name}: {{retreat: 0.1}}, left: release}}\n"),
    ).spec
    assert [list(stage) for stage in spec.expert[1:]] == [[name], [name, "left"]]


def test_what_is_written_out_again_is_the_same(load, folder):
    first = load(
        (
            LAST,
            "  - {repeat: 2, unless: success, stages: [{until: near}, {left: {close: cube}}]}\n"
            "  - left: {bring: cube, to: goal, offset: [0, 0.1, 0], align: true, speed: 0.5}\n",
        )
    )
    (folder / "plain.yaml").write_text(as_yaml(first))
    again = read_task(first.entry, Catalogue())
    assert again.spec.expert == first.spec.expert


# --- what may not


@pytest.mark.parametrize(
    ("stage", "message"),
    [
        # keys, however deep
        (
            "{repeat: 2, stages: [{left: {graps: cube.middle}}]}",
            "27:34: error[TB102] expert[1].stages[0].left.graps: unknown key; "
            'did you mean "grasp"?',
        ),
        (
            "{repeat: 2, stages: [{repeat: 2, stages: [{left: {reach: goal, abov: 1}}]}]}",
            "27:68: error[TB102] expert[1].stages[0].stages[0].left.abov: unknown key; "
            'did you mean "above"?',
        ),
        (
            "{repeat: 2, stages: [{together: [left, right], brings: cube, to: goal}]}",
            '27:52: error[TB102] expert[1].stages[0].brings: unknown key; did you mean "bring"?',
        ),
        (
            "{until: success, for: 2}",
            "27:22: error[TB102] expert[1].for: unknown key; known keys: until, within",
        ),
        (
            "{together: [left, right], bring: cube, to: goal, align: true}",
            "27:54: error[TB102] expert[1].align: unknown key; "
            "known keys: together, bring, to, above, offset, straight, touching, speed, tolerance",
        ),
        (
            "{left: {wait: 2}}",
            "27:13: error[TB102] expert[1].left.wait: unknown key; known keys: "
            f"{VERBS}, to, to_deg, until, turn_tool, depth, above, offset, approach, rpy_deg, "
            "align, straight, touching, speed, tolerance, tolerance_deg",
        ),
        # the key that says what a stage is
        (
            "{untill: success}",
            '27:6: error[TB102] expert[1].untill: unknown key; did you mean "until"?',
        ),
        (
            "{repeats: 2, stages: [{left: release}]}",
            '27:6: error[TB102] expert[1].repeats: unknown key; did you mean "repeat"?',
        ),
        (
            "{togehter: [left, right], bring: cube, to: goal}",
            '27:6: error[TB102] expert[1].togehter: unknown key; did you mean "together"?',
        ),
        (
            "{stages: [{left: release}]}",
            "27:5: error[TB101] expert[1].repeat: missing; maximum number of rounds",
        ),
        (
            "{within: 2}",
            "27:5: error[TB101] expert[1].until: missing; "
            "success, failure, a stage or another condition of the description",
        ),
        ("{repeat: 2}", "27:5: error[TB101] expert[1].stages: missing; the stages to repeat"),
        (
            "{together: [left, right], bring: cube}",
            "27:5: error[TB101] expert[1].to: missing; "
            "frame, or point of the world, to bring it to",
        ),
        # values
        (
            "{until: [success, failure]}",
            "27:13: error[TB103] expert[1].until: is a list of 2; text is needed",
        ),
        ("{until: }", "27:13: error[TB103] expert[1].until: is nothing; text is needed"),
        ('{until: ""}', "27:13: error[TB104] expert[1].until: is empty; at least one is needed"),
        (
            "{until: success, within: 0}",
            "27:30: error[TB104] expert[1].within: is 0; must be more than 0",
        ),
        (
            "{repeat: 0, stages: [{left: release}]}",
            "27:14: error[TB104] expert[1].repeat: is 0; must be at least 1",
        ),
        (
            "{repeat: , stages: [{left: release}]}",
            "27:14: error[TB103] expert[1].repeat: is nothing; a whole number is needed",
        ),
        (
            "{repeat: 2, stages: []}",
            "27:25: error[TB104] expert[1].stages: is empty; at least one is needed",
        ),
        (
            "{repeat: 2, stages: {left: release}}",
            "27:25: error[TB103] expert[1].stages: is a mapping; a list is needed",
        ),
        (
            "{repeat: 2, stages: [release]}",
            '27:26: error[TB103] expert[1].stages[0]: is the text "release"; '
            "a mapping of names is needed",
        ),
        ("{}", "27:5: error[TB104] expert[1]: is empty; at least one is needed"),
        (
            "{together: [left], bring: cube, to: goal}",
            "27:16: error[TB104] expert[1].together: has 1 value; at least 2 are needed",
        ),
        (
            "{together: left, bring: cube, to: goal}",
            '27:16: error[TB103] expert[1].together: is the text "left"; a list is needed',
        ),
        (
            "{together: [left, left], bring: cube, to: goal}",
            '27:16: error[TB106] expert[1].together: names "left" twice',
        ),
        (
            "{left: {reach: goal, speed: 2}}",
            "27:33: error[TB104] expert[1].left.speed: is 2; must be at most 1",
        ),
        (
            "{left: {reach: goal, speed: 0}}",
            "27:33: error[TB104] expert[1].left.speed: is 0; must be more than 0",
        ),
        (
            "{left: {close: 5}}",
            "27:20: error[TB103] expert[1].left.close: "
            "name the object that is to be held then, or nothing (got 5)",
        ),
        (
            "{left: {reach: goal, touching: cube}}",
            '27:36: error[TB103] expert[1].left.touching: is the text "cube"; a list is needed',
        ),
        # what is no order
        (
            "{left: retreat}",
            f'27:12: error[TB103] expert[1].left: {ORDER} (got the text "retreat")',
        ),
        ("{left: }", f"27:12: error[TB103] expert[1].left: {ORDER} (got nothing)"),
        ("{wait: 2}", f"27:12: error[TB103] expert[1].wait: {ORDER} (got 2)"),
        ("{grasp: cube.middle}", f"27:5: error[TB106] expert[1]: has grasp {OF_A_ROBOT}"),
        ("{bring: cube, to: goal}", f"27:5: error[TB106] expert[1]: has bring and to {OF_A_ROBOT}"),
        ("{left: release, above: 1}", f"27:5: error[TB106] expert[1]: has above {OF_A_ROBOT}"),
        # what does not go together
        (
            "{together: [left, right], bring: cube, to: goal, left: release}",
            f"27:5: error[TB106] expert[1]: has together and left; {OWN_STAGES}",
        ),
        (
            "{together: [left, right], grasp: cube.middle}",
            f"27:5: error[TB106] expert[1]: has together and grasp; {OWN_STAGES}",
        ),
        (
            "{left: release, until: success}",
            f"27:5: error[TB106] expert[1]: has until and left; {OWN_STAGES}",
        ),
        (
            "{repeat: 2, stages: [{left: release}], until: success}",
            f"27:5: error[TB106] expert[1]: has until and repeat; {OWN_STAGES}",
        ),
        (
            "{left: {release: true, approach: 0.1}}",
            "27:12: error[TB106] expert[1].left: approach goes with grasp and reach only",
        ),
        (
            "{left: {close: cube, speed: 0.5}}",
            "27:12: error[TB106] expert[1].left: "
            "speed goes with grasp, reach, bring, retreat, turn, slide, push, press, home "
            "and posture only",
        ),
        (
            "{left: {grasp: cube.middle, until: success}}",
            "27:12: error[TB106] expert[1].left: until goes with turn and slide only",
        ),
        (
            "{left: {reach: goal, tolerance_deg: 3}}",
            "27:12: error[TB106] expert[1].left: tolerance_deg goes with turn only",
        ),
        (
            "{left: {reach: goal, align: true}}",
            "27:12: error[TB106] expert[1].left: align goes with bring only",
        ),
        (
            "{left: {reach: goal, to: cube}}",
            "27:12: error[TB106] expert[1].left: to goes with bring, slide, push and press only",
        ),
        (
            "{left: {}}",
            f"27:12: error[TB106] expert[1].left: an order has none; give exactly one of {VERBS}",
        ),
        (
            "{left: {push: cube}}",
            "27:12: error[TB106] expert[1].left: push and to go together: {push: block, to: goal}",
        ),
        (
            "{left: {push: cube, to: 0.2}}",
            "27:12: error[TB106] expert[1].left: to of push is a frame or [x, y, z]: "
            "{push: block, to: goal}",
        ),
        (
            "{left: {press: cube, to: goal}}",
            "27:12: error[TB106] expert[1].left: to of press is the joint's position in metres: "
            "{press: button, to: 0.01}",
        ),
        (
            "{left: {press: cube, to: 0.01, depth: 0.02}}",
            "27:12: error[TB106] expert[1].left: press has to and depth; give one of them",
        ),
        (
            "{left: {press: cube, to: 0.01}}",
            "27:26: error[TB106] expert[1].left.to: cube is not on one prismatic joint, so no "
            "position can be given; name a link that slides, or write depth, in metres",
        ),
        (
            "{left: {press: cube, depth: deep}}",
            '27:33: error[TB103] expert[1].left.depth: is the text "deep"; a number is needed',
        ),
        (
            "{left: {press: cube, depth: 0}}",
            "27:33: error[TB104] expert[1].left.depth: is 0; must be at least 0.0005",
        ),
        (
            "{left: {reach: goal, depth: 0.1}}",
            "27:12: error[TB106] expert[1].left: depth goes with press only",
        ),
        (
            "{left: {turn: cube.lid, to_deg: 70}}",
            '27:19: error[TB201] expert[1].left.turn: "cube" has no joint "lid"; it has no joints',
        ),
        (
            "{left: {reach: [0.1, 0]}}",
            "27:20: error[TB103] expert[1].left.reach: "
            "the name of a frame, or [x, y, z] in metres from -100 to 100, is needed "
            "(got a list of 2)",
        ),
        (
            "{left: {bring: cube, to: [1, 2, 300]}}",
            "27:30: error[TB103] expert[1].left.to: "
            "the name of a frame, or [x, y, z] in metres from -100 to 100, is needed "
            "(got a list of 3)",
        ),
        (
            "{left: {bring: cube, to: 0.3}}",
            "27:12: error[TB106] expert[1].left: to of bring is a frame or [x, y, z]: "
            "{bring: stick, to: goal}",
        ),
        # postures
        (
            "{left: {posture: tucked}}",
            '27:22: error[TB201] expert[1].left.posture: left has no posture "tucked"; '
            "it has none; write scene.robots.left.postures",
        ),
        (
            "{left: {posture: [0, 0]}}",
            "27:22: error[TB103] expert[1].left.posture: is a list of 2; text is needed",
        ),
        (
            "{left: {home: false}}",
            "27:19: error[TB105] expert[1].left.home: false is no choice here; choices: true",
        ),
        # several orders of a robot
        ("{left: []}", "27:12: error[TB104] expert[1].left: is empty; at least one is needed"),
        (
            "{left: [{reach: goal}, retreat]}",
            f'27:28: error[TB103] expert[1].left[1]: {ORDER} (got the text "retreat")',
        ),
        (
            "{left: [{graps: cube.middle}, release]}",
            '27:14: error[TB102] expert[1].left[0].graps: unknown key; did you mean "grasp"?',
        ),
        (
            "{left: [{grasp: cube.midle}, release]}",
            '27:21: error[TB201] expert[1].left[0].grasp: "cube" has no grasp "midle"; '
            'did you mean "middle"?',
        ),
        (
            "{lft: [{grasp: cube.middle}, release]}",
            '27:6: error[TB201] expert[1].lft: the scene has no "lft"; did you mean "left"?',
        ),
        # names
        (
            "{repeat: 2, stages: [{left: {grasp: cube.midle}}]}",
            '27:41: error[TB201] expert[1].stages[0].left.grasp: "cube" has no grasp "midle"; '
            'did you mean "middle"?',
        ),
        (
            "{repeat: 2, stages: [{repeat: 2, stages: [{lft: release}]}]}",
            '27:48: error[TB201] expert[1].stages[0].stages[0].lft: the scene has no "lft"; '
            'did you mean "left"?',
        ),
        (
            "{left: {close: cube.middle}}",
            '27:20: error[TB201] expert[1].left.close: "cube.middle" is no object; '
            "objects: table, cube",
        ),
    ],
    ids=lambda text: text if text.startswith("{") else "",
)
def test_one_slip_in_a_stage_gives_one_finding_at_its_place(said, stage, message):
    assert said(stage) == [message]


@pytest.mark.parametrize("name", ["together", "until", "repeat", "nothing"])
def test_what_stages_are_told_apart_by_is_no_name(findings, name):
    assert findings(("meeting: {", f"{name}: {{")) == [
        f"19:5: error[TB107] scene.sites.{name}: a reserved word; choose another name"
    ]


# --- labels


@pytest.mark.parametrize(
    ("written", "labels"),
    [
        (
            ["{left: {reach: cube, above: 0.1}}", "{left: {reach: cube}}", "{left: release}"],
            ["left: reach cube (above 0.1 m)", "left: reach cube", "left: release"],
        ),
        (
            ["{left: {reach: cube, above: 0.1, speed: 0.5}}", "{left: {reach: cube, speed: 0.4}}"],
            ["left: reach cube (above 0.1 m)", "left: reach cube"],
        ),
        (
            ["{left: {reach: cube, above: 0.1, speed: 0.5}}", "{left: {reach: cube, above: 0.1}}"],
            ["left: reach cube (speed 0.5)", "left: reach cube"],
        ),
        (
            ["{left: {reach: cube}}", "{left: {reach: cube, offset: [0, 0.1, 0], straight: true}}"],
            ["left: reach cube", "left: reach cube (offset [0, 0.1, 0] m)"],
        ),
        (
            ["{until: success}", "{until: success, within: 3}"],
            ["until success", "until success (within 3 s)"],
        ),
        (
            ["{repeat: 2, stages: [{left: release}]}", "{repeat: 2, stages: [{left: home}]}"],
            [
                "repeat 2 times (left: release)",
                "repeat 2 times (left: go home)",
            ],
        ),
        (
            ["{left: release}", "{left: home}", "{left: release}"],
            ["left: release", "left: go home", "left: release"],
        ),
    ],
)
def test_different_stages_have_different_labels(stages, written, labels):
    assert list(stage_labels(stages(*written))) == labels
