"""Each check fails on a task that is made to fail it, and only then."""

from __future__ import annotations

import math

import pytest

CUBE = "place: {center: [0.5, 0, 0.0205], size: [0.1, 0.1, 0]}"
SUCCESS = 'Above("cube", height=0.2)'
OWN = "\n\n@condition\ndef own(world):\n    {}\n\n\nclass Small"

# What is wrong -> the changes, the code, the family in which it shows.
WRONG = {
    "home out of reach": (
        [("[0, 0, 0]}}", "[0, 0, 0]}, home: {tcp: {position: [3, 0, 0.5]}}}")],
        "TB303",
        "build",
    ),
    "one inside another": ([(CUBE, "position: [0.05, 0, 0.05]")], "TB304", "build"),
    "sunk in the floor": ([(CUBE, "position: [0.5, 0, 0.005]")], "TB304", "build"),
    "taken region": ([("[0.5, 0, 0.0205]", "[0, 0, 0.1]")], "TB305", "build"),
    "in the air": ([(CUBE, "position: [0.5, 0, 0.5]")], "TB306", "build"),
    "falls off the world": ([(CUBE, "position: [0.5, 0, -47]")], "TB307", "build"),
    "camera turned away": ([("look_at: [0, 0, 0.3]", "look_at: [0, -4, 1]")], "TB309", "build"),
    "leaves its region": ([("0.0205]", "0.03]")], "TB310", "reset"),
    "solved": ([("height=0.2", "height=0.01")], "TB311", "reset"),
    "failed": ([("height=-0.1", "height=0.1")], "TB312", "reset"),
    "does not vary": (
        [
            (
                "goal: {position: [0.5, 0, 0.3]}",
                "goal: {place: {center: [0, 0, 1], size: [1e-9, 0, 0]}}",
            )
        ],
        "TB313",
        "reset",
    ),
    "raises": (
        [("\n\nclass Small", OWN.format("return 1 / 0")), (SUCCESS, "own()")],
        "TB314",
        "reset",
    ),
    "exits": (
        [("\n\nclass Small", OWN.format("raise SystemExit(3)")), (SUCCESS, "own()")],
        "TB314",
        "reset",
    ),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_check_fails_on_a_task_made_to_fail_it(what, validate):
    changes, code, family = WRONG[what]
    report = validate(*changes)
    assert not report.ok
    assert {finding.code for finding in report.findings} == {code}
    assert [result.name for result in report.families if not result.ok] == [family]
    assert {c.code for f in report.families for c in f.checks if not c.ok} <= {code}


@pytest.mark.parametrize("what", WRONG)
def test_a_finding_points_into_the_file_that_is_wrong(what, validate):
    (finding, *_) = validate(*WRONG[what][0]).findings
    assert finding.location.line > 0
    assert finding.location.file.suffix == (".py" if finding.code in _OF_DESCRIPTIONS else ".yaml")


_OF_DESCRIPTIONS = ("TB311", "TB312", "TB314")


def test_a_sound_task_fails_no_check(validate):
    report = validate()
    assert report.ok
    assert report.findings == ()
    checks = [check for family in report.families for check in family.checks]
    assert all(check.ok for check in checks)
    expected = {code for _, code, _ in WRONG.values()} - {"TB303"} | {"TB308"}
    assert {check.code for check in checks} >= expected


def test_every_figure_is_on_the_right_side_of_its_limit(validate):
    for family in validate().families:
        for check in family.checks:
            assert check.value is not None
            assert math.isfinite(check.value)
            if check.limit is not None and check.code not in ("TB309", "TB313"):
                assert check.value <= check.limit, check
            elif check.limit is not None:
                assert check.value >= check.limit, check


@pytest.mark.parametrize("mass", ["200", "0.0002"])
def test_an_implausible_mass_is_a_warning_and_fails_nothing(mass, validate):
    report = validate(("mass: 0.1", f"mass: {mass}"))
    assert report.ok
    (finding,) = report.findings
    assert (finding.code, finding.severity) == ("TB308", "warning")


def test_bodies_that_overlap_are_told_before_the_physics_throws_them_apart(validate):
    table = "    table: {shape: {box: [1, 1, 0.4]}, fixed: true, position: [0, 0, 0.2]}\n"
    report = validate(("  sites:\n", f"{table}  sites:\n"), (CUBE, "position: [2, 0, 0.02]"))
    assert {finding.code for finding in report.findings} == {"TB304"}


def test_a_fault_of_one_variation_names_it(validate):
    report = validate(
        add="variations:\n  - {cube.color: green}\n  - {cube.place.center: [0.5, 0, 2]}\n"
    )
    (finding,) = [f for f in report.findings if f.code != "TB310"]
    assert (finding.code, finding.path) == ("TB306", "scene.objects.cube")
    assert finding.message.startswith("in variation 2: ")


def test_a_fault_of_all_variations_is_told_once(validate):
    report = validate(
        (CUBE, "position: [0.5, 0, 0.5]"), add="variations:\n  - {cube.color: green}\n"
    )
    assert [finding.message[:4] for finding in report.findings] == ["cube"]


def test_success_at_the_start_names_seed_and_variation(validate):
    changed = "variations:\n  - {goal.position: [0.5, 0, 0.02]}\n"
    near = ('Above("cube", height=0.2)', 'Above("cube", "goal", height=-0.01)')
    report = validate(near, add=changed)
    (finding,) = report.findings
    assert "at the start of 3 of 6 episodes (seed 0, variation 1)" in finding.message
