"""What the full level says of tasks that are wrong; that it finds them is shown by the codes."""

from __future__ import annotations

import math
import re

import pytest

from taskbuilder import parallel_env, validate_task
from taskbuilder.validate.observing import Views

pytestmark = pytest.mark.in_process

NEEDS, PAYS = "needs its robots", "pays for success"
SUCCESS = 'Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)'
BRING = "  - {left: {bring: cube, to: goal}}\n"
OWN = "\n\n@{kind}\ndef own(world):\n    {body}\n\n\nclass Pair"


def own(kind, body, *, use):
    """Changes that write a function of one's own and use it as an attribute."""
    return (
        ("\n\nclass Pair", OWN.format(kind=kind, body=body)),
        ("    stages =", f"    {use}\n    stages ="),
    )


def codes(report):
    return {finding.code for finding in report.findings}


def failed(report):
    return [family.name for family in report.families if not family.ok]


class TestAMistakeInTheMiddle:
    def test_is_found_at_its_line_wherever_it_shows_first(self, prove):
        late = own("measure", "return 1 / (0.95 - world.time > 0)", use="progress = own()")
        report = prove(*late, only=("repeat", "solvable", NEEDS, "cost"))
        (finding,) = report.findings
        assert (finding.code, finding.location.line) == ("TB314", 8)
        assert "ZeroDivisionError" in finding.message
        assert failed(report) == ["repeat"]
        assert report.skipped == ("solvable", NEEDS, "cost")

    def test_is_found_in_another_process(self, write_pair):
        late = own("measure", "return 1 / (0.95 - world.time > 0)", use="progress = own()")
        report = validate_task(write_pair(*late), seeds=1, jobs=2, only=("solvable",))
        assert codes(report) == {"TB314"}

    def test_is_found_where_only_the_tests_of_libraries_see_it(self, prove, monkeypatch):
        monkeypatch.setattr("taskbuilder.validate.checks.contract.watch", lambda *_: Views())
        late = own("measure", "return 1 / (world.time < 0.05)", use="progress = own()")
        without_expert = (PAIR_EXPERT, "")
        report = prove(*late, without_expert, only=("contract",))
        assert codes(report) == {"TB314"}

    def test_of_what_is_given_back_is_one_of_the_description(self, prove):
        term = (
            "\n\nclass Pair",
            "\n\nclass Odd(Term):\n    name = 'odd'\n\n"
            "    def update(self, world, parts, memory):\n"
            "        return 'much', memory\n\n\nclass Pair",
        )
        used = ("    reward = (\n", "    reward = (\n        Odd(),\n")
        imported = (
            "description import *",
            "description import *\nfrom taskbuilder.description.rewards import Term",
        )
        report = prove(term, used, imported, only=("reset",))
        (finding,) = report.findings
        assert finding.code == "TB314"
        assert "Odd gave 'much'; a reward term pays a number" in finding.message
        assert finding.location.file.name == "pair.py"


PAIR_EXPERT = "expert:\n  - {left: {grasp: cube.top}, right: {reach: lamp}}\n" + BRING


class TestRepeat:
    def test_the_part_that_differs_is_named_where_it_is_written(self, prove):
        odd = own("condition", "return random.random() > 0.5", use="odd = own()")
        (finding,) = prove(*odd, only=("repeat",)).findings
        assert (finding.code, finding.path) == ("TB501", "odd")
        assert finding.location.line == 13
        assert "condition/odd" in finding.message

    def test_one_that_is_seeded_at_import_depends_on_episodes_before(self, prove):
        odd = own("measure", "return random.random()", use="progress = own()")
        seeded = ("import random\n", "import random\n\nrandom.seed(1)\n")
        assert codes(prove(*odd, seeded, only=("repeat",))) == {"TB502"}

    def test_a_push_that_comes_late_is_seen(self, prove):
        push = "world.time > 0.5 and world.robots['left'].move_gripper(0.3)\n    return False"
        (finding,) = prove(
            *own("condition", push, use="failure = own()"), only=("repeat",)
        ).findings
        assert finding.code == "TB505"
        assert "from step 6 on: left" in finding.message


