"""The block at the goal, and the right tool at the lamp."""  # found here

from typing import Any

from taskbuilder.description import (
    Bonus,
    Description,
    Distance,
    Duration,
    Near,
    condition,
)


@condition
def sunk(world: Any) -> bool:
    """The block is below the floor, from where it is lifted at once."""
    block = world.objects["block"].body
    block.place(block.pose().moved((0.0, 0.0, 0.001)))
    return world.position("block")[2] < 0.0


class Errand(Description):
    """The left arm brings the block to the goal while the right arm points at the lamp."""

    at_goal = Near("block", "goal", within=0.05)
    pointing = Near("right.tcp", "lamp", within=0.05)

    success = at_goal & pointing
    failure = sunk()
    reward = (
        Distance("carry", "block", "goal"),
        Distance("reach", "left.tcp", "block", agent="left"),
        Distance("point", "right.tcp", "lamp", agent="right"),
        Bonus("late", ~success, -1.0),
    )
    progress = Duration(success)
    setback = failure
