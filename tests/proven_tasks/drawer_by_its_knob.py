"""The cube lies in the drawer, which is kept open."""

from taskbuilder.description import (
    Bonus,
    Description,
    Distance,
    Held,
    Inside,
    JointPosition,
    Released,
    Sustained,
)


class DrawerByItsKnob(Description):
    """A spring shuts the drawer as soon as nobody holds its knob."""

    opened = JointPosition("cabinet.runner", above=0.1)
    put = opened & Inside("cube", "cabinet.drawer") & Released("cube")

    success = Sustained(put, seconds=1.0)
    reward = (
        Distance("reach", "left.tcp", "cabinet.knob", agent="left"),
        Distance("reach", "right.tcp", "cube", agent="right"),
        Distance("carry", "cube", "inside"),
        Bonus("pull", Held("cabinet.drawer", by="left") & opened, 0.5, agent="left"),
        Bonus("take", Held("cube", by="right") & ~put, 0.2, agent="right"),
        Bonus("put", put, 3.0),
    )
