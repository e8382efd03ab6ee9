"""The block at the goal, and the right tool at the lamp."""

from taskbuilder.description import (
    Bonus,
    Description,
    Distance,
    Held,
    Ladder,
    Near,
    Released,
    Sustained,
    Then,
)


class Errand(Description):
    """The left arm brings the block to the goal while the right arm points at the lamp."""

    at_goal = Near("block", "goal", within=0.05)
    pointing = Near("right.tcp", "lamp", within=0.05)

    ready = ~Near("lamp", "dusk", within=0.005) | Sustained(Held("block"), seconds=2.0)

    success = at_goal & pointing
    failure = Then(Held("block"), Released("block"))
    reward = (
        Distance("carry", "block", "goal"),
        Distance("reach", "left.tcp", "block", agent="left"),
        Distance("point", "right.tcp", "lamp", agent="right"),
        Bonus("late", ~success, -1.0),
    )
    progress = Ladder(0.0, (Held("block"), 1.0), (success, 2.0))  # found here
    setback = failure
