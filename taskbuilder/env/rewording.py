"""Instructions in other words, with the same meaning."""

from __future__ import annotations

import re

import numpy as np

FRAMES = (
    "please do the following: {}",
    "your job now: {}",
    "here is what I need: {}; nothing else",
    "we are ready to begin; {}",
    "{}, and take the time that it needs",
    "one more job before we stop: {}",
)
"""What an instruction that is put into other words stands in."""

SYNONYMS = {"bring": "carry", "put": "set", "lift": "raise", "push": "shove", "grasp": "grip"}
"""Other words for verbs."""


def reworded(instruction: str, rng: np.random.Generator) -> str:
    """An instruction in other words."""
    verbs = re.compile(rf"\b({'|'.join(SYNONYMS)})\b")
    text = verbs.sub(lambda verb: SYNONYMS[verb[0]], instruction)
    return FRAMES[int(rng.integers(len(FRAMES)))].format(text)


def longest_reworded(longest: int) -> int:
    """An upper bound of the length of an instruction in other words, in bytes of UTF-8.

    Args:
        longest: The same for instructions as they are written.
    """
    return max(map(len, FRAMES)) + longest + longest // 2  # no synonym is half as long again
