"""Demonstrations that are turned about the vertical, as if the scene had stood otherwise.

If everything around a robot is turned about the vertical through its base, the right motion of its
tool is turned with it: gravity is the same, and its first joint makes up for the rest. So each
demonstration shows what to do in many more scenes (compare Wang et al. 2022 on equivariant
policies, which have this symmetry built in).

In the frame of a tool nothing changes. In that of the base, horizontal coordinates turn in pairs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

_OBSERVED = (("x", "y"), ("r11", "r21"), ("r12", "r22"), ("vx", "vy"), ("wx", "wy"))
_COMMANDED = (("dx", "dy"), ("drx", "dry"))
_PREVIOUS = tuple((f"previous_{x}", f"previous_{y}") for x, y in _COMMANDED)
_QUATERNIONS = ("qx", "qy", "qz", "qw")


@dataclass(frozen=True)
class Turns:
    """Which numbers of a robot turn when the scene is turned.

    Attributes:
        observed: (n, 2) the columns of the observed numbers that turn, x and y of a vector each.
        commanded: (n, 2) the same of its actions.
    """

    observed: NDArray[np.int64]
    commanded: NDArray[np.int64]

    @property
    def of_tool(self) -> bool:
        """Whether it is commanded by motions of its tool, which turn; those of joints do not."""
        return len(self.commanded) > 0


def turns_of(agent: str, observed: Sequence[str], commanded: Sequence[str]) -> Turns | None:
    """How a robot's numbers turn, or None where it observes something in another way.

    Args:
        agent: The robot.
        observed: Names of the numbers that it observes.
        commanded: Names of the numbers of its action, in the frame of its base.
    """
    base = f" in {agent}.base"
    acts = {name.removeprefix(f"{agent}."): n for n, name in enumerate(commanded)}
    motions = _pairs((acts[x], acts[y]) for x, y in _COMMANDED if x in acts)
    if not len(motions):
        return Turns(motions, motions)
    if any(name.startswith(f"{agent}.joint_") for name in observed):
        return None  # its first joint turns the other way
    parts = [name.removesuffix(base).rpartition(".") for name in observed]
    mine = [name.endswith(base) for name in observed]
    if any(own and part in _QUATERNIONS for own, (_, _, part) in zip(mine, parts, strict=True)):
        return None
    places = {f"{of}.{part}": n for n, (of, _, part) in enumerate(parts) if mine[n]}
    owners = dict.fromkeys(of for n, (of, _, _) in enumerate(parts) if mine[n])
    own = {part: n for n, (of, _, part) in enumerate(parts) if of == agent}
    scene = (
        (places[f"{of}.{x}"], places[f"{of}.{y}"])
        for of in owners
        for x, y in _OBSERVED
        if f"{of}.{x}" in places
    )
    before = ((own[x], own[y]) for x, y in _PREVIOUS if x in own)
    return Turns(_pairs(chain(scene, before)), motions)


def _pairs(columns: Iterator[tuple[int, int]]) -> NDArray[np.int64]:
    return np.array(list(columns), np.int64).reshape(-1, 2)
