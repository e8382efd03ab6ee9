"""The description of a task, and the referee that evaluates it at every control step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import itemgetter
from typing import Any, ClassVar, SupportsFloat

from taskbuilder.description.groups import expanded, is_about_each
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
from taskbuilder.geometry import total
from taskbuilder.schema.names import SceneNames


class Description:
    """Base class for the description of a task, which defines success and reward.

    Attributes:
        success: Condition that is true when the task is done. Required.
        failure: Condition that is true when the task can no longer be done.
        stages: Milestones: conditions by name, in the order in which they become true.
        reward: The reward terms, which are added up at every control step. Required.
        progress: Measure of how much of the task is done, for training rewards; it is not part of
            the reward.
        setback: Condition that is true when the robots have lost something that they had achieved,
            such as their grasp of an object; training may then end the episode.
    """

    success: ClassVar[Condition]
    failure: ClassVar[Condition] = Never()
    stages: ClassVar[Mapping[str, Condition]] = {}
    reward: ClassVar[tuple[Term, ...]]
    progress: ClassVar[Measure | None] = None
    setback: ClassVar[Condition] = Never()

    @classmethod
    def attributes(cls) -> dict[str, Condition]:
        """All attributes of the class that are conditions, including inherited attributes."""
        everything = {name: getattr(cls, name) for base in cls.__mro__ for name in vars(base)}
        return {name: value for name, value in everything.items() if isinstance(value, Condition)}

    @classmethod
    def conditions(cls) -> dict[str, Condition]:
        """All named conditions: success, failure, stages and other attributes."""
        first = {"success": cls.success, "failure": cls.failure}
        return {**first, **cls.stages, **cls.attributes()}

    @classmethod
    def nodes(cls) -> tuple[Node, ...]:
        """Every distinct expression, parts first."""
        progress = (cls.progress,) if cls.progress is not None else ()
        return tuple(
            walk((*cls.conditions().values(), *cls.stages.values(), *cls.reward, *progress))
        )


def with_members(description: type[Description], names: SceneNames) -> type[Description]:
    """A checked description with the groups of its scene written out, member by member.

    A condition about each member of a group, of which only others say of how many it must be true,
    has no value of its own, and is no attribute any more.
    """
    if not names.groups:
        return description
    mentioned = {key: None for base in description.__mro__ for key in vars(base)}
    own = {key: getattr(description, key) for key in mentioned if not key.startswith("__")}
    values = {
        key: None if is_about_each(value, names) else expanded(value, names)
        for key, value in own.items()
    }
    changed = {key: value for key, value in values.items() if value is not own[key]}
    about = {"__module__": description.__module__, "__doc__": description.__doc__}
    return type(description.__name__, (description,), {**about, **changed})


@dataclass(frozen=True, slots=True)
class Outcome:
    """The result of evaluating a description at one control step.

    Attributes:
        success: Whether the success condition holds now.
        failure: Whether the failure condition holds now.
        stage: Number of the furthest stage reached so far in this episode; 0 for none.
        progress: Value of the description's progress; 0.0 if the description has no progress.
        conditions: Value of every named condition.
        terms: Value of every reward term by label, in the order of the description; the label is
            ``NAME``, or ``NAME/AGENT`` for a term with an agent.
        local: Each agent's local reward: its own terms plus an equal share of the common terms.
        team: The team reward: the sum of the local rewards, added in the order of the agents.
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
    """A node's checked value and its memory."""
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
    """Evaluates a description on a world, and keeps the memory of the description in one value.

    Every distinct expression of the description is evaluated once after reset and once after each
    control step, parts first, never short-circuited. `memory` is immutable: save it with a snapshot
    of the physics, and restore it to continue from there.

    Attributes:
        force_pairs: Pairs of bodies whose contact forces the world must measure, before `start`.
        values: Value of every node at the last evaluation; see `moment`.
    """

    def __init__(self, description: type[Description], agents: Sequence[str]) -> None:
        self.description = description
        self.agents = tuple(agents)
        named, stages = description.conditions(), description.stages.values()
        self._nodes = description.nodes()
        # Values of a description's own nodes are checked; those of the library need no check.
        self._updates = tuple(
            node.update if is_ours(type(node).update) else partial(_looked_at, node)
            for node in self._nodes
        )
        # Indices into the list of nodes, so that no node is hashed during evaluation.
        index = {node: position for position, node in enumerate(self._nodes)}
        self._parts = tuple(_picking([index[part] for part in node.parts]) for node in self._nodes)
        self._conditions = tuple((name, index[node]) for name, node in named.items())
        self._stages = tuple(index[node] for node in stages)
        self._terms = tuple((t.label, t.agent, index[t]) for t in description.reward)
        self._progress = None if description.progress is None else index[description.progress]
        pairs = (pair for node in self._nodes for pair in node.force_pairs())
        self.force_pairs = tuple(dict.fromkeys(pairs))
        self.memory: tuple[tuple[Memory, ...], int] = ((), 0)
        self.values: Sequence[Any] = ()

    def start(self, world: WorldView) -> Outcome:
        """Begin an episode: clear the memory, and evaluate the world after reset."""
        self.memory = (tuple(node.start(world) for node in self._nodes), 0)
        return self.judge(world)

    def judge(self, world: WorldView) -> Outcome:
        """Evaluate the world after a control step."""
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
        """The last evaluated state, for finding reasons.

        Args:
            world: The world in this state.
            history: `values` after every evaluation of the episode, the last one included.
        """
        index = {node: position for position, node in enumerate(self._nodes)}
        names = {self._nodes[position]: name for name, position in reversed(self._conditions)}
        return EvaluatedState(world, index, self.memory[0], history, names)

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
        return Outcome(
            success=conditions["success"],
            failure=conditions["failure"],
            stage=stage,
            progress=values[self._progress] if self._progress is not None else 0.0,
            conditions=conditions,
            terms=terms,
            local=local,
            team=total(local.values()),
        )
