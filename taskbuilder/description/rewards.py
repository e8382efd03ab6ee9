"""Reward terms: named, paid at every control step, each to an agent or to the team.

A term without an agent is common to all agents and is shared equally, so that the local rewards
add up to the team reward.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass

from taskbuilder.description.measures import Measure
from taskbuilder.description.node import Condition, FrameName, Memory, Node, Parts, RobotName, Step
from taskbuilder.description.view import WorldView
from taskbuilder.schema.names import SceneNames


class Term(Node):
    """A named part of the reward, with a value at each control step."""

    name: str
    agent: str | None = None

    @property
    def label(self) -> str:
        """The term's name with its agent's, as it appears in logs: ``grasp/left``."""
        return f"{self.name}/{self.agent}" if self.agent else self.name


@dataclass(frozen=True)
class Bonus(Term):
    """A reward of ``amount`` at each control step at which a condition holds, else 0."""

    name: str
    condition: Condition
    amount: float
    _: KW_ONLY
    agent: RobotName | None = None

    @property
    def parts(self) -> tuple[Node, ...]:
        """The condition."""
        return (self.condition,)

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return (self.amount if parts[0] else 0.0), memory


@dataclass(frozen=True)
class Distance(Term):
    """The negative distance between two frames: -weight * |first - second|, in metres."""

    name: str
    first: FrameName
    second: FrameName
    weight: float = 1.0
    _: KW_ONLY
    agent: RobotName | None = None

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        gap = math.dist(world.position(self.first), world.position(self.second))
        return -self.weight * gap, memory


@dataclass(frozen=True)
class Potential(Term):
    """The gain in a measure since the last control step: weight * (discount * now - before).

    If ``discount`` is the discount factor of the learner, this term does not change the optimal
    policies (Ng, Harada and Russell, "Policy invariance under reward transformations", 1999).
    """

    name: str
    measure: Measure
    weight: float = 1.0
    discount: float = 1.0
    _: KW_ONLY
    agent: RobotName | None = None

    @property
    def parts(self) -> tuple[Node, ...]:
        """The measure."""
        return (self.measure,)

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        """The memory is the measure one step before, None at the start."""
        now = parts[0]
        before = self.discount * now if memory is None else memory
        return self.weight * (self.discount * now - before), now

    def problems(self, names: SceneNames) -> Iterator[str]:
        if not 0 < self.discount <= 1:
            yield f"discount is {self.discount}; more than 0, at most 1"


@dataclass(frozen=True)
class Paid(Term):
    """A measure as a reward: weight * measure."""

    name: str
    measure: Measure
    weight: float = 1.0
    _: KW_ONLY
    agent: RobotName | None = None

    @property
    def parts(self) -> tuple[Node, ...]:
        """The measure."""
        return (self.measure,)

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return self.weight * parts[0], memory
