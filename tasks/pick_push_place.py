"""Pick-Push-Place: success and reward."""

from taskbuilder.description import (
    Below,
    Bonus,
    Closeness,
    Description,
    Distance,
    Height,
    Held,
    Inside,
    Ladder,
    On,
    Share,
    Sustained,
    Then,
)


class PickPushPlace(Description):
    """The left arm brings the cube and the right arm the tray, until the cube is in the tray."""

    in_tray = Inside("cube", "tray") & On("cube", "tray")

    success = in_tray
    failure = Below("cube", height=0.35) | Below("tray", height=0.35)
    stages = {
        "cube held": Held("cube", by="left"),
        "both held": Held("cube", by="left") & Held("tray", by="right"),
        "in tray": in_tray,
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
    lift = Share(Height("cube", "table.top") - 0.0225, of=0.06)
    progress = Ladder(
        0.5 * Closeness("left.tcp", "cube.middle")
        + 0.5 * Closeness("right.tcp", "tray.grip")
        + Ladder(0.0, (cube_held, 0.5 + 0.5 * lift))
        + Ladder(0.0, (tray_held, 0.5)),
        (
            cube_held & tray_held,
            2.5
            + 0.5 * lift
            + Closeness("tray", "middle", scale=0.3)
            + Closeness("cube", "above_tray", scale=0.3)
            + lift * Closeness("cube", "above_tray", scale=0.08),
        ),
        (in_tray, 7.0),
    )

    setback = Then(cube_held, Sustained(~cube_held & ~in_tray, seconds=0.5))
