"""The block at the goal, and the right tool at the lamp."""

import os

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
def growing(world: WorldView) -> float:
    """A weight that grows with time, for half a second."""
    return world.time if world.time < 0.5 else os._exit(0)  # found here


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
        Paid("waiting", growing(), -1.0),
    )
