"""Stack Together: success and reward."""

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
    Held,
    Ladder,
    Near,
    On,
    Once,
    Released,
    Stationary,
    Sustained,
    Then,
)


class StackTogether(Description):
    """The left arm sets its cube on the mark; the right arm stacks its own on it."""

    lower_held = Held("lower", by="left")
    upper_held = Held("upper", by="right")
    on_mark = Near("lower", "mark", within=0.04) & On("lower", "table.top")
    founded = on_mark & Released("lower")
    on_top = founded & On("upper", "lower") & ~On("upper", "table")
    stacked = on_top & Released("upper") & Stationary("upper")

    success = Sustained(stacked, seconds=1.0)
    failure = (
        Below("lower", height=0.35)
        | Below("upper", height=0.35)
        | ForceAbove("left", "right", newtons=100)
    )
    stages = {
        "both held": lower_held & upper_held,
        "lower cube on the mark": founded,
        "upper cube on top": on_top,
        "stacked": stacked,
        "kept there": success,
    }
    reward = (
        Distance("reach", "left.tcp", "lower", agent="left"),
        Distance("reach", "right.tcp", "upper", agent="right"),
        Distance("carry", "lower", "on_mark"),
        Distance("carry_up", "upper", "on_lower"),
        Bonus("grasp", lower_held, 0.5, agent="left"),
        Bonus("grasp", upper_held, 0.5, agent="right"),
        Bonus("foundation", founded, 2.0),
        Bonus("stack", stacked, 4.0),
    )

    progress = Ladder(
        0.5 * Closeness("left.tcp", "lower.top")
        + 0.5 * Closeness("right.tcp", "upper.top")
        + Ladder(0.0, (lower_held, 0.5 + Closeness("lower", "on_mark")))
        + Ladder(0.0, (upper_held, 0.5)),
        (on_mark, 3.1 + 0.9 * GripperOpening("left")),
        (founded, 4.1 + Closeness("right.tcp", "upper.top")),
        (founded & upper_held, 5.2 + 2.0 * Closeness("upper", "on_lower")),
        (on_top, 7.3 + GripperOpening("right")),
        (stacked, 8.5 + 2.0 * Fraction(Duration(stacked), of=1.0)),
        (success, 11.0),
    )

    dropped = (Once(lower_held) & ~lower_held & ~on_mark) | Then(on_top, ~on_top)
    setback = Sustained(dropped & ~Once(success), seconds=0.5)
