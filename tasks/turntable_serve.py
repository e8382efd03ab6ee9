"""Turntable Serve: success and reward."""

from taskbuilder import description as d


class TurntableServe(d.Description):
    """The cube starts out of reach of both arms, and only one of them reaches the handle."""

    turning = d.Held("turntable.disc", by="left")
    taken = d.Held("cube", by="right") & ~d.On("cube", "turntable")
    inside = d.Inside("cube", "tray")
    served = inside & d.Released("cube") & d.Released("turntable")

    success = d.Sustained(served, seconds=1.0)
    failure = d.Below("cube", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {"taken": taken, "in the tray": inside, "served": served, "kept there": success}
    reward = (
        d.Distance("reach", "left.tcp", "turntable.handle", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "cube", 0.5, agent="right"),
        d.Distance("carry", "cube", "in_tray"),
        d.Bonus("take", taken | inside, 0.5, agent="right"),
        d.Bonus("served", served, 3.0),
    )

    near = 0.5 * d.Closeness("cube", "right.base", scale=0.8) + 0.5 * d.Closeness(
        "right.tcp", "cube.top"
    )
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "turntable.handle"),
        (turning, 1.0 + near),
        (taken, 2.5 + d.Closeness("cube", "in_tray", scale=0.4)),
        (inside, 4.0 + 0.5 * (d.GripperOpening("left") + d.GripperOpening("right"))),
        (served, 5.5 + d.Fraction(d.Duration(served), of=1.0)),
        (success, 7.0),
    )
    setback = d.Then(taken, d.Sustained(~taken & ~inside & ~d.Once(success), seconds=0.5))
