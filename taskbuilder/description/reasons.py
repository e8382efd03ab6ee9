"""Explanations of why a condition does not have the wanted value, by figure and bound."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import Field, dataclass, field, fields, is_dataclass
from types import MappingProxyType
from typing import Any

from taskbuilder.description.custom import CustomCondition
from taskbuilder.description.logic import Once, Sustained
from taskbuilder.description.node import AllOf, AnyOf, Condition, Memory, Node, Not
from taskbuilder.description.view import WorldView

MOST_ALTERNATIVES = 4
"""Maximum number of alternatives that are listed one by one."""


@dataclass(frozen=True)
class Reason:
    """A reason why an episode did not succeed.

    Attributes:
        of: The subject: ``success``, which was false; ``failure``, which held; or ``physics``,
            which diverged.
        part: The part of the condition that is to blame, such as ``Near(stick, goal)``; "" if the
            physics diverged.
        says: Its figure and its bound: "7.3 cm, within 5 cm is needed".
        since: Control step since which the part has this value, 0 for the whole episode; for a
            failure, the step at which it first held.
    """

    of: str
    part: str
    says: str
    since: int

    def __str__(self) -> str:
        if self.of == "physics":
            return f"{self.says} at step {self.since}"
        said = f"{self.part}: {self.says}"
        if self.of == "failure":
            return f"failure held at step {self.since}: {said}"
        return f"{said} ({f'since step {self.since}' if self.since else 'from the start'})"


@dataclass(frozen=True)
class EvaluatedState:
    """A state of an episode, with the values of all nodes so far.

    Attributes:
        world: The world in this state.
        index: Index of each node of the description in the lists of values and memories.
        memories: Memory of every node.
        history: Values of every node at each step so far, the current one last.
        names: The attribute of the description that each condition is, if it is one.
    """

    world: WorldView
    index: Mapping[Node, int]
    memories: Sequence[Memory]
    history: Sequence[Sequence[Any]]
    names: Mapping[Node, str] = field(default_factory=dict)

    def value(self, node: Node) -> Any:
        """What a node's value is now."""
        return self.history[-1][self.index[node]]

    def memory(self, node: Node) -> Memory:
        """What a node remembers."""
        return self.memories[self.index[node]]

    def since(self, node: Node) -> int:
        """Since which state a condition has been as it is now."""
        at, now = self.index[node], bool(self.value(node))
        changed = (n for n, values in enumerate(self.history, 1) if bool(values[at]) != now)
        return max(changed, default=0)

    def longest(self, node: Node) -> int:
        """For how many states in a row a condition held at most."""
        at, best, run = self.index[node], 0, 0
        for values in self.history:
            run = run + 1 if values[at] else 0
            best = max(best, run)
        return best


def reasons(node: Condition, moment: EvaluatedState, *, wanted: bool, of: str) -> list[Reason]:
    """The reasons why a condition does not have the wanted value; empty if it has.

    Args:
        node: A condition of the description.
        moment: The state of the episode.
        wanted: Whether the condition should hold.
        of: The subject of the reasons; see `Reason`.
    """
    if bool(moment.value(node)) == wanted:
        return []
    values = tuple(moment.value(part) for part in node.parts)
    blame = node.blamed(values, moment.memory(node), wanted=wanted)
    if blame is None:
        says = node.figure(moment.world, moment.memory(node), wanted=wanted)
        since = moment.since(node)
        if isinstance(node, Once):
            says += f", first at step {since}" if since else ", from the start"
        return [Reason(of, label(node, moment.names), says, since)]
    found = [reasons(part, moment, wanted=should, of=of) for part, should in blame.parts]
    # A part that is as wanted has no reason to give, such as one that once was not.
    found = [each for each in found if each]
    if blame.every or len(found) == 1:
        listed = [reason for each in found for reason in each]
        return [*dict.fromkeys(listed), *_kept(node, moment, wanted, of)]
    return [_one_of(node, found, moment, of, wanted=wanted)]


def _kept(node: Condition, moment: EvaluatedState, wanted: bool, of: str) -> Iterator[Reason]:
    """For how long what has to last did last, where it no longer does."""
    if not (isinstance(node, Sustained) and wanted):
        return
    longest = moment.longest(node.of)
    if longest:
        step_s = moment.world.time / max(1, len(moment.history) - 1)
        seconds = (longest - 1) * step_s
        if seconds < node.seconds:
            says = f"kept for {seconds:.1f} of {node.seconds:g} s at most"
        else:
            says = f"kept for {seconds:.1f} s, {node.seconds:g} s were needed, but not to the end"
        yield Reason(of, label(node, moment.names), says, moment.since(node))


def _one_of(
    node: Condition,
    found: Sequence[Sequence[Reason]],
    moment: EvaluatedState,
    of: str,
    *,
    wanted: bool,
) -> Reason:
    """Several reasons of which one would have to go, as one; of a failure, what made it up."""
    shown = found[:MOST_ALTERNATIVES]
    said = [" and ".join(f"{r.part}: {r.says}" for r in each) for each in shown]
    more = len(found) - len(shown)
    if more:
        said.append(f"{more} more")
    part, word = ("all of", "and") if of == "failure" and not wanted else ("one of", "or")
    return Reason(of, part, f"; {word} ".join(said), moment.since(node))


def label(node: Condition, names: Mapping[Node, str] = MappingProxyType({})) -> str:
    """A condition by its sort and the names in it: ``Held(stick, by=left)``, ``Once(dropped)``.

    One without names is shown as it is written.

    Args:
        node: The condition.
        names: The attribute of the description that each condition is, if it is one.
    """
    if isinstance(node, CustomCondition):
        return repr(node)
    told: list[str] = []
    listed: tuple[Field[Any], ...] = fields(node) if is_dataclass(node) else ()
    for part in listed:
        texts = [text for text in _names(getattr(node, part.name)) if _is_name(node, text)]
        if texts:
            text = "+".join(texts)
            told.append(f"{part.name}={text}" if part.kw_only else text)
    inner = [names.get(p) or label(p, names) for p in node.parts if isinstance(p, Condition)]
    if isinstance(node, AllOf | AnyOf):
        return f"({(' & ' if isinstance(node, AllOf) else ' | ').join(inner)})"
    if isinstance(node, Not):
        return f"~{inner[0]}"
    told += inner
    return f"{type(node).__name__}({', '.join(told)})" if told else repr(node)


def _names(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from _names(item)


def _is_name(node: Condition, text: str) -> bool:
    """Whether a text is a name in the scene, and not, say, an axis."""
    return any(name == text for _, name in node.references())
