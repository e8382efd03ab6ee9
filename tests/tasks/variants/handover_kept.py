"""The handover with the constants of its reward in the wrong order."""

from taskbuilder.description import (
    Below,
    Bonus,
    Description,
    Distance,
    ForceAbove,
    Held,
    Near,
    Sustained,
)


class HandoverKept(Description):
    """Both hold the stick for 1 each; letting go gives that up for a handover that pays 0.5."""

    taken = Held("stick", by="left")
    shared = Held("stick", by=("left", "right"))
    handed_over = Held("stick", by="right") & ~Held("stick", by="left")

    at_goal = handed_over & Near("stick", "goal", within=0.05)

    success = Sustained(at_goal, seconds=1.0)
    failure = Below("stick", height=0.35) | ForceAbove("left", "right", newtons=100)
    stages = {
        "taken": taken,
        "shared": shared,
        "handed over": handed_over,
        "at goal": at_goal,
        "kept there": success,
    }
    reward = (
        Bonus("grasp", Held("stick", by="left"), 1.0, agent="left"),
        Bonus("grasp", Held("stick", by="right"), 1.0, agent="right"),
        Distance("reach", "left.tcp", "stick", agent="left"),
        Distance("reach", "right.tcp", "stick", agent="right"),
        Distance("carry", "stick", "goal"),
        Bonus("handover", handed_over, 0.5),
    )
