"""Conditions, measures and terms of a task's own, by decorator and by subclass."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np
import pytest

from taskbuilder.description import (
    AtLeast,
    BodyName,
    Bonus,
    Condition,
    FrameName,
    Measure,
    Near,
    Paid,
    RobotName,
    Term,
    WorldView,
    condition,
    measure,
)
from taskbuilder.description.node import Memory, Parts, Step


@condition
def higher(world: WorldView, upper: BodyName, lower: BodyName, by: float = 0.0) -> bool:
    """One thing is higher than another."""
    return world.position(upper)[2] > world.position(lower)[2] + by


@measure
def height_of_all(world: WorldView, bodies: tuple[BodyName, ...]) -> float:
    return sum(world.position(body)[2] for body in bodies)


@dataclass(frozen=True)
class HeldByAll(Condition):
    """Held by every one of several robots, or by any."""

    body: BodyName
    robots: tuple[RobotName, ...] | RobotName | None = None

    def holds(self, world: WorldView) -> bool:
        robots = (self.robots,) if isinstance(self.robots, str) else self.robots
        return all(world.held(self.body, robot) for robot in robots or world.robot_names)


@dataclass(frozen=True)
class Farthest(Measure):
    """How far a frame has ever been from the origin."""

    frame: FrameName

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        far = max(memory or 0.0, max(map(abs, world.position(self.frame))))
        return far, far


@dataclass(frozen=True)
class Flat(Term):
    """Pays the same at every step."""

    name: str
    amount: float
    _: KW_ONLY
    agent: RobotName | None = None

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return self.amount, memory


@dataclass(frozen=True)
class ForAll(Term):
    """A term whose class has no agent: common to all."""

    name: str

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return 1.0, memory


def references(node) -> list[tuple[str, str]]:
    return list(node.references())


def test_a_decorated_function_is_a_condition_of_its_arguments(world, now):
    world.put("cube", 0.0, 0.0, 0.2)
    assert now(higher("cube", "tray")) is True
    assert now(higher("cube", lower="tray", by=0.3)) is False
    assert now(~higher("tray", "cube") & higher("cube", "tray")) is True


def test_a_decorated_function_keeps_its_name_and_docstring():
    assert higher.__name__ == "higher"
    assert higher.__doc__ == "One thing is higher than another."
    assert repr(higher("a", "b")) == "higher(upper='a', lower='b', by=0.0)"


def test_calls_with_the_same_arguments_are_one_value():
    assert higher("a", "b") == higher("a", lower="b", by=0.0)
    assert higher("a", "b") != higher("b", "a")
    assert len({higher("a", "b"), higher("a", "b", 0.0)}) == 1


def test_arguments_that_do_not_fit_the_function_are_refused_where_it_is_called():
    with pytest.raises(TypeError, match="missing a required argument: 'lower'"):
        higher("cube")
    with pytest.raises(TypeError, match="unexpected keyword argument 'lowr'"):
        higher("cube", "tray", lowr="tray")


def test_a_decorated_function_can_be_a_measure(world, now):
    world.put("cube", 0.0, 0.0, 0.2)
    world.put("tray", 0.0, 0.0, 0.3)
    assert now(1 + height_of_all(("cube", "tray"))) == pytest.approx(1.5)


def test_names_among_annotated_arguments_are_known_by_their_kind():
    assert references(higher("cube", "tray")) == [("body", "cube"), ("body", "tray")]
    assert references(height_of_all(("a", "b"))) == [("body", "a"), ("body", "b")]
    assert references(HeldByAll("cube", ("left", "right"))) == [
        ("body", "cube"),
        ("robot", "left"),
        ("robot", "right"),
    ]
    assert references(HeldByAll("cube", "left")) == [("body", "cube"), ("robot", "left")]
    assert references(HeldByAll("cube")) == [("body", "cube")]
    assert references(Flat("pay", 1.0, agent="left")) == [("robot", "left")]
    assert references(Near("a", "b", within=1.0) & Near("c", "d", within=1.0)) == []


def test_a_condition_may_be_a_class_of_its_own(world, now):
    world.holds = {("cube", "left")}
    assert now(HeldByAll("cube", "left")) is True
    assert now(HeldByAll("cube")) is False


def test_a_measure_may_have_a_memory(world, referee):
    judge = referee(progress=Farthest("cube"))
    world.put("cube", 0.5, 0.0, 0.0)
    assert judge.start(world).progress == 0.5
    world.put("cube", 0.1, 0.0, 0.0)
    assert judge.judge(world).progress == 0.5
    assert judge.start(world).progress == 0.1


def test_a_term_may_be_a_class_of_its_own(world, referee):
    outcome = referee(None, Flat("flat", 2.0, agent="left"), ForAll("all")).start(world)
    assert outcome.terms == {"flat/left": 2.0, "all": 1.0}
    assert outcome.local == {"left": 2.5, "right": 0.5}


@condition
def numpys(world: WorldView) -> bool:
    return np.bool_(True)


@dataclass(frozen=True)
class Several(Condition):
    """True by a number that counts for more than one."""

    def holds(self, world: WorldView) -> bool:
        return 3


def test_what_is_true_in_a_way_of_its_own_counts_as_plain_truth(now):
    assert now(numpys()) is True
    assert now(Several()) is True
    assert now(AtLeast(2, Several(), numpys() & ~numpys())) is False


@measure
def numpys_number(world: WorldView) -> float:
    return np.float32(0.5)


def test_a_number_of_numpy_becomes_a_plain_one(world, now, referee):
    assert type(now(numpys_number())) is float
    outcome = referee(None, Paid("x", numpys_number()), Bonus("y", numpys(), 1.0)).start(world)
    assert type(outcome.team) is float
