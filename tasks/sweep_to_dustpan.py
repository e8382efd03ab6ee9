"""Sweep to Dustpan: success and reward."""

from taskbuilder import description as d


class SweepToDustpan(d.Description):
    """A crumb that is swept off the table falls to the floor, unless the pan is held there."""

    brush_held = d.Held("brush", by="sweeper")
    pan_held = d.Held("pan", by="catcher")
    ready = brush_held & pan_held & d.Near("pan", "edge", within=0.03)
    caught = d.AtLeast(9, d.Inside("crumbs", "pan"))
    all_swept = caught & pan_held
    on_shelf = d.On("pan", "table") & d.Near("pan", "shelf", within=0.05) & caught
    put_back = on_shelf & d.Released("pan") & d.Level("pan", within_deg=3)

    success = d.Sustained(put_back, seconds=1.0)
    failure = (
        d.AtLeast(2, d.Below("crumbs", height=0.3))
        | d.Below("pan", height=0.3)
        | d.Below("brush", height=0.3)
        | d.ForceAbove("sweeper", "catcher", newtons=100)
    )
    stages = {"ready": ready, "swept": all_swept, "put back": put_back, "kept there": success}
    reward = (
        d.Distance("reach", "sweeper.tcp", "brush.grip", 0.5, agent="sweeper"),
        d.Distance("reach", "catcher.tcp", "pan.grip", 0.5, agent="catcher"),
        d.Bonus("ready", ready | caught, 0.3),
        d.Paid("caught", d.Fraction(d.Count(d.Inside("crumbs", "pan")), of=10)),
        d.Bonus("put back", put_back, 3.0),
    )

    in_pan = d.Fraction(d.Count(d.Inside("crumbs", "pan")), of=10)
    progress = d.Ladder(
        0.5 * d.Closeness("sweeper.tcp", "brush.grip")
        + 0.5 * d.Closeness("catcher.tcp", "pan.grip"),
        (brush_held & pan_held, 1.2 + 0.5 * d.Closeness("pan", "edge")),
        (ready, 2.0 + d.Mean(d.Closeness("crumbs", "pan")) + in_pan),
        (all_swept, 4.0 + d.Closeness("pan", "shelf")),
        (on_shelf, 5.0 + d.GripperOpening("catcher")),
        (put_back, 6.0 + d.Fraction(d.Duration(put_back), of=1.0)),
        (success, 7.5),
    )
    setback = d.Then(ready, d.Sustained(~pan_held & ~on_shelf & ~d.Once(success), seconds=0.5))
