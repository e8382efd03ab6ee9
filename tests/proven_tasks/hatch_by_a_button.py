"""The hatch stands open, and the button is held down."""

from taskbuilder.description import (
    Bonus,
    Description,
    Distance,
    Held,
    JointAngle,
    JointPosition,
    Sustained,
)


class HatchByAButton(Description):
    """The hatch is locked unless the button is held down; let go, the button comes up again."""

    button_down = JointPosition("button.press", above=0.008)
    opened = JointAngle("chest.hinge", above_deg=55)
    done = opened & button_down

    success = Sustained(done, seconds=1.0)
    reward = (
        Distance("reach", "left.tcp", "chest.grip", agent="left"),
        Distance("press", "right.tcp", "button.cap", agent="right"),
        Bonus("down", button_down, 0.2, agent="right"),
        Bonus("take", Held("chest", by="left"), 0.2, agent="left"),
        Bonus("open", done, 3.0),
    )
