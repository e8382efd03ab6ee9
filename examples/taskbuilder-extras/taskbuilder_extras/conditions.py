"""A condition for descriptions: one frame is higher than another."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass

from taskbuilder.description import Condition, FrameName, WorldView
from taskbuilder.schema.names import SceneNames


@dataclass(frozen=True)
class Higher(Condition):
    """The first frame is at least ``by`` metres higher than the second."""

    first: FrameName
    second: FrameName
    _: KW_ONLY
    by: float = 0.0

    def holds(self, world: WorldView) -> bool:
        """Whether the condition is true now."""
        return self._gap(world) >= self.by

    def figure(self, world: WorldView, memory: object, *, wanted: bool) -> str:
        """The measured value and its bound."""
        bound = "at least" if wanted else "less than"
        return f"{100 * self._gap(world):.1f} cm higher, {bound} {100 * self.by:g} cm is needed"

    def problems(self, names: SceneNames) -> Iterator[str]:
        """Invalid values."""
        if not math.isfinite(self.by):
            yield f"by is {self.by!r}; a finite number of metres"

    def _gap(self, world: WorldView) -> float:
        return world.position(self.first)[2] - world.position(self.second)[2]
