"""An episode to learn from, wherever it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Demonstration(NamedTuple):
    """An episode of the expert, or of a data set.

    Attributes:
        seed: Seed passed to `reset`.
        actions: (steps, n) float32 by agent; commands to binary grippers are at every step.
        first_success: The first control step with success, or None.
    """

    seed: int
    actions: Mapping[str, NDArray[np.float32]]
    first_success: int | None
