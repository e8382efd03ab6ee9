"""Open Drawer: success and reward."""

from taskbuilder import description as d


class OpenDrawer(d.Description):
    """The drawer is out by at least 12 cm, stays there, and nothing touches it any more."""

    taken = d.Held("cabinet.drawer", by="arm")
    opened = d.JointPosition("cabinet.runner", above=0.12)
    left_open = opened & d.Released("cabinet.drawer")

    success = d.Sustained(left_open, seconds=1.0)
    failure = d.ForceAbove("arm", "table", newtons=100)
    stages = {"taken": taken, "opened": opened, "left open": left_open, "kept there": success}
    reward = (
        d.Distance("reach", "arm.tcp", "cabinet.knob", 0.5),
        d.Distance("pull", "cabinet.knob", "pulled"),
        d.Bonus("take", taken | opened, 0.3),
        d.Bonus("open", left_open, 2.0),
    )

    progress = d.Ladder(
        d.Closeness("arm.tcp", "cabinet.knob"),
        (taken, 1.2 + d.Closeness("cabinet.knob", "pulled")),
        (opened, 2.4 + 0.4 * d.GripperOpening("arm")),
        (left_open, 3.0 + d.Fraction(d.Duration(left_open), of=1.0)),
        (success, 4.5),
    )
    setback = d.Then(taken, d.Sustained(~taken & ~opened & ~d.Once(success), seconds=0.5))
