"""Pick-Push-Place: success and reward."""

from taskbuilder.description import Below, Bonus, Description, Distance, Held, Inside, On


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
