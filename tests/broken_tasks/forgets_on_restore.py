"""The block at the goal, and the right tool at the lamp."""

from weakref import WeakKeyDictionary

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

steps = WeakKeyDictionary()


@measure
def weariness(world: WorldView) -> float:
    """Control steps of this episode so far."""
    steps[world] = 0 if world.time == 0.0 else steps[world] + 1
    return steps[world]


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
        Paid("tired", weariness(), -0.01),  # found here
    )
