"""Push Safe: success and reward."""

from taskbuilder import description as d


class PushSafe(d.Description):
    """One arm alone does not move the safe, or turns it; both plates have to reach the stripe."""

    pushing = d.Contact("safe", robot="left") & d.Contact("safe", robot="right")
    left_there = d.Near("safe.left_plate", "left_stop", within=0.03, axes="y")
    right_there = d.Near("safe.right_plate", "right_stop", within=0.03, axes="y")
    on_stripe = left_there & right_there
    stands = on_stripe & d.Released("safe") & d.Stationary("safe")

    success = d.Sustained(stands, seconds=1.0)
    failure = d.Below("safe", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {
        "both push": pushing,
        "on the stripe": on_stripe,
        "let go": d.Then(pushing, stands),
        "kept there": success,
    }
    reward = (
        d.Distance("reach", "left.tcp", "safe.left_plate", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "safe.right_plate", 0.5, agent="right"),
        d.Distance("push", "safe.left_plate", "left_stop", 2.0, agent="left"),
        d.Distance("push", "safe.right_plate", "right_stop", 2.0, agent="right"),
        d.Bonus("on the stripe", on_stripe, 0.5),
        d.Bonus("stands", stands, 2.0),
    )

    push = d.Minimum(
        d.Closeness("safe.left_plate", "left_stop"), d.Closeness("safe.right_plate", "right_stop")
    )
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "safe.left_plate")
        + 0.5 * d.Closeness("right.tcp", "safe.right_plate"),
        (pushing, 1.2 + 2.0 * push),
        (on_stripe, 3.3),
        (stands, 3.6 + d.Fraction(d.Duration(stands), of=1.0)),
        (success, 5.0),
    )
    setback = d.Then(pushing, d.Sustained(~pushing & ~on_stripe, seconds=1.0))
