"""Conditions made of other conditions: counting, order and duration."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from taskbuilder.description.groups import times
from taskbuilder.description.node import (
    AllOf,
    AnyOf,
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
class All(AllOf):
    """All given conditions hold; a condition on a group must hold for every member."""

    gathers = True

    def __init__(self, *of: Condition) -> None:
        object.__setattr__(self, "of", of)

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from _listed(self.of)

    def __repr__(self) -> str:
        return f"All({', '.join(map(repr, self.of))})"


@dataclass(frozen=True, init=False)
class Any(AnyOf):
    """At least one condition holds; a condition on a group must hold for at least one member."""

    gathers = True

    def __init__(self, *of: Condition) -> None:
        object.__setattr__(self, "of", of)

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from _listed(self.of)

    def __repr__(self) -> str:
        return f"Any({', '.join(map(repr, self.of))})"


def _listed(of: tuple[Condition, ...]) -> Iterator[str]:
    if not of:
        yield "lists no condition; give at least one"


@dataclass(frozen=True, init=False)
class AtLeast(Condition):
    """At least ``count`` of the given conditions hold; each member of a group counts as one."""

    gathers = True

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
        given = sum(times(part, names) for part in self.of)
        if not 1 <= self.count <= given:
            yield f"count is {self.count}; from 1 to the {given} conditions given"


@dataclass(frozen=True, init=False)
class Then(Condition):
    """Several conditions have come true in the given order.

    Each condition must be true at the control step at which the previous condition came true, or at
    a later step. The conditions need not stay true.
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
        yield from _listed(self.of)


@dataclass(frozen=True, init=False)
class Simultaneous(Condition):
    """Several conditions became true within ``within`` seconds of each other.

    For each condition, only its latest change from false to true in this episode counts. The
    conditions need not stay true. Once ``Simultaneous`` is true, it stays true until the end of the
    episode.
    """

    gathers = True

    of: tuple[Condition, ...]
    within: float = field(kw_only=True)

    def __init__(self, *of: Condition, within: float) -> None:
        object.__setattr__(self, "of", of)
        object.__setattr__(self, "within", within)

    @property
    def parts(self) -> tuple[Node, ...]:
        """The conditions, in order."""
        return self.of

    def start(self, world: WorldView) -> Memory:
        """Whether it has come about, the values before, and when each last became true."""
        return False, (True,) * len(self.of), (None,) * len(self.of)

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        done, before, times_ = memory
        pairs = zip(parts, before, times_, strict=True)
        times_ = tuple(world.time if now and not then else at for now, then, at in pairs)
        done = done or _apart(times_) <= self.within + _TIME_SLACK
        return done, (done, tuple(parts), times_)

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        if not wanted:
            return "it has come about"
        missing = sum(at is None for at in memory[2])
        if missing:
            return f"{missing} of {len(self.of)} have not become true"
        return f"{_apart(memory[2]):.2g} s apart, within {self.within:g} s is needed"

    def problems(self, names: SceneNames) -> Iterator[str]:
        if sum(times(part, names) for part in self.of) < 2:
            yield "compares the moments of several conditions; give two or more"
        if not self.within >= 0:
            yield f"within is {self.within}; seconds, 0 or more"


def _apart(moments: tuple[float | None, ...]) -> float:
    """Time from the first to the last moment; infinite if one has not come."""
    known = [at for at in moments if at is not None]
    return max(known) - min(known) if len(known) == len(moments) else math.inf


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
        return Blame(((self.of, wanted),)) if wanted or parts[0] else None

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        return "has held before"
