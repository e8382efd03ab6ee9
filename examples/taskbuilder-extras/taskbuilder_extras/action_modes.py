"""An action mode: positions of joints as fractions of their ranges."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from taskbuilder.env.arm_modes import ArmMode


@dataclass(frozen=True)
class JointRangeMode(ArmMode):
    """Moves each joint towards a fraction of its range: 0 is the lower limit, 1 the upper one."""

    space = "joint"

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number."""
        return tuple(f"joint_{number}_fraction" for number in range(1, len(self._limits) + 1))

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number."""
        return ((0.0, 1.0),) * len(self._limits)

    def after(self, joints: Sequence[float], values: Sequence[float], /) -> Sequence[float]:
        """The commanded joint positions after an action, as far as a control step allows."""
        pairs = zip(values, self._limits, strict=True)
        return self.arm.approach(
            joints, [low + share * (high - low) for share, (low, high) in pairs]
        )

    def leading_to(self, joints: Sequence[float], start: Sequence[float], /) -> Sequence[float]:
        """The action that commands the arm to given joint positions."""
        pairs = zip(joints, self._limits, strict=True)
        return [(joint - low) / (high - low) for joint, (low, high) in pairs]

    @property
    def _limits(self) -> list[tuple[float, float]]:
        """The range of each joint; a full turn either way where it has no limits."""
        ranges = zip(self.arm.ik.lower, self.arm.ik.upper, strict=True)
        turn = (-2.0 * math.pi, 2.0 * math.pi)
        return [(low, high) if math.isfinite(high - low) else turn for low, high in ranges]
