"""Flaps that latch when both are shut: success and reward."""

from taskbuilder import description as d


class FlapsThatLatch(d.Description):
    """Springs open the flaps again unless both are shut at once, so it takes two arms."""

    left_shut = d.JointAngle("carton.left_hinge", below_deg=10)
    right_shut = d.JointAngle("carton.right_hinge", below_deg=10)
    both_shut = left_shut & right_shut
    not_shut = ~both_shut
    let_go = d.Released("carton", by="left") & d.Released("carton", by="right")

    success = d.Sustained(both_shut & let_go, seconds=1.0)
    failure = d.ForceAbove("left", "right", newtons=100)
    reward = (
        d.Distance("reach", "left.tcp", "carton.left_knob", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "carton.right_knob", 0.5, agent="right"),
        d.Paid("fold", d.JointTravel("carton.left_hinge", to_deg=0), 1.0, agent="left"),
        d.Paid("fold", d.JointTravel("carton.right_hinge", to_deg=0), 1.0, agent="right"),
        d.Bonus("shut", both_shut, 1.0),
        d.Bonus("let go", both_shut & let_go, 2.0),
    )
