"""For how much of the time that a condition has to hold it has held."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from taskbuilder.description.description import Referee
from taskbuilder.description.logic import Sustained
from taskbuilder.description.node import AllOf, Condition, Node


@dataclass(frozen=True)
class KeptTime:
    """The time for which a condition has held, as a share of what it needs.

    Attributes:
        index: Number of the condition among the referee's expressions.
        seconds: For how long it has to hold; 0 if a moment is enough.
        parts: What it is made of, if it only joins conditions that all have to hold.
    """

    index: int
    seconds: float = 0.0
    parts: tuple[KeptTime, ...] = ()

    def share(self, referee: Referee, time: float) -> float | None:
        """The share of the time, from 0 to 1; None if the condition lacks more than time.

        Args:
            referee: The referee after its latest evaluation.
            time: Seconds since the episode began.
        """
        if self.parts:
            shares = [part.share(referee, time) for part in self.parts]
            kept = [share for share in shares if share is not None]
            return min(kept) if len(kept) == len(shares) else None
        if not self.seconds:
            return 1.0 if referee.values[self.index] else None
        since = referee.memory[0][self.index]
        return None if since is None else min((time - since) / self.seconds, 1.0)


def kept_time(referee: Referee, name: str) -> KeptTime:
    """How the time is read for which a named condition of a description has held."""
    index = {node: position for position, node in enumerate(referee.description.nodes())}
    return _of(referee.description.conditions()[name], index)


def _of(condition: Condition, index: Mapping[Node, int]) -> KeptTime:
    if isinstance(condition, AllOf):
        return KeptTime(index[condition], parts=tuple(_of(part, index) for part in condition.of))
    seconds = condition.seconds if isinstance(condition, Sustained) else 0.0
    return KeptTime(index[condition], seconds)
