"""Fetch Plate: success and reward."""

from taskbuilder import description as d


class FetchPlate(d.Description):
    """No finger gets below a plate that lies flat; its rim is free where it juts out."""

    out = d.Beyond("plate.right", "board", axis="x", by=0.2)
    taken = d.Held("plate", by="right")
    # A plate at rest rattles: for a step, it turns by up to 33°/s, and stays where it is.
    still = d.Stationary("plate", speed=0.02, turn_deg=45)
    on_stand = d.On("plate", "stand") & d.Near("plate", "on_stand", within=0.04)
    served = on_stand & d.Released("plate") & still & d.Upright("plate", within_deg=8)

    success = d.Sustained(served, seconds=1.0)
    failure = (
        d.Below("plate", height=0.43)
        | ~d.Upright("plate", within_deg=45)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"pushed out": out, "taken": taken, "served": served, "kept there": success}
    reward = (
        d.Distance("reach", "left.tcp", "plate", 0.3, agent="left"),
        d.Distance("reach", "right.tcp", "plate.right", 0.5, agent="right"),
        d.Distance("carry", "plate", "on_stand"),
        d.Bonus("out", out, 0.5, agent="left"),
        d.Bonus("taken", taken | on_stand, 0.5, agent="right"),
        d.Bonus("served", served, 3.0),
    )

    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "plate") + d.Closeness("plate", "ledge"),
        (out, 1.6 + d.Closeness("right.tcp", "plate.right")),
        (taken, 2.8 + 1.5 * d.Closeness("plate", "on_stand", scale=0.4)),
        (on_stand, 4.5 + 0.5 * d.GripperOpening("right")),
        (served, 5.2 + d.Fraction(d.Duration(served), of=1.0)),
        (success, 7.0),
    )
    setback = d.Then(taken, d.Sustained(~taken & ~on_stand & ~d.Once(success), seconds=0.5))
