"""Unfold Ruler: success and reward."""

from taskbuilder import description as d

LENGTH = 0.51
"""Distance between the two grasp points when the ruler is straight, in metres."""


class UnfoldRuler(d.Description):
    """Pulled at one end, the ruler follows without unfolding, so it takes a pull at both."""

    left_held, right_held = d.Held("ruler.first", by="left"), d.Held("ruler.last", by="right")
    straight = ~d.Near("ruler.left_end", "ruler.right_end", within=LENGTH - 0.025)
    lifted = left_held & right_held & d.Above("ruler.left_end", height=0.53)
    stretched = lifted & straight
    on_stands = d.On("ruler", "left_stand") & d.On("ruler", "right_stand") & straight
    laid = on_stands & d.Released("ruler") & d.Level("ruler", within_deg=3)

    success = d.Sustained(laid, seconds=1.0)
    failure = d.Below("ruler", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {"lifted": lifted, "stretched": stretched, "laid": laid, "kept there": success}
    reward = (
        d.Distance("reach", "left.tcp", "ruler.left_end", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "ruler.right_end", 0.5, agent="right"),
        d.Distance("carry", "ruler.left_end", "left_mark", agent="left"),
        d.Distance("carry", "ruler.right_end", "right_mark", agent="right"),
        d.Bonus("straight", stretched | laid, 0.5),
        d.Bonus("laid", laid, 3.0),
    )

    unfolded = d.Fraction(d.Gap("ruler.left_end", "ruler.right_end") - 0.3, of=LENGTH - 0.3)
    near = d.Minimum(
        d.Closeness("ruler.left_end", "left_mark"), d.Closeness("ruler.right_end", "right_mark")
    )
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "ruler.left_end")
        + 0.5 * d.Closeness("right.tcp", "ruler.right_end"),
        (left_held & right_held, 1.5),
        (lifted, 2.0 + unfolded),
        (stretched, 3.0 + near),
        (on_stands, 4.2 + 0.5 * (d.GripperOpening("left") + d.GripperOpening("right"))),
        (laid, 5.5 + d.Fraction(d.Duration(laid), of=1.0)),
        (success, 7.0),
    )
    setback = d.Then(lifted, d.Sustained(~lifted & ~on_stands & ~d.Once(success), seconds=0.5))
