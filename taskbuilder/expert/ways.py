"""Keys that identify how an episode was played: by the expert, at random, stalling and so on."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any


class Kind(StrEnum):
    """Kinds of ways; the values are stable, and stand in reports."""

    POLICY = "policy"
    """The policy that is evaluated."""

    EXPERT = "expert"
    NOTHING = "nothing"
    RANDOM = "random"

    STALL = "stall"
    """The expert up to the end of a stage, then holding still."""

    FAIL = "fail"
    """The expert up to the end of a stage, then dropping what is held, or throwing it away."""

    WITHOUT = "without"
    """The expert, while one robot holds still."""

    ALONE = "alone"
    """One robot tries something by itself."""


@dataclass(frozen=True)
class Way:
    """A way of playing a task.

    Attributes:
        kind: What kind of way.
        stage: Stage of the expert, from 1, after which its way is left; 0 for other kinds.
        robot: Who is left out, or tries something alone; "" for other kinds.
        attempt: What is tried alone; its ``str`` is shown.
    """

    kind: Kind
    stage: int = 0
    robot: str = ""
    attempt: Hashable = None

    def __str__(self) -> str:
        match self.kind:
            case Kind.STALL | Kind.FAIL:
                return f"{self.kind} after stage {self.stage}"
            case Kind.WITHOUT:
                return f"without {self.robot}"
            case Kind.ALONE:
                return f"{self.robot} alone, {self.attempt}"
            case _:
                return self.kind.value

    def as_data(self) -> dict[str, Any]:
        """The way as plain data; what is tried alone is left to the text."""
        return {"kind": self.kind.value, "stage": self.stage or None, "robot": self.robot or None}


EXPERT, RANDOM, NOTHING = Way(Kind.EXPERT), Way(Kind.RANDOM), Way(Kind.NOTHING)
