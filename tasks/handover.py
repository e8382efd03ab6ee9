"""Handover: success and reward."""

from taskbuilder.description import (
    Below,
    Bonus,
    Closeness,
    Description,
    Distance,
    Duration,
    ForceAbove,
    Fraction,
    GripperOpening,
    Height,
    Held,
    Ladder,
    Near,
    Once,
    Speed,
    Sustained,
    Then,
)


class Handover(Description):
    """The left arm gives the stick to the right arm, which brings it to the goal."""

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
    reward = (  # equation (3)
        Bonus("grasp", Held("stick", by="left"), 1.0, agent="left"),
        Bonus("grasp", Held("stick", by="right"), 1.0, agent="right"),
        Distance("reach", "left.tcp", "stick", agent="left"),
        Distance("reach", "right.tcp", "stick", agent="right"),
        Distance("carry", "stick", "goal"),
        Bonus("handover", handed_over, 2.0),
    )

    lift = Fraction(Height("stick", "table.top"), of=0.1)
    slow = 1.0 - Fraction(Speed("stick"), of=0.5)
    progress = Ladder(
        0.5 * Closeness("left.tcp", "stick.left_end") + 0.15 * Closeness("right.tcp", "goal"),
        (
            taken,
            1.25
            + 0.25 * lift
            + 0.75 * Closeness("stick", "meeting", scale=0.3)
            + 0.75 * lift * Closeness("right.tcp", "stick.right_end", scale=0.6)
            + 1.5 * lift * Closeness("right.tcp", "stick.right_end", scale=0.15)
            + 0.5 * lift * GripperOpening("right"),
        ),
        (
            taken & Near("right.tcp", "stick.right_end", within=0.025),
            5.0 + 0.75 * (1.0 - GripperOpening("right")),
        ),
        (shared, 6.0),
        (
            handed_over,
            6.9
            - 0.15 * Closeness("left.tcp", "stick.left_end")
            + 2.0 * Closeness("stick", "goal", scale=0.5)
            + Closeness("stick", "goal", scale=0.15) * (0.75 + slow),
        ),
        (at_goal, 10.75 + 1.5 * slow + 2.0 * Fraction(Duration(at_goal), of=1.0)),
        (success, 14.75),
    )

    held = taken | Held("stick", by="right")
    setback = Then(held, Sustained(~held & ~Once(success), seconds=0.3))
