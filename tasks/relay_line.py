"""Relay Line: success and reward."""

from taskbuilder import description as d


class RelayLine(d.Description):
    """The stick goes from hand to hand along the line, and ends on the plate, let go of."""

    first, second, third = (d.Held("stick", by=name) for name in ("left", "middle", "right"))
    to_middle = d.Then(first, second & ~first)
    to_right = d.Then(to_middle, third & ~second)
    laid = to_right & d.On("stick", "plate") & d.Released("stick") & d.Stationary("stick")

    success = d.Sustained(laid, seconds=1.0)
    failure = (
        d.Below("stick", height=0.35)
        | d.ForceAbove("left", "middle", newtons=100)
        | d.ForceAbove("middle", "right", newtons=100)
    )
    stages = {"taken": first, "to middle": to_middle, "to right": to_right, "laid": laid}
    stages["kept there"] = success
    reward = (
        d.Distance("reach", "left.tcp", "stick.left_end", 0.3, agent="left"),
        d.Distance("carry", "stick", "plate"),
        d.Bonus("middle", to_middle, 1.0, agent="middle"),
        d.Bonus("right", to_right, 1.0, agent="right"),
        d.Bonus("laid", laid, 4.0),
    )

    progress = d.Ladder(
        d.Closeness("left.tcp", "stick.left_end"),
        (first, 1.2 + d.Closeness("stick", "first_meeting", scale=0.5)),
        (first & second, 2.4),
        (to_middle, 2.4 + d.Ladder(0, (second, 0.2 + d.Closeness("stick", "second_meeting")))),
        (second & third & to_middle, 3.8),
        (to_right, 4.0 + d.Closeness("stick", "plate") + 0.2 * d.GripperOpening("right")),
        (laid, 5.5 + d.Fraction(d.Duration(laid), of=1.0)),
        (success, 7.5),
    )
    setback = d.Then(first, d.Sustained(d.Released("stick") & ~laid & ~success, seconds=0.5))
