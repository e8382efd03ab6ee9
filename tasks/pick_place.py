"""Pick and Place: success and reward."""

from taskbuilder.description import (
    Below,
    Bonus,
    Closeness,
    Description,
    Distance,
    Duration,
    Fraction,
    GripperOpening,
    Height,
    Held,
    Ladder,
    Near,
    On,
    Once,
    Released,
    Stationary,
    Sustained,
)


class PickPlace(Description):
    """The cube lies on the mark, and the gripper has let go of it."""

    held = Held("cube", by="arm")
    on_mark = Near("cube", "on_mark", within=0.035) & On("cube", "table.top")
    placed = on_mark & Released("cube") & Stationary("cube")

    success = Sustained(placed, seconds=1.0)
    failure = Below("cube", height=0.35)
    stages = {"held": held, "on the mark": on_mark, "placed": placed, "kept there": success}
    reward = (
        Distance("reach", "arm.tcp", "cube"),
        Distance("carry", "cube", "on_mark"),
        Bonus("grasp", held, 0.5),
        Bonus("place", placed, 4.0),
    )

    lift = Fraction(Height("cube", "table.top") - 0.0225, of=0.05)
    progress = Ladder(
        Closeness("arm.tcp", "cube.top"),
        (held, 1.5 + 0.5 * lift + 2.0 * Closeness("cube", "on_mark")),
        (on_mark, 4.1 + GripperOpening("arm")),
        (placed, 5.5 + 2.0 * Fraction(Duration(placed), of=1.0)),
        (success, 8.0),
    )

    setback = Sustained(Once(held) & ~held & ~on_mark & ~Once(success), seconds=0.5)
