"""The cube lies in the chest, whose lid is open."""

from taskbuilder.description import (
    Bonus,
    Description,
    Distance,
    Held,
    Inside,
    JointAngle,
    Released,
    Sustained,
)


class LidByItsKnob(Description):
    """The chest is out of the right arm's way only while the left arm has opened it."""

    opened = JointAngle("chest.hinge", above_deg=55)
    put = opened & Inside("cube", "hold") & Released("cube")

    success = Sustained(put, seconds=1.0)
    reward = (
        Distance("reach", "left.tcp", "chest.lid", agent="left"),
        Distance("reach", "right.tcp", "cube", agent="right"),
        Distance("carry", "cube", "hold"),
        Bonus("open", opened, 0.5, agent="left"),
        Bonus("take", Held("cube", by="right") & ~put, 0.2, agent="right"),
        Bonus("put", put, 3.0),
    )
