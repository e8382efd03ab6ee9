"""Handover and Stack: success and reward."""

from taskbuilder import description as d


class HandoverAndStack(d.Description):
    """The beam has changed hands, and lies across the block, level and let go of."""

    taken = d.Held("beam", by="left")
    handed_over = d.Then(taken, d.Held("beam", by="right") & ~taken)
    carried = handed_over & d.Held("beam", by="right") & ~taken
    on_top = handed_over & d.On("beam", "block") & ~d.On("beam", "table")
    stacked = on_top & d.Level("beam", within_deg=3) & d.Released("beam") & d.Stationary("beam")

    success = d.Sustained(stacked, seconds=1.0)
    failure = (
        d.Below("beam", height=0.38)
        | d.Below("block", height=0.38)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"taken": taken, "handed over": handed_over, "on top": on_top, "stacked": stacked}
    stages["kept there"] = success
    reward = (
        d.Distance("reach", "left.tcp", "beam.left_end", 0.3, agent="left"),
        d.Distance("carry", "beam", "on_block"),
        d.Bonus("handover", carried | stacked, 1.0, agent="right"),
        d.Bonus("stacked", stacked, 4.0),
    )

    progress = d.Ladder(
        d.Closeness("left.tcp", "beam.left_end"),
        (taken, 1.2 + d.Closeness("beam", "meeting") + 0.3 * d.GripperOpening("right")),
        (taken & d.Held("beam", by="right"), 2.8),
        (carried, 3.2 + 2.0 * d.Closeness("beam", "on_block", scale=0.3)),
        (on_top, 5.4 + d.GripperOpening("right")),
        (stacked, 6.5 + d.Fraction(d.Duration(stacked), of=1.0)),
        (success, 8.0),
    )
    loose = d.Released("beam") & ~on_top
    setback = d.Then(taken, d.Sustained(loose & ~d.Once(success), seconds=0.5))
