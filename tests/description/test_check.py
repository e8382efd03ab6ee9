"""Descriptions checked against their scene: what is said, and at which line and column."""

from __future__ import annotations

import pytest
from description_files import REWARD, SUCCESS, body, findings, load

IMPORTS = "from dataclasses import dataclass\nfrom taskbuilder.description import *\n"
CLASS = f"class Plain(Description):\n    {REWARD}\n    success = "


@pytest.fixture
def found(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *lines: findings(tmp_path, body(*lines))


@pytest.fixture
def found_in(tmp_path, monkeypatch):
    """What is found in a file of helpers and a success condition."""
    monkeypatch.chdir(tmp_path)
    return lambda helpers, success: findings(tmp_path, f"{IMPORTS}{helpers}\n{CLASS}{success}\n")


def test_a_sound_description_has_no_findings(found, tmp_path):
    assert found(SUCCESS, REWARD) == []
    assert load(tmp_path, body(SUCCESS, REWARD)).description.__name__ == "Plain"


@pytest.mark.parametrize(
    ("success", "message"),
    [
        (
            'Near("cub", "goal", within=0.1)',
            '5:15: error[TB207] Near("cub", …): the scene has no "cub"; did you mean "cube"?',
        ),
        (
            'Held("cube", by="lefft")',
            '5:15: error[TB207] Held("cube", …): the scene has no "lefft"; did you mean "left"?',
        ),
        (
            'Held("cube", by=("left", "nobody"))',
            '5:15: error[TB207] Held("cube", …): the scene has no "nobody"; it has: left, right',
        ),
        (
            'Held("goal")',
            '5:15: error[TB207] Held("goal", …): "goal" is no body; bodies: cube, tray',
        ),
        (
            'Held("tray.handel")',
            '5:15: error[TB207] Held("tray.handel", …): "tray" has no body "handel"; '
            'did you mean "handle"?',
        ),
        ('Inside("cube", "meeting")', '5:15: error[TB207] Inside("cube", …): "meeting" is no con'),
        ('EmptyHanded("cube")', '5:15: error[TB207] EmptyHanded("cube", …): "cube" is no robot; '),
        (
            'JointPosition("cabinet.slid", above=0.1)',
            '5:15: error[TB207] JointPosition("cabinet.slid", …): "cabinet" has no joint "slid"; '
            'did you mean "slide"?',
        ),
        (
            'Above("left", height=1)',
            '5:15: error[TB207] Above("left", …): "left" is a robot; '
            "name a frame of it: left.tcp or left.base",
        ),
        (
            '~(Held("cube") & Near("cube", "gaol", within=0.1))',
            '5:32: error[TB207] Near("cube", …): the scene has no "gaol"; did you mean "goal"?',
        ),
        (
            'Then(Held("cube"), Once(Held("x")))',
            '5:39: error[TB207] Held("x", …): the scene has no "x"; it has: ',
        ),
        ('Level("tary", within_deg=5)', '5:15: error[TB207] Upright("tary", …): the scene has no'),
        # values
        (
            'Near("cube", "goal", within=0)',
            '5:15: error[TB212] Near("cube", …): within is 0; metres, more than 0',
        ),
        (
            'Near("cube", "goal", within="5 cm")',
            "5:15: error[TB212] Near(\"cube\", …): within is '5 cm'; it must be a finite number",
        ),
        (
            'Near("cube", "goal", within=float("nan"))',
            '5:15: error[TB212] Near("cube", …): within is nan; it must be a finite number',
        ),
        (
            'Near("cube", "goal", within=True)',
            '5:15: error[TB212] Near("cube", …): within is True; it must be a finite number',
        ),
        (
            'Near("cube", "goal", within=0.1, axes="zy")',
            "5:15: error[TB212] Near(\"cube\", …): axes is 'zy'; it must be 'xyz' or 'xy' or 'xz' "
            "or 'yz' or 'x' or 'y' or 'z'",
        ),
        (
            'Upright("cube", within_deg=-5)',
            '5:15: error[TB212] Upright("cube", …): within_deg is -5; degrees, more than 0',
        ),
        (
            'Inside("cube", "tray", margin=-1)',
            '5:15: error[TB212] Inside("cube", …): margin is -1; metres, 0 or more',
        ),
        (
            'Inside("tray", "tray")',
            '5:15: error[TB212] Inside("tray", …): nothing is inside itself',
        ),
        (
            'Stationary("cube", speed=0)',
            '5:15: error[TB212] Stationary("cube", …): speed is 0; m/s, more than 0',
        ),
        ('Moved("cube", by=0)', '5:15: error[TB212] Moved("cube", …): by is 0; metres, more'),
        ('Turned("cube", by_deg=0)', '5:15: error[TB212] Turned("cube", …): by_deg is 0; degrees'),
        (
            'JointPosition("cabinet.slide")',
            '5:15: error[TB212] JointPosition("cabinet.slide", …): has no bound; '
            "give above or below",
        ),
        (
            'JointPosition("cabinet.slide", above=0.2, below=0.1)',
            '5:15: error[TB212] JointPosition("cabinet.slide", …): can never hold: '
            "above 0.2 is more than below 0.1",
        ),
        (
            'JointPosition("cabinet.hinge", above=0.2)',
            '5:15: error[TB212] JointPosition("cabinet.hinge", …): "cabinet.hinge" turns; '
            "use JointAngle, in degrees",
        ),
        (
            'JointAngle("cabinet.slide", above_deg=5)',
            '5:15: error[TB212] JointAngle("cabinet.slide", …): "cabinet.slide" slides; '
            "use JointPosition, in metres",
        ),
        (
            'Beyond("cube", "cube")',
            '5:15: error[TB212] Beyond("cube", …): nothing is beyond itself; name two frames',
        ),
        ('Held("cube", by=())', '5:15: error[TB212] Held("cube", …): by is empty; name a robot'),
        ('Contact("cube")', '5:15: error[TB212] Contact("cube", …): touches what? write Contact('),
        ('Contact("cube", "tray", robot="left")', '5:15: error[TB212] Contact("cube", …): touches'),
        (
            'AtLeast(3, Held("cube"), Held("tray"))',
            "5:15: error[TB212] AtLeast(…): count is 3; from 1 to the 2 conditions given",
        ),
        ("Then()", "5:15: error[TB212] Then(…): lists no condition; give at least one"),
        (
            'ForceAbove("left", "rigth", newtons=100)',
            '5:15: error[TB207] ForceAbove("left", …): the scene has no "rigth"; did you mean '
            '"right"?',
        ),
        (
            'ForceAbove("left", "goal", newtons=100)',
            '5:15: error[TB207] ForceAbove("left", …): "goal" is no solid; solids: left, right, cu',
        ),
        (
            'ForceAbove("tray", "tray.handle", newtons=100)',
            '5:15: error[TB212] ForceAbove("tray", …): no force is known within one body; name two',
        ),
        (
            'ForceAbove("left", "right", newtons=-1)',
            '5:15: error[TB212] ForceAbove("left", …): newtons is -1; 0 or more',
        ),
        (
            'Sustained(Held("cube"), 0)',
            "5:15: error[TB212] Sustained(…): seconds is 0; more than 0",
        ),
        # values of the wrong sort
        (
            'Held("cube", by=["left"])',
            "5:15: error[TB212] Held(\"cube\", …): by is ['left']; "
            "it must be the name of a robot or a tuple, each the name of a robot",
        ),
        ("Held(5)", "5:15: error[TB212] Held(…): body is 5; it must be the name of a body"),
        ('Once("cube")', "5:15: error[TB212] Once(\"cube\", …): of is 'cube'; it must be a cond"),
        ('Then(Held("cube"), Held)', "5:15: error[TB212] Then(…): of is (Held(body='cube', by=No"),
        (
            'Once(Height("cube"))',
            "5:15: error[TB212] Once(…): of is Height(…); it must be a condition",
        ),
        (
            'AtLeast(1.5, Held("cube"))',
            "5:15: error[TB212] AtLeast(…): count is 1.5; it must be a whole number",
        ),
    ],
)
def test_a_slip_in_an_expression_is_marked_at_that_expression(found, success, message):
    (line,) = found(f"success = {success}", REWARD)
    assert line.startswith(message)


@pytest.mark.parametrize(
    ("reward", "message"),
    [
        (
            'Distance("reach", "left.tpc", "cube", agent="left")',
            '6:15: error[TB207] Distance("reach", …): "left" has no frame "tpc"; '
            'did you mean "tcp"?',
        ),
        (
            'Bonus("done", Held("cube"), 1.0, agent="nobody")',
            '6:15: error[TB207] Bonus("done", …): the scene has no "nobody"; it has: left, right',
        ),
        (
            'Bonus("done", Held("cub"), 1.0)',
            '6:29: error[TB207] Held("cub", …): the scene has no "cub"; did you mean "cube"?',
        ),
        (
            'Bonus("", Held("cube"), 1.0)',
            '6:15: error[TB212] Bonus("", …): has no name; logs show the term by it',
        ),
        ('Bonus(5, Held("cube"), 1.0)', "6:15: error[TB212] Bonus(…): name is 5; it must be text"),
        (
            'Bonus("done", "held", 1.0)',
            "6:15: error[TB212] Bonus(\"done\", …): condition is 'held'; it must be a condition",
        ),
        (
            'Bonus("done", Held("cube"), "much")',
            "6:15: error[TB212] Bonus(\"done\", …): amount is 'much'; it must be a finite number",
        ),
        ('Paid("gain", Held("cube"))', '6:15: error[TB212] Paid("gain", …): measure is Held('),
        (
            'Potential("gain", Height("cube"), 1.0, 1.5)',
            '6:15: error[TB212] Potential("gain", …): discount is 1.5; more than 0, at most 1',
        ),
        (
            'Paid("gain", JointTravel("cabinet.slide"))',
            '6:28: error[TB212] JointTravel("cabinet.slide", …): has no target; '
            "give to, in metres, or to_deg, in degrees",
        ),
        (
            'Paid("gain", JointTravel("cabinet.slide", to_deg=20))',
            '6:28: error[TB212] JointTravel("cabinet.slide", …): "cabinet.slide" slides; '
            "give to, in metres",
        ),
        (
            'Paid("gain", JointTravel("cabinet.hinge", to=0.2))',
            '6:28: error[TB212] JointTravel("cabinet.hinge", …): "cabinet.hinge" turns; '
            "give to_deg, in degrees",
        ),
        (
            'Paid("gain", Closeness("cube", "goal", scale=0))',
            '6:28: error[TB212] Closeness("cube", …): scale is 0; metres, more than 0',
        ),
        (
            'Paid("gain", Fraction(Height("cube"), of=0))',
            "6:28: error[TB212] Fraction(…): of is 0; more than 0",
        ),
        (
            'Paid("gain", Fraction(Height("cube"), of="all"))',
            "6:28: error[TB212] Fraction(\"all\", …): of is 'all'; it must be a finite number",
        ),
        (
            'Paid("gain", Fraction(0.5, of=1))',
            "6:28: error[TB212] Fraction(…): measure is 0.5; it must be a measure",
        ),
        (
            'Paid("gain", 1 - Fraction(Height("cub"), of=1))',
            '6:41: error[TB207] Height("cub", …): the scene has no "cub"; did you mean "cube"?',
        ),
        (
            'Paid("gain", Minimum())',
            "6:28: error[TB212] Minimum(…): it is the least of nothing; give it measures",
        ),
        (
            'Paid("gain", Minimum(Height("cube"), Height("tary")))',
            '6:52: error[TB207] Height("tary", …): the scene has no "tary"; did you mean "tray"?',
        ),
        (
            'Paid("gain", 2 * Height("cub"))',
            '6:32: error[TB207] Height("cub", …): the scene has no "cub"; did you mean "cube"?',
        ),
        (
            'Paid("gain", Ladder(0, (Held("cub"), 1)))',
            '6:39: error[TB207] Held("cub", …): the scene has no "cub"; did you mean "cube"?',
        ),
        (
            'Bonus("a", Held("cube"), 1), Bonus("a", Held("cube"), 2)',
            '6:44: error[TB211] two reward terms are "a"; give each its own name or agent',
        ),
        (
            'Held("cube")',
            "6:15: error[TB210] reward[0] is Held(…); it must be a reward term",
        ),
    ],
)
def test_a_slip_in_the_reward_is_marked_at_its_term(found, reward, message):
    (line,) = found(SUCCESS, f"reward = ({reward},)")
    assert line.startswith(message)


DONE = 'a tuple of terms, such as (Bonus("done", success, 1.0),)'


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (
            [REWARD],
            "4:1: error[TB210] Plain defines no success; write "
            'a condition, such as Inside("cube", "tray")',
        ),
        ([SUCCESS], f"4:1: error[TB210] Plain defines no reward; write {DONE}"),
        ([SUCCESS, "reward = ()"], f"4:1: error[TB210] Plain defines no reward; write {DONE}"),
        ([SUCCESS, "reward = []"], f"4:1: error[TB210] reward is []; it must be {DONE}"),
        (
            [SUCCESS, 'reward = (Bonus("done", Held("cube"), 1.0))'],
            "6:15: error[TB210] reward is Bonus(…); it must be ",
        ),
        ([SUCCESS, 'reward = Held("cube")'], "6:14: error[TB210] reward is Held(…); it must be "),
        (["success = True", REWARD], "4:1: error[TB210] success is True; it must be a cond"),
        (
            ["success = Held", REWARD],
            "4:1: error[TB210] success is the class Held, without its arguments; ",
        ),
        ([SUCCESS, REWARD, 'failure = "never"'], "4:1: error[TB210] failure is 'never'; "),
        ([SUCCESS, REWARD, 'setback = "a drop"'], "4:1: error[TB210] setback is 'a drop'; "),
        (
            [SUCCESS, REWARD, 'setback = Height("cube")'],
            "7:15: error[TB210] setback is Height(…); it must be a condition, such as ",
        ),
        ([SUCCESS, REWARD, "failure = None"], "4:1: error[TB210] Plain defines no failure; "),
        (
            [SUCCESS, REWARD, 'progress = Held("cube")'],
            "7:16: error[TB210] progress is Held(…); it must be a measure, ",
        ),
        ([SUCCESS, REWARD, 'stages = [Held("cube")]'], "4:1: error[TB210] stages is [Held("),
        (
            [SUCCESS, REWARD, 'stages = {"held": Height("cube")}'],
            "7:23: error[TB210] stages['held'] is Height(…); ",
        ),
        (
            [SUCCESS, REWARD, 'stages = {1: Held("cube")}'],
            "7:18: error[TB210] stages[1] is Held(…); ",
        ),
        (
            [SUCCESS, REWARD, 'a = Held("tray")', 'stages = {"a": Held("cube")}'],
            '8:20: error[TB211] the stage "a" is not what the attribute a is; rename one of them',
        ),
        (
            [SUCCESS, REWARD, 'stages = {"success": Held("tray")}'],
            '7:26: error[TB211] the stage "success" is not what the attribute success is; ',
        ),
        (
            [SUCCESS, REWARD, 'spare = Held("cub")'],
            '7:13: error[TB207] Held("cub", …): the scene has no "cub"',
        ),
    ],
)
def test_what_a_description_must_define_is_checked(found, lines, message):
    (line,) = found(*lines)
    assert line.startswith(message)


