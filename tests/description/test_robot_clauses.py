"""Conditions without the clauses that speak of some robots only."""

from __future__ import annotations

import pytest

from taskbuilder.description import (
    All,
    Any,
    AtLeast,
    Condition,
    EmptyHanded,
    FrameName,
    Held,
    Near,
    On,
    Once,
    Released,
    RobotName,
    Simultaneous,
    Sustained,
    Then,
    WorldView,
    condition,
)
from taskbuilder.description.robot_clauses import without_robots

ROBOTS = ("left", "right", "third")
PLACED = Near("cube", "goal", within=0.05)
BY_LEFT, BY_RIGHT = Held("peg", by="left"), Held("peg", by="right")
POINTING = Near("right.tcp", "lamp", within=0.05)


@condition
def ready(world: WorldView, robot: RobotName, where: FrameName) -> bool:
    return True


def rest(written: Condition, *missing: str) -> Condition | None:
    return without_robots(written, missing or ("right",), ROBOTS).rest


@pytest.mark.parametrize(
    ("written", "left"),
    [
        (PLACED & POINTING, All(PLACED)),
        (PLACED & EmptyHanded("right") & Released("peg", by="right"), All(PLACED)),
        (PLACED & ready("right", "right.home"), All(PLACED)),
        (Sustained(PLACED & BY_RIGHT, 1.0), Sustained(All(PLACED), 1.0)),
        (Once(Then(BY_LEFT, BY_RIGHT, PLACED)), Once(Then(BY_LEFT, PLACED))),
        (PLACED & Held("tray", by=("left", "right")), PLACED & Held("tray", by=("left",))),
        (PLACED & (BY_LEFT | BY_RIGHT), PLACED & Any(BY_LEFT)),
        (PLACED & ~BY_RIGHT, All(PLACED)),
        (PLACED & ~(BY_LEFT | BY_RIGHT), PLACED & ~Any(BY_LEFT)),
        (AtLeast(2, BY_LEFT, BY_RIGHT, PLACED), AtLeast(2, BY_LEFT, PLACED)),
        (AtLeast(3, BY_LEFT, BY_RIGHT, PLACED), AtLeast(2, BY_LEFT, PLACED)),
        (
            Simultaneous(BY_LEFT, BY_RIGHT, within=0.1),
            Simultaneous(BY_LEFT, within=0.1),
        ),
    ],
)
def test_what_is_about_the_missing_robot_only_goes(written, left):
    assert inside(rest(written)) == inside(left)


def inside(node: Condition | None) -> str:
    """A condition as it is written, whether its parts are joined by a sign or listed."""
    return repr(node).replace("All(", "(").replace("Any(", "(")


@pytest.mark.parametrize(
    "written",
    [
        PLACED & On("cube", "tray"),
        PLACED & BY_LEFT,
        PLACED & Near("left.tcp", "right.tcp", within=0.1),  # as much about the left one
        PLACED & Held("peg"),
        Held("peg", by=("left", "third")),
    ],
)
def test_what_is_about_others_as_well_stays(written):
    reduced = without_robots(written, ("right",), ROBOTS)
    assert reduced.rest is written
    assert reduced.dropped == ()


def test_a_success_about_nothing_else_leaves_nothing():
    reduced = without_robots(Sustained(BY_RIGHT & POINTING, 1.0), ("right",), ROBOTS)
    assert reduced.rest is None
    assert reduced.dropped == (BY_RIGHT, POINTING)


def test_clauses_about_several_missing_robots_go_and_are_told():
    third = Held("peg", by="third")
    tray = Held("tray", by=("left", "right", "third"))
    reduced = without_robots(PLACED & ~third & POINTING & tray, ("right", "third"), ROBOTS)
    assert inside(reduced.rest) == inside(PLACED & Held("tray", by=("left",)))
    assert reduced.dropped == (~third, POINTING, Held("tray", by=("right", "third")))


def test_the_condition_itself_does_not_change():
    written = PLACED & BY_RIGHT
    before = repr(written)
    rest(written)
    assert repr(written) == before
