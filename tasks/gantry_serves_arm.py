"""Gantry Serves Arm: success and reward."""

from taskbuilder import description as d


class GantryServesArm(d.Description):
    """The cap stands on the foot and the foot on the plinth, and nobody touches them."""

    fetched = d.Held("cap", by="gantry")
    served = d.Near("cap", "set_down", within=0.06)
    taken = d.Held("cap", by="arm")
    foot_stands = d.On("foot", "plinth") & d.Upright("foot", within_deg=5)
    cap_on = d.On("cap", "foot") & d.Near("cap", "on_foot", within=0.025)
    built = foot_stands & cap_on & d.Released("foot") & d.Released("cap")

    success = d.Sustained(built, seconds=1.0)
    failure = (
        d.Below("cap", height=0.35) | ~foot_stands | d.ForceAbove("gantry", "arm", newtons=100)
    )
    stages = {"brought": d.Once(served), "taken": taken, "built": built, "kept there": success}
    reward = (
        d.Distance("carry", "cap", "on_foot"),
        d.Bonus("serve", d.Once(served), 1.0, agent="gantry"),
        d.Bonus("set on", cap_on, 1.0, agent="arm"),
        d.Bonus("built", built, 4.0),
    )

    progress = d.Ladder(
        d.Closeness("gantry.tcp", "cap.middle", scale=0.4),
        (fetched, 1.2 + d.Closeness("cap", "set_down", scale=0.4)),
        (d.Once(served), 2.4 + d.Closeness("arm.tcp", "cap.middle", scale=0.4)),
        (taken & d.Once(served), 3.6 + d.Closeness("cap", "on_foot", scale=0.4)),
        (cap_on, 4.8 + 0.2 * d.GripperOpening("arm")),
        (built, 5.5 + d.Fraction(d.Duration(built), of=1.0)),
        (success, 7.0),
    )
    setback = d.Then(taken, d.Sustained(~taken & ~cap_on & ~d.Once(success), seconds=0.5))