class TestReach:
    def test_the_finding_tells_stage_robot_and_how_far(self, prove):
        far = ("goal: {position: [-0.2, -0.1, 0.2]}", "goal: {position: [0.5, -0.1, 0.2]}")
        report = prove(far, only=("reach",), seeds=2)
        (finding,) = report.findings
        assert (finding.code, finding.path) == ("TB511", "expert[1].left")
        assert finding.message.startswith("left cannot reach what it is to bring cube to goal")
        assert "from 4 of 4 placements" in finding.message
        assert finding.message.endswith(
            "; move it, or the base of left, by as much, or let right do it, which can reach it"
        )
        check = next(check for check in report.families[-1].checks if check.code == "TB511")
        assert -50 < check.value < -10

    def test_what_nobody_reaches_is_left_to_nobody(self, prove):
        far = ("goal: {position: [-0.2, -0.1, 0.2]}", "goal: {position: [0, 3, 0.2]}")
        (finding,) = prove(far, only=("reach",)).findings
        assert "even 0.5 m nearer would be out of reach; " in finding.message
        assert finding.message.endswith("; turn the tool otherwise, or bring it nearer to left")

    @pytest.mark.parametrize(
        ("z", "far", "right"),
        [
            (0.0095, "13 mm inside", "move the grasp point 13 mm back against its approach"),
            (0.0405, "18 mm above", "move the grasp point 18 mm on along its approach"),
            (0.4, "more than ", "put the grasp point on the surface that the cup comes to"),
        ],
    )
    def test_suction_on_nothing_says_which_way_the_surface_is(self, prove, z, far, right):
        cup = ("left:\n      model: ur5e\n", "left:\n      model: ur5e_suction\n")
        point = ("top: {at: [0, 0, 0.01]", f"top: {{at: [0, 0, {z}]")
        found = prove(cup, point, only=("reach",)).findings
        (finding,) = (one for one in found if one.code == "TB512")
        assert f"cube.top is {far}" in finding.message
        assert right in finding.message
        mended = ("top: {at: [0, 0, 0.01]", "top: {at: [0, 0, 0.0225]")
        assert "TB512" not in codes(prove(cup, mended, only=("reach",)))

    def test_the_margin_is_that_of_the_arm(self, prove):
        """Straight out at shoulder's height, a UR5e's tcp comes about 0.9 m far."""
        moved = ("goal: {position: [-0.2, -0.1, 0.2]}", "goal: {position: [0.0, 0.0, 0.16]}")
        only_reach = (PAIR_EXPERT, "expert: [{left: {reach: goal}}]\n")
        checks = prove(moved, only_reach, only=("reach",)).families[-1].checks
        check = next(check for check in checks if check.code == "TB511")
        assert 10 < check.value < 25


class TestContract:
    def test_seeing_only_oneself_is_not_enough(self, prove):
        blind = ("right: [self.tcp, cube.position]}", "right: [self.tcp]}")
        (finding,) = prove(blind, only=("contract",), seeds=2).findings
        assert (finding.code, finding.path) == ("TB525", "observe.right")
        assert "in every episode" in finding.message

    def test_where_nothing_is_placed_anew_it_is(self, prove):
        blind = ("right: [self.tcp, cube.position]}", "right: [self.tcp]}")
        fixed = ("size: [0.1, 0.1, 0]", "size: [0, 0, 0]")
        assert prove(blind, fixed, only=("contract",), seeds=2).ok


class TestSolvable:
    def test_what_keeps_the_expert_is_counted_and_the_first_seed_told(self, prove):
        slippery = ("mass: 0.08", "mass: 0.08\n      friction: 0.0")
        report = prove(slippery, only=("solvable",), seeds=2)
        (finding,) = report.findings
        assert (finding.code, finding.path[:6]) == ("TB531", "expert")
        assert "0/2 (0–66 %)" in finding.message
        assert "2 × " in finding.message
        assert "seed 0, stage " in finding.message
        assert [d.success for d in report.families[-1].rollouts] == [False] * 3

    def test_what_got_lost_on_the_way_is_told_beside_where_it_failed(self, prove):
        lifted = "left: [{bring: cube, to: cube, above: 0.12}, {bring: cube, to: [9, 0, 0]}]"
        away = ("left: {bring: cube, to: goal}", lifted)
        low = (SUCCESS, 'Below("cube", height=0.1) & Near("cube", "lamp", within=0.02)')
        (finding,) = prove(away, low, only=("solvable",), seeds=2).findings
        assert "stage 2 (left: bring cube to [9, 0, 0]): " in finding.message
        assert re.search(r"; Below\(cube.*\): .* cm high, .* \(since step \d+\)", finding.message)

    def test_an_episode_that_fails_is_named_although_nearly_all_succeed(self, prove, tmp_path):
        spot = ("    lamp:", "    spot: {position: [-0.46, -0.26, 0.023]}\n    lamp:")
        one = ("\nvariations:\n  - {cube.color: green}", "")
        prove(spot, one, only=("reset",), seeds=1)
        env = parallel_env(tmp_path / "pair.yaml")
        away = []
        for seed in range(20):
            env.reset(seed=seed)
            position = env.episode.world.position
            away.append(math.dist(position("cube"), position("spot")))
        env.close()
        nearest, next_one = sorted(away)[:2]
        near = f'    failure = Near("cube", "spot", within={(nearest + next_one) / 2})\n'
        fails = ("    stages =", f"{near}    stages =")
        report = prove(spot, one, fails, only=("solvable",), seeds=20)
        family = report.families[-1]
        assert report.ok
        assert family.summary.startswith("19/20")
        assert f"; fails from seed {away.index(nearest)}: " in family.summary

    def test_a_variation_that_fails_is_named(self, prove):
        far = ("{cube.color: green}", "{goal.position: [-0.2, -0.1, 0.7]}")
        high = ("{left: {bring: cube, to: goal}}", "{left: {bring: cube, to: cube, above: 0.1}}")
        always = (SUCCESS, 'Above("cube", height=0.1) & Above("goal", height=0.5)')
        report = prove(far, high, always, only=("solvable",))
        (finding,) = report.findings
        assert "in variation" not in finding.message  # it is the plain scene that fails
        swapped = (always[0], always[1].replace('Above("goal", height', 'Below("goal", height'))
        (finding,) = prove(far, high, swapped, only=("solvable",)).findings
        assert finding.message.startswith("in variation 1: ")
        assert "; Below(goal): 70.0 cm high, less than 50 cm is needed (from the start)" in (
            finding.message
        )

    def test_time_that_is_wanting_is_told_as_such(self, prove):
        short = ("episode_steps: 30", "episode_steps: 17")
        held = (SUCCESS, f"Sustained({SUCCESS}, 0.5)")
        (finding,) = prove(short, held, only=("solvable",)).findings
        assert (finding.code, finding.path) == ("TB532", "timing.episode_steps")


