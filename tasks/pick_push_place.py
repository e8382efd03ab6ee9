"""Pick-Push-Place: success and reward."""

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
    Inside,
    Ladder,
    Near,
    On,
    Once,
    Released,
    Sustained,
    Then,
)


class PickPushPlace(Description):
    """The left arm brings the cube, the right arm the tray, and the cube goes into the tray."""

    in_tray = Inside("cube", "tray") & On("cube", "tray")
    let_go = in_tray & Released("cube")
    placed = let_go & On("tray", "table.top")

    success = Sustained(placed, seconds=1.0)
    failure = (
        Below("cube", height=0.35)
        | Below("tray", height=0.35)
        | ForceAbove("left", "right", newtons=100)
    )
    stages = {
        "cube held": Held("cube", by="left"),
        "both held": Held("cube", by="left") & Held("tray", by="right"),
        "in tray": in_tray,
        "placed": placed,
        "kept there": success,
    }
    reward = (  # equation (1)
        Bonus("grasp", Held("cube", by="left"), 1.0, agent="left"),
        Bonus("grasp", Held("tray", by="right"), 1.0, agent="right"),
        Distance("reach", "left.tcp", "cube", agent="left"),
        Distance("reach", "right.tcp", "tray", agent="right"),
        Distance("gather", "cube", "tray"),
        Bonus("place", in_tray, 4.0),
    )

    cube_held = Held("cube", by="left")
    tray_held = Held("tray", by="right")
    over_tray = Near("cube", "above_tray", within=0.06)
    lift = Fraction(Height("cube", "table.top") - 0.0225, of=0.06)
    progress = Ladder(
        0.5 * Closeness("left.tcp", "cube.middle")
        + 0.5 * Closeness("right.tcp", "tray.grip")
        + 0.25 * Closeness("left.tcp", "cube.middle", scale=0.06)
        + 0.25 * Closeness("right.tcp", "tray.grip", scale=0.06)
        + Ladder(0.0, (cube_held, 0.5 + 0.5 * lift))
        + Ladder(0.0, (tray_held, 0.5)),
        (
            cube_held & tray_held,
            3.0
            + 0.5 * lift
            + 2.0 * Closeness("tray", "middle", scale=0.7)
            + 2.0 * Closeness("cube", "above_tray", scale=0.7)
            + lift * Closeness("cube", "above_tray", scale=0.08),
        ),
        (over_tray | in_tray, 8.5 + GripperOpening("left")),
        (let_go, 10.5 - Fraction(Height("tray", "table.top"), of=0.1)),
        (placed, 11.0 + 2.0 * Fraction(Duration(placed), of=1.0)),
        (success, 14.0),
    )

    setback = Then(cube_held, Sustained(~cube_held & ~in_tray & ~Once(success), seconds=0.5))
