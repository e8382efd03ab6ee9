"""Collaborative Lift: success and reward."""

from taskbuilder.description import (
    Below,
    Bonus,
    Closeness,
    Description,
    Distance,
    Duration,
    ForceAbove,
    Fraction,
    Height,
    Held,
    Ladder,
    Level,
    Minimum,
    Near,
    On,
    Once,
    Speed,
    Sustained,
    Then,
)


class CollaborativeLift(Description):
    """Both arms lift the tray by its handles, level, until the cube on it reaches the goal."""

    at_goal = Near("cube", "goal", within=0.05)
    lifted = Held("tray.left_handle", by="left") & Held("tray.right_handle", by="right")
    carried = lifted & ~On("tray", "table")
    presented = at_goal & lifted & Level("tray", within_deg=10) & On("cube", "tray")

    success = Sustained(presented, seconds=1.0)
    failure = (
        Below("tray", height=0.35)
        | Below("cube", "tray", height=-0.02)
        | ForceAbove("left", "right", newtons=100)
    )
    stages = {
        "both held": lifted,
        "in the air": carried,
        "at goal": presented,
        "kept there": success,
    }
    reward = (  # equation (2)
        Bonus("grasp", Held("tray.left_handle", by="left"), 1.0, agent="left"),
        Bonus("grasp", Held("tray.right_handle", by="right"), 1.0, agent="right"),
        Distance("reach", "left.tcp", "tray.left_handle", agent="left"),
        Distance("reach", "right.tcp", "tray.right_handle", agent="right"),
        Distance("lift", "cube", "goal"),
        Bonus("goal", at_goal, 4.0),
    )

    lowest = Minimum(
        Height("tray.left_handle", "table.top"), Height("tray.right_handle", "table.top")
    )
    grip = 0.5 * Closeness("left.tcp", "tray.left_handle_top", scale=0.06) + 0.5 * Closeness(
        "right.tcp", "tray.right_handle_top", scale=0.06
    )
    slow = (
        1.0 - 0.5 * Fraction(Speed("cube"), of=0.15) - 0.5 * Fraction(Speed("cube"), of=0.6)
    )  # falls up to the arms' full speed
    progress = Ladder(
        0.5 * Closeness("left.tcp", "tray.left_handle_top")
        + 0.5 * Closeness("right.tcp", "tray.right_handle_top")
        + 0.5 * grip
        + Ladder(0.0, (Held("tray.left_handle", by="left"), 0.5))
        + Ladder(0.0, (Held("tray.right_handle", by="right"), 0.5)),
        (
            lifted & On("cube", "tray"),
            3.0
            + 0.5 * grip
            + 0.5 * Fraction(lowest - 0.05, of=0.05)
            + 3.0 * (0.4 + 0.6 * grip) * Closeness("cube", "goal", scale=0.2)
            + Closeness("cube", "goal", scale=0.08) * (0.5 + 1.5 * slow)
            + 2.0 * Fraction(Duration(carried), of=1.0)
            + Ladder(0.0, (presented, 2.5 * slow + 2.0 * Fraction(Duration(presented), of=1.0))),
        ),
        (success, 16.5),
    )

    setback = Then(carried, Sustained(~lifted & ~Once(success), seconds=0.3))
