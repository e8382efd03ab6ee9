"""Conditions without the clauses that speak of some of the robots only.

``Near("cube", "goal", within=0.05) & Held("peg", by="right")`` is, without what it says of the
right arm, ``Near("cube", "goal", within=0.05)``. A clause speaks of a robot if it names the robot,
its tool or one of its links. What a function of the description does with its world is not known.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

from taskbuilder.description.contact import Held
from taskbuilder.description.groups import changed
from taskbuilder.description.logic import AtLeast, Once, Simultaneous, Sustained, Then
from taskbuilder.description.node import AllOf, AnyOf, Condition, Not

_OF_ONE = (Not, Once, Sustained)
_OF_MANY = (AllOf, AnyOf, AtLeast, Simultaneous, Then)


class Reduced(NamedTuple):
    """A condition without some of its clauses.

    Attributes:
        rest: What is left of it; None if nothing is.
        dropped: The clauses that were left out, in order.
    """

    rest: Condition | None
    dropped: tuple[Condition, ...] = ()


def without_robots(
    condition: Condition, missing: Collection[str], robots: Collection[str]
) -> Reduced:
    """A condition without the clauses that speak of no other robots than the missing ones.

    Of a clause such as ``Held("tray", by=("left", "right"))``, the part about the missing robot is
    left out. Of alternatives, those about the missing robots are left out and the others stay.

    Args:
        condition: The condition.
        missing: Names of the robots that are missing.
        robots: Names of all robots of the scene.
    """
    if isinstance(condition, _OF_ONE):
        rest, dropped = without_robots(condition.of, missing, robots)
        if rest is None:
            return Reduced(None, (condition,) if isinstance(condition, Not) else dropped)
        return _with(condition, dropped, {"of": rest})
    if isinstance(condition, _OF_MANY):
        return _of_fewer(condition, missing, robots)
    if isinstance(condition, Held) and isinstance(condition.by, tuple):
        return _held_by_fewer(condition, condition.by, missing)
    owners = {name.partition(".")[0] for _, name in condition.references()}
    spoken_of = owners & set(robots)
    is_dropped = spoken_of and spoken_of <= set(missing) and not condition.parts
    return Reduced(None, (condition,)) if is_dropped else Reduced(condition)


def _held_by_fewer(condition: Held, by: tuple[str, ...], missing: Collection[str]) -> Reduced:
    """Held by several robots: by those that are there, and by those that are missing."""
    there = tuple(robot for robot in by if robot not in missing)
    gone = tuple(robot for robot in by if robot in missing)
    dropped = (changed(condition, {"by": gone}),) if gone else ()
    return _with(condition, dropped, {"by": there} if there else None)


def _of_fewer(
    condition: AllOf | AnyOf | AtLeast | Simultaneous | Then,
    missing: Collection[str],
    robots: Collection[str],
) -> Reduced:
    reduced = [without_robots(part, missing, robots) for part in condition.of]
    dropped = tuple(clause for each in reduced for clause in each.dropped)
    rest = tuple(each.rest for each in reduced if each.rest is not None)
    values: dict[str, object] = {"of": rest}
    if isinstance(condition, AtLeast):
        values["count"] = min(condition.count, len(rest))
    return _with(condition, dropped, values if rest else None)


def _with(
    condition: Condition, dropped: tuple[Condition, ...], values: Mapping[str, object] | None
) -> Reduced:
    """A condition with other values, if something was dropped; None if nothing is left."""
    if not dropped:
        return Reduced(condition)
    return Reduced(None if values is None else changed(condition, values), dropped)
