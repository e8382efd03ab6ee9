"""The block is pushed across, picked up and brought to the goal."""

from taskbuilder.description import Below, Bonus, Description, Distance, Held, Near, Sustained


class PushedThenPicked(Description):
    """Neither arm reaches from where the block begins to the goal."""

    there = Held("block", by="right") & Near("block", "goal", within=0.05)

    success = Sustained(there, seconds=1.0)
    failure = Below("block", height=0.35)
    reward = (
        Distance("push", "left.tcp", "block", agent="left"),
        Distance("reach", "right.tcp", "block", agent="right"),
        Distance("carry", "block", "goal"),
        Bonus("there", there, 2.0),
    )
