"""Keys that identify who played an episode: the expert, random actions, a stall and so on."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any


class BaselineKind(StrEnum):
    """Kinds of baselines; the values are stable, and stand in reports."""

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
class Baseline:
    """Who plays an episode that others are compared with, or is the policy that is compared.

    Attributes:
        kind: What kind of baseline.
        stage: Stage of the expert, from 1, after which the expert is left; 0 for other kinds.
        robot: Who is left out, or tries something alone; "" for other kinds.
        attempt: What is tried alone; its ``str`` is shown.
    """

    kind: BaselineKind
    stage: int = 0
    robot: str = ""
    attempt: Hashable = None

    def __str__(self) -> str:
        match self.kind:
            case BaselineKind.STALL | BaselineKind.FAIL:
                return f"{self.kind} after stage {self.stage}"
            case BaselineKind.WITHOUT:
                return f"without {self.robot}"
            case BaselineKind.ALONE:
                return f"{self.robot} alone, {self.attempt}"
            case _:
                return self.kind.value

    def as_data(self) -> dict[str, Any]:
        """The baseline as plain data; what is tried alone is left to the text."""
        return {"kind": self.kind.value, "stage": self.stage or None, "robot": self.robot or None}


EXPERT = Baseline(BaselineKind.EXPERT)
RANDOM = Baseline(BaselineKind.RANDOM)
NOTHING = Baseline(BaselineKind.NOTHING)
