"""Balance Seesaw: success and reward."""

from taskbuilder import description as d


class BalanceSeesaw(d.Description):
    """One weight alone tips the seesaw, and a tipped seesaw is a failure, so both come at once."""

    both = d.Held("left_weight", by="left") & d.Held("right_weight", by="right")
    over = d.Near("left_weight", "left_end", within=0.07)
    over &= d.Near("right_weight", "right_end", within=0.07)
    left_on = d.On("left_weight", "seesaw") & d.Near("left_weight", "left_end", within=0.05)
    right_on = d.On("right_weight", "seesaw") & d.Near("right_weight", "right_end", within=0.05)
    tipped = d.JointAngle("seesaw.tilt", above_deg=10) | d.JointAngle("seesaw.tilt", below_deg=-10)
    let_go = d.Released("left_weight") & d.Released("right_weight")
    balanced = left_on & right_on & let_go & d.Level("seesaw.beam", within_deg=6)

    success = d.Sustained(balanced, seconds=1.0)
    failure = (
        tipped
        | d.Below("left_weight", height=0.38)
        | d.Below("right_weight", height=0.38)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"both held": both, "above the ends": both & over, "balanced": balanced}
    stages["kept level"] = success
    reward = (
        d.Distance("reach", "left.tcp", "left_weight", 0.3, agent="left"),
        d.Distance("reach", "right.tcp", "right_weight", 0.3, agent="right"),
        d.Distance("carry", "left_weight", "left_end", agent="left"),
        d.Distance("carry", "right_weight", "right_end", agent="right"),
        d.Bonus("balanced", balanced, 3.0),
    )

    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "left_weight.top")
        + 0.5 * d.Closeness("right.tcp", "right_weight.top"),
        (
            both,
            1.2
            + d.Closeness("left_weight", "left_end", scale=0.3)
            + d.Closeness("right_weight", "right_end", scale=0.3),
        ),
        (over, 3.4 + 0.5 * (d.GripperOpening("left") + d.GripperOpening("right"))),
        (balanced, 4.6 + d.Fraction(d.Duration(balanced), of=1.0)),
        (success, 6.0),
    )
    setback = d.Then(balanced, d.Sustained(~balanced & ~d.Once(success), seconds=0.5))