def test_a_stage_may_be_an_attribute_of_its_name(found):
    assert not found(SUCCESS, REWARD, 'a = Held("tray")', 'stages = {"a": a, "done": success}')


def test_wrong_stages_do_not_hide_a_wrong_progress(found):
    assert len(found(SUCCESS, REWARD, "stages = 1", "progress = 2")) == 2


def test_every_place_of_a_slip_is_told_in_one_run(found):
    lines = found(
        'success = Held("cub") & Near("cube", "gaol", within=0)',
        'reward = (Bonus("a", Held("cub"), 1.0), Distance("b", "cub", "goal"))',
    )
    assert [line[: line.index("]") + 1] for line in lines] == [
        "5:15: error[TB207]",
        "5:29: error[TB207]",
        "5:29: error[TB212]",
        "6:26: error[TB207]",
        "6:45: error[TB207]",
    ]


@pytest.mark.parametrize(
    ("helpers", "success", "message"),
    [
        (
            "@condition\ndef high(world, body: BodyName, of: tuple[RobotName, ...] = ()) -> bool:\n"
            "    return True\n",
            'high("cub")',
            "9:15: error[TB207] high(body='cub', of=()): the scene has no \"cub\"; did you mean",
        ),
        (
            "@condition\ndef high(world, body: BodyName, by: float = 0.0) -> bool:\n"
            "    return True\n",
            'high("cube", by="much")',
            "9:15: error[TB212] high(body='cube', by='much'): by is 'much'; it must be a finite",
        ),
        (
            "@condition\ndef high(world, bodies: list) -> bool:\n    return True\n",
            'high(["cube"])',
            "9:15: error[TB212] high(bodies=['cube']): can change (unhashable type: 'list'); "
            "use @dataclass(frozen=True), and tuples in place of lists",
        ),
        (
            "@dataclass(frozen=True)\nclass Mine(Condition):\n    body: BodyName\n\n\n",
            'Once(Mine("cub"))',
            '11:20: error[TB207] Mine("cub", …): the scene has no "cub"; did you mean "cube"?',
        ),
        (
            "@dataclass\nclass Mine(Condition):\n    body: BodyName\n\n\n",
            'Once(Mine("cube"))',
            "11:20: error[TB212] Mine(\"cube\", …): can change (unhashable type: 'Mine'); "
            "use @dataclass(frozen=True), and tuples in place of lists",
        ),
        (
            "class Mine(Condition):\n    body: BodyName\n\n\n",
            'Mine("cube")',
            "10:15: error[TB212] Mine(…): has fields that are never set; "
            "put @dataclass(frozen=True) on Mine",
        ),
        (
            '@dataclass(frozen=True)\nclass Mine(Condition):\n    body: "Missing"\n\n\n',
            'Mine("cube")',
            "11:15: error[TB212] Mine: its annotations cannot be read (name 'Missing' is not "
            "defined); import what they name, always",
        ),
    ],
)
def test_expressions_of_a_task_s_own_are_checked_like_any(found_in, helpers, success, message):
    (line,) = found_in(helpers, success)
    assert line.startswith(message)


def test_a_term_of_a_task_s_own_needs_a_name(found_in):
    helpers = "@dataclass(frozen=True)\nclass Mine(Term):\n    amount: float\n\n\n"
    found = found_in(helpers, 'Held("cube")\n    reward = (Mine(1.0),)')
    assert found == [
        "12:15: error[TB212] Mine(…): has no name; logs show the term by it",
    ]


def test_a_condition_without_fields_needs_no_decorator(found_in):
    helpers = "class Mine(Condition):\n    def holds(self, world):\n        return True\n\n\n"
    assert found_in(helpers, "Mine()") == []


def test_expressions_of_an_imported_base_class_are_checked_too(found, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "shared_base_of_tasks.py").write_text(
        "from taskbuilder.description import *\n\nclass Base(Description):\n    a = Held('cub')\n"
    )
    lines = "from taskbuilder.description import *\nfrom shared_base_of_tasks import Base\n\n"
    lines += f"class Plain(Base):\n    {SUCCESS}\n    {REWARD}\n"
    (found_there,) = findings(tmp_path, lines)
    assert found_there.startswith("shared_base_of_tasks.py:4:9: error[TB207] Held(")
