"""An observation channel: how fast an object is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from taskbuilder.env.foreign_channels import ChannelReader

FASTEST = 10.0
"""Upper bound of the channel, m/s."""


@dataclass(frozen=True)
class Speed(ChannelReader):
    """The speed of an object's frame in the world: ``cube.speed``."""

    meaning = "linear speed, m/s"

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number."""
        return ("speed",)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number."""
        return ((0.0, FASTEST),)

    def read(self, episode: Any) -> Sequence[float]:
        """The current values."""
        linear, _ = episode.world.velocity(self.subject)
        return (math.hypot(*linear),)
