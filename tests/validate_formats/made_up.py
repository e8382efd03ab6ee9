"""Episodes and texts as they might be, made up."""

from __future__ import annotations

import numpy as np

from taskbuilder.expert.demonstration import Demonstration, Trouble

NASTY = "<script>&\"'\x1b[31m\udc80"
"""What would be markup, or what no document can hold."""


def played(seed: int, *, success: bool, trouble: Trouble | None = None) -> Demonstration:
    """An episode of the handover in which everyone holds still."""
    still = np.zeros((4, 5), dtype=np.float32)
    return Demonstration(
        "handover",
        seed,
        0,
        {"left": still, "right": still},
        np.zeros(4),
        {},
        success,
        3 if success else None,
        "",
        (1, 2) if success else (),
        trouble,
    )