class TestNeeds:
    LEFT_ALONE = (SUCCESS, 'Near("cube", "goal", within=0.05)')

    def test_what_is_optional_is_measured_but_no_finding(self, prove):
        optional = ("timing:", "cooperation: optional\ntiming:")
        report = prove(self.LEFT_ALONE, optional, only=(NEEDS,))
        assert report.findings == ()
        values = {check.code: check.value for check in report.families[-1].checks}
        assert values["TB541"] == 1
        assert values["TB542"] >= 1
        assert "frozen right 1" in report.families[-1].summary

    def test_the_simplest_way_that_succeeds_is_told_alone(self, prove):
        anything = (SUCCESS, 'Sustained(Above("left.tcp", height=0.01), 0.5)')
        report = prove(anything, only=(NEEDS,))
        assert codes(report) == {"TB544"}
        assert [check.code for check in report.families[-1].checks] == ["TB544"]

    def test_lifting_is_tried_where_no_place_is_named(self, prove):
        lifted = (SUCCESS, 'Above("cube", height=0.15)')
        waits = (PAIR_EXPERT, "expert:\n  - right: {reach: lamp}\n")
        (finding,) = prove(lifted, waits, only=(NEEDS,)).findings
        assert (finding.code, finding.path) == ("TB542", "success")
        assert finding.message.startswith("left alone, cube.top up succeeds from 1/1")

    def test_one_robot_needs_no_other(self, write):
        report = validate_task(write(), seeds=1, only=(NEEDS,))
        assert report.families[-1].summary == "random 0, nothing 0"


class TestClausesAboutOneRobot:
    """Success that names a robot needs it by its words; the rest may not need it."""

    PLACED = 'Near("cube", "goal", within=0.05)'

    def test_what_all_else_is_reached_without_is_a_warning_at_its_clause(self, prove, tmp_path):
        report = prove(only=(NEEDS,))
        (finding,) = report.findings
        assert report.ok
        assert (finding.code, finding.severity) == ("TB546", "warning")
        assert finding.path == "success"
        line = (tmp_path / "pair.py").read_text().splitlines()[finding.location.line - 1]
        assert line[finding.location.column - 1 :].startswith('Near("right.tcp"')
        assert finding.message.startswith(
            "right is needed only because success asks for Near(right.tcp, lamp): "
        )
        assert re.search(
            r" reaches all else from 1/1 \(\d+–100 %\) seeds \(seed 0\); ", str(finding)
        )

    def test_alternatives_about_the_robot_do_not_hide_it(self, prove):
        pointing, holding = 'Near("right.tcp", "lamp", within=0.05)', 'Held("cube", by="right")'
        either = (SUCCESS, f"{self.PLACED} & ({pointing} | {holding})")
        (finding,) = prove(either, only=(NEEDS,)).findings
        assert finding.code == "TB546"
        assert "Near(right.tcp, lamp) and Held(cube, by=right): " in finding.message

    def test_what_the_others_cannot_do_needs_it(self, prove):
        away = ("goal: {position: [-0.2, -0.1, 0.2]}", "goal: {position: [0.5, -0.1, 0.2]}")
        report = prove(away, only=(NEEDS,))
        assert report.findings == ()
        values = {check.code: check.value for check in report.families[-1].checks}
        assert values["TB546"] == 0

    @pytest.mark.parametrize(
        "success",
        [
            'Held("cube", by="right") & Released("cube", by="left")',
            f'{PLACED} & Below("cube", height=0.05) & Near("right.tcp", "lamp", within=0.05)',
        ],
        ids=["from the start", "never"],
    )
    def test_what_nobody_has_to_reach_or_can_reach_says_nothing(self, prove, success):
        assert prove((SUCCESS, success), only=(NEEDS,)).findings == ()

    def test_what_is_optional_is_no_finding(self, prove):
        optional = ("timing:", "cooperation: optional\ntiming:")
        assert prove(optional, only=(NEEDS,)).findings == ()


