"""Conditions made of other conditions: counting, order and duration."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from taskbuilder.description.node import (
    Blame,
    Condition,
    Memory,
    Node,
    Parts,
    Step,
    blame_those,
)
from taskbuilder.description.view import WorldView
from taskbuilder.schema.names import SceneNames

_TIME_SLACK = 1e-9  # seconds; times are sums of control steps


@dataclass(frozen=True)
class Never(Condition):
    """Always false."""

    def holds(self, world: WorldView) -> bool:
        return False

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        return "can never hold"


@dataclass(frozen=True, init=False)
class AtLeast(Condition):
    """At least ``count`` of several conditions hold."""

    count: int
    of: tuple[Condition, ...]

    def __init__(self, count: int, *of: Condition) -> None:
        object.__setattr__(self, "count", count)
        object.__setattr__(self, "of", of)

    @property
    def parts(self) -> tuple[Node, ...]:
        """The conditions, in order."""
        return self.of

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return sum(parts) >= self.count, memory

    def blamed(self, parts: Parts, memory: Memory, *, wanted: bool) -> Blame | None:
        found = blame_those(self.of, parts, wanted=wanted, every=False)
        surplus = self.count - sum(parts) if wanted else sum(parts) - self.count + 1
        return found._replace(every=surplus >= len(found.parts))

    def problems(self, names: SceneNames) -> Iterator[str]:
        if not 1 <= self.count <= len(self.of):
            yield f"count is {self.count}; from 1 to the {len(self.of)} conditions given"


@dataclass(frozen=True, init=False)
class Then(Condition):
    """Several conditions have come true in this order.

    Each must hold at the control step at which the one before it came true, or at a later one. None
    has to keep holding.
    """

    of: tuple[Condition, ...]

    def __init__(self, *of: Condition) -> None:
        object.__setattr__(self, "of", of)

    @property
    def parts(self) -> tuple[Node, ...]:
        """The conditions, in order."""
        return self.of

    def start(self, world: WorldView) -> Memory:
        """The number of conditions that have come true."""
        return 0

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        while memory < len(parts) and parts[memory]:
            memory += 1
        return memory == len(parts), memory

    def blamed(self, parts: Parts, memory: Memory, *, wanted: bool) -> Blame | None:
        return Blame(((self.of[memory], True),)) if wanted and self.of else None

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        return "never comes true" if wanted else "all of it has come true, in order"

    def problems(self, names: SceneNames) -> Iterator[str]:
        if not self.of:
            yield "lists no condition; give at least one"


@dataclass(frozen=True)
class Sustained(Condition):
    """A condition has held without a break for at least ``seconds``."""

    of: Condition
    seconds: float

    @property
    def parts(self) -> tuple[Node, ...]:
        """The one condition."""
        return (self.of,)

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        """The memory is the time since which the condition holds."""
        if not parts[0]:
            return False, None
        since = world.time if memory is None else memory
        return world.time - since >= self.seconds - _TIME_SLACK, since

    def blamed(self, parts: Parts, memory: Memory, *, wanted: bool) -> Blame | None:
        return None if wanted and parts[0] else Blame(((self.of, wanted),))

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        return f"kept for {world.time - memory:.1f} of {self.seconds:g} s"

    def problems(self, names: SceneNames) -> Iterator[str]:
        if not self.seconds > 0:
            yield f"seconds is {self.seconds}; more than 0"


@dataclass(frozen=True)
class Once(Condition):
    """A condition holds now, or has held before in this episode."""

    of: Condition

    @property
    def parts(self) -> tuple[Node, ...]:
        """The one condition."""
        return (self.of,)

    def start(self, world: WorldView) -> Memory:
        """Whether it has held."""
        return False

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        held = memory or parts[0]
        return held, held

    def blamed(self, parts: Parts, memory: Memory, *, wanted: bool) -> Blame | None:
        return Blame(((self.of, True),)) if wanted else None

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        return "has held before"
