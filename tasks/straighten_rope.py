"""Straighten Rope: success and reward."""

from taskbuilder import description as d

LENGTH = 0.602
"""Distance between the two grasp points when the rope is straight, in metres."""


class StraightenRope(d.Description):
    """Pulled at one end, the rope follows as it lies; it takes a pull at both to straighten it."""

    left_held = d.Held("rope.left_handle", by="left")
    right_held = d.Held("rope.right_handle", by="right")
    taken = left_held & right_held
    straight = ~d.Near("rope.left_end", "rope.right_end", within=LENGTH - 0.02)
    stretched = taken & straight
    on_stripe = (
        d.Near("rope.left_end", "left_mark", within=0.04)
        & d.Near("rope.right_end", "right_mark", within=0.04)
        & d.Near("rope", "stripe", within=0.03, axes="y")
    )
    laid = straight & on_stripe & d.Released("rope")

    success = d.Sustained(laid, seconds=1.0)
    failure = d.Below("rope", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {"taken": taken, "stretched": stretched, "laid": laid, "kept there": success}
    reward = (
        d.Distance("reach", "left.tcp", "rope.left_end", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "rope.right_end", 0.5, agent="right"),
        d.Distance("carry", "rope.left_end", "left_mark", agent="left"),
        d.Distance("carry", "rope.right_end", "right_mark", agent="right"),
        d.Bonus("straight", stretched | laid, 0.5),
        d.Bonus("laid", laid, 3.0),
    )

    pulled = d.Fraction(d.Gap("rope.left_end", "rope.right_end") - 0.3, of=LENGTH - 0.3)
    near = d.Minimum(
        d.Closeness("rope.left_end", "left_mark"), d.Closeness("rope.right_end", "right_mark")
    )
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "rope.left_end")
        + 0.5 * d.Closeness("right.tcp", "rope.right_end"),
        (taken, 1.5 + pulled),
        (stretched, 2.6 + near),
        (on_stripe & straight, 3.8 + 0.5 * (d.GripperOpening("left") + d.GripperOpening("right"))),
        (laid, 5.0 + d.Fraction(d.Duration(laid), of=1.0)),
        (success, 6.5),
    )
    setback = d.Then(taken, d.Sustained(~taken & ~on_stripe & ~d.Once(success), seconds=0.5))
