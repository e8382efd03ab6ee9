"""The block at the goal, and the right tool at the lamp."""

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

SCHEDULE = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)


@measure
def growing(world: WorldView) -> float:
    """A weight that grows with time, for ten control steps."""
    return SCHEDULE[round(20 * world.time)]  # found here


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
