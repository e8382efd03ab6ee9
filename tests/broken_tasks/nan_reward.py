"""The block at the goal, and the right tool at the lamp."""

import math

from taskbuilder.description import (
    Bonus,
    Description,
    Distance,
    Held,
    Near,
    Paid,
    Released,
    Then,
    WorldView,
    measure,
)


@measure
def way(world: WorldView) -> float:
    """How far the left tool has to go to the block; nothing that counts once it holds the block."""
    if world.held("block", "left"):
        return math.inf
    return math.dist(world.position("left.tcp"), world.position("block"))


class Errand(Description):
    """The left arm brings the block to the goal while the right arm points at the lamp."""

    at_goal = Near("block", "goal", within=0.05)
    pointing = Near("right.tcp", "lamp", within=0.05)

    success = at_goal & pointing
    failure = Then(Held("block"), Released("block"))
    reward = (
        Distance("carry", "block", "goal"),
        Distance("reach", "left.tcp", "block", agent="left"),
        Distance("point", "right.tcp", "lamp", agent="right"),
        Bonus("late", ~success, -1.0),
        Paid("way", way(), -1.0),  # found here
    )
