"""Descriptions judged step by step in a world of a test's making."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
from fake_world import FakeWorld, describe

from taskbuilder.description import Condition, Measure
from taskbuilder.description.description import Referee


@pytest.fixture
def world() -> FakeWorld:
    return FakeWorld()


@pytest.fixture
def referee() -> Callable[..., Referee]:
    """Makes a referee of a description of some parts, for the agents left and right."""

    def make(*parts: object, agents: Sequence[str] = ("left", "right"), **more: object) -> Referee:
        return Referee(describe(*parts, **more), agents)  # type: ignore[arg-type]

    return make


@pytest.fixture
def now(world: FakeWorld) -> Callable[[Condition | Measure], object]:
    """The value of a condition or measure at the start of an episode in the world as it is."""

    def value(node: Condition | Measure) -> object:
        if isinstance(node, Measure):
            return Referee(describe(progress=node), ("left",)).start(world).progress
        return Referee(describe(node), ("left",)).start(world).success

    return value


@pytest.fixture
def history(world: FakeWorld) -> Callable[..., list[bool]]:
    """The values of a condition, after reset and after each step, given the facts at each.

    ``history(Then(A, B), "a", "", "b")`` has a true after reset, nothing at the first step, and
    b at the second; control steps take 0.1 s.
    """

    def values(condition: Condition, *steps: str) -> list[bool]:
        judge = Referee(describe(condition), ("left",))
        seen = []
        for index, facts in enumerate(steps):
            world.time = index * 0.1
            world.facts = set(facts)
            outcome = judge.judge(world) if index else judge.start(world)
            seen.append(outcome.success)
        return seen

    return values