class TestPays:
    def test_a_term_that_is_not_finite_is_named(self, prove):
        endless = own(
            "measure", 'return float("inf") if world.held("cube", "left") else 0.0', use=""
        )
        used = ("    reward = (\n", '    reward = (\n        Paid("mean", own()),\n')
        report = prove(*endless, used, only=(PAYS,))
        (finding,) = report.findings
        assert (finding.code, finding.path) == ("TB551", "reward.mean")
        assert "paid inf" in finding.message

    def test_an_expert_that_never_succeeds_proves_nothing(self, prove):
        report = prove(("episode_steps: 30", "episode_steps: 2"), only=(PAYS,), seeds=2)
        (finding,) = report.findings
        assert (finding.code, finding.path) == ("TB531", "expert")
        assert "the expert does not succeed with any seed" in finding.message

    def test_ending_the_episode_early_ends_costs(self, prove):
        ends = ("episode_steps: 30", "episode_steps: 30, ends_on: [failure]")
        costly = (
            "    stages =",
            '    lifted = Once(Held("cube"))\n    failure = lifted & Released("cube")\n'
            "    stages =",
        )
        paid = (
            '        Distance("carry", "cube", "goal"),\n',
            '        Bonus("time", Near("cube", "goal", within=9.0), -1.0),\n'
            '        Bonus("done", success, 0.5),\n',
        )
        report = prove(ends, costly, paid, only=(PAYS,))
        (finding,) = report.findings
        assert finding.code == "TB555"
        assert finding.message.startswith(("dropping everything, or throwing it away, after",))

    def test_what_few_seeds_leave_undecided_is_played_from_more(self, prove):
        dice = ("    lamp:", "    dice: {place: {center: [0, 0, 1], size: [0, 0, 2]}}\n    lamp:")
        paid = (
            '        Distance("carry", "cube", "goal"),\n'
            '        Distance("point", "right.tcp", "lamp", agent="right"),\n',
            '        Paid("luck", Ladder(0.0, (success, Height("dice")))),\n',
        )
        report = prove(dice, paid, only=(PAYS,), seeds=2)
        assert report.ok
        (summary,) = (family.summary for family in report.families if family.name == PAYS)
        assert int(re.search(r"(\d+) pairs", summary)[1]) in (4, 8, 16, 32, 40)

    HELD_PAYS = (
        '        Distance("carry", "cube", "goal"),\n'
        '        Distance("point", "right.tcp", "lamp", agent="right"),\n'
    )

    @pytest.mark.parametrize(("weight", "near"), [(0.01, True), (10.0, False)])
    def test_a_lead_that_is_sure_but_tiny_is_a_warning(self, prove, tmp_path, weight, near):
        paid = f'Distance("carry", "cube", "goal", {weight}), Bonus("hold", Held("cube"), 1.0),\n'
        report = prove((self.HELD_PAYS, f"        {paid}"), only=(PAYS,), seeds=3)
        assert report.ok
        assert codes(report) == ({"TB559"} if near else set())
        (check,) = (check for check in report.families[-1].checks if check.code == "TB559")
        assert (check.value < 0.02) is near
        for finding in report.findings:
            assert (finding.severity, finding.path) == ("warning", "reward")
            line = (tmp_path / "pair.py").read_text().splitlines()[finding.location.line - 1]
            assert 'Distance("carry"' in line
            assert finding.message.startswith("stalling after stage 1 (")
            assert f"only {100 * check.value:.1f} % of that over " in finding.message

    def test_a_robot_that_may_idle_may_be_left_out(self, prove):
        optional = ("timing:", "cooperation: optional\ntiming:")
        carried = (SUCCESS, 'Near("cube", "goal", within=0.05)')
        unpaid = ('        Distance("point", "right.tcp", "lamp", agent="right"),\n', "")
        report = prove(optional, carried, unpaid, only=(NEEDS, PAYS))
        assert report.findings == ()
        assert "TB554" not in {check.code for check in report.families[-1].checks}


@pytest.mark.parametrize("family", ["reach", "solvable", NEEDS, PAYS])
def test_without_an_expert_the_rest_is_checked(family, prove):
    report = prove((PAIR_EXPERT, ""), only=(family,))
    assert report.ok
    assert codes(report) == ({"TB533"} if family == "solvable" else set())
