"""A task's description, and the referee that applies it to a world step by step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import itemgetter
from typing import Any, ClassVar, SupportsFloat

from taskbuilder.description.logic import Never
from taskbuilder.description.measures import Measure
from taskbuilder.description.node import (
    Condition,
    Memory,
    Node,
    Parts,
    Step,
    ValueOfNodeError,
    walk,
)
from taskbuilder.description.origin import is_ours
from taskbuilder.description.reasons import EvaluatedState
from taskbuilder.description.rewards import Term
from taskbuilder.description.view import WorldView


class Description:
    """Success and reward; one subclass in the file beside a task's YAML.

    Attributes:
        success: When the task is done. Required.
        failure: When it can no longer be done.
        stages: Milestones by name, in the order in which they come.
        reward: The terms that are paid at every control step. Required.
        progress: How far the task is, for training signals; never part of the reward.
        setback: When going on teaches little, such as after a drop: training may end there.
    """

    success: ClassVar[Condition]
    failure: ClassVar[Condition] = Never()
    stages: ClassVar[Mapping[str, Condition]] = {}
    reward: ClassVar[tuple[Term, ...]]
    progress: ClassVar[Measure | None] = None
    setback: ClassVar[Condition] = Never()

    @classmethod
    def attributes(cls) -> dict[str, Condition]:
        """The conditions among the class's attributes, inherited ones too."""
        everything = {name: getattr(cls, name) for base in cls.__mro__ for name in vars(base)}
        return {name: value for name, value in everything.items() if isinstance(value, Condition)}

    @classmethod
    def conditions(cls) -> dict[str, Condition]:
        """Every condition that has a name: success, failure, stages and other attributes."""
        first = {"success": cls.success, "failure": cls.failure}
        return {**first, **cls.stages, **cls.attributes()}


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the referee says of one control step.

    Attributes:
        success: The success condition holds now.
        failure: The failure condition holds now.
        stage: How many stages have been reached so far: the last one ever to hold counts.
        progress: The description's progress, or 0.0.
        conditions: Value of every named condition.
        terms: Pay of every reward term by label, in the description's order.
        local: Each agent's own pay plus its even share of what is common.
        team: The sum of the agents' pay, in their order.
    """

    success: bool
    failure: bool
    stage: int
    progress: float
    conditions: Mapping[str, bool]
    terms: Mapping[str, float]
    local: Mapping[str, float]
    team: float


def _looked_at(node: Node, world: WorldView, parts: Parts, memory: Memory) -> Step:
    """A node's value and memory, the value being of the right sort."""
    step = node.update(world, parts, memory)
    if not isinstance(step, tuple) or len(step) != 2:
        raise ValueOfNodeError(node, step, "update gives a value and a memory")
    value, kept = step
    if isinstance(node, Condition):
        return node.truth(value), kept
    if isinstance(node, Measure):
        return node.number_of(value), kept
    if isinstance(node, Term) and not isinstance(value, SupportsFloat):
        raise ValueOfNodeError(node, value, "a reward term pays a number")
    return value, kept


def _picking(positions: Sequence[int]) -> Callable[[Sequence[Any]], Parts]:
    """What picks the values at some positions out of a list, in their order."""
    if len(positions) > 1:
        return itemgetter(*positions)
    return lambda values: tuple([values[position] for position in positions])


class Referee:
    """Applies a description to a world; remembers what the description needs, in one value.

    Every distinct expression of the description is evaluated once after reset and once after each
    control step, parts first, never short-circuited. `memory` is immutable: keep it beside a
    snapshot of the physics and set it back to continue from there.

    Attributes:
        force_pairs: The bodies between which the world must meter forces, from before `start`.
        values: Value of every node when the world was last judged; see `moment`.
    """

    def __init__(self, description: type[Description], agents: Sequence[str]) -> None:
        self.description = description
        self.agents = tuple(agents)
        named = description.conditions()
        progress = (description.progress,) if description.progress is not None else ()
        stages = description.stages.values()
        roots: tuple[Node, ...] = (*named.values(), *stages, *description.reward, *progress)
        self._nodes = tuple(walk(roots))
        # What a description's own nodes give in their own ways is looked at; ours cannot go wrong.
        self._updates = tuple(
            node.update if is_ours(type(node).update) else partial(_looked_at, node)
            for node in self._nodes
        )
        # Where in the list of nodes everything is, so that no node is hashed while judging.
        index = {node: position for position, node in enumerate(self._nodes)}
        self._parts = tuple(_picking([index[part] for part in node.parts]) for node in self._nodes)
        self._conditions = tuple((name, index[node]) for name, node in named.items())
        self._stages = tuple(index[node] for node in stages)
        self._terms = tuple((t.label, t.agent, index[t]) for t in description.reward)
        self._progress = index[progress[0]] if progress else None
        pairs = (pair for node in self._nodes for pair in node.force_pairs())
        self.force_pairs = tuple(dict.fromkeys(pairs))
        self.memory: tuple[tuple[Memory, ...], int] = ((), 0)
        self.values: Sequence[Any] = ()

    def start(self, world: WorldView) -> Outcome:
        """Forget the last episode and judge the world as it stands after reset."""
        self.memory = (tuple(node.start(world) for node in self._nodes), 0)
        return self.judge(world)

    def judge(self, world: WorldView) -> Outcome:
        """Judge the world after a control step."""
        memories, stage = self.memory
        values: list[Any] = []
        remembered = []
        for update, parts_of, memory in zip(self._updates, self._parts, memories, strict=True):
            value, kept = update(world, parts_of(values), memory)
            values.append(value)
            remembered.append(kept)
        for number, reached in enumerate(self._stages, start=1):
            stage = max(stage, number) if values[reached] else stage
        self.memory = (tuple(remembered), stage)
        self.values = values
        return self._outcome(values, stage)

    def moment(self, world: WorldView, history: Sequence[Sequence[Any]]) -> EvaluatedState:
        """The world as it was last judged, to ask for reasons.

        Args:
            world: The same.
            history: `values` after every judgement of the episode, the last one included.
        """
        index = {node: position for position, node in enumerate(self._nodes)}
        return EvaluatedState(world, index, self.memory[0], history)

    def _outcome(self, values: list[Any], stage: int) -> Outcome:
        conditions = {name: values[position] for name, position in self._conditions}
        local = dict.fromkeys(self.agents, 0.0)
        common = 0.0
        terms = {}
        for label, agent, position in self._terms:
            pay = terms[label] = values[position]
            if agent is None:
                common += pay
            else:
                local[agent] += pay
        share = common / len(local)
        local = {agent: own + share for agent, own in local.items()}
        team = 0.0
        for pay in local.values():  # not sum(), whose rounding differs between Python versions
            team += pay
        return Outcome(
            success=conditions["success"],
            failure=conditions["failure"],
            stage=stage,
            progress=values[self._progress] if self._progress is not None else 0.0,
            conditions=conditions,
            terms=terms,
            local=local,
            team=team,
        )
