"""Gantry Serves Arm: success and reward."""

from taskbuilder import description as d


class GantryServesArm(d.Description):
    """The cap stands on the foot and the foot on the plinth, and nobody touches them."""

    foot_there = d.Near("foot", "transfer", within=0.08)
    foot_stands = d.On("foot", "plinth") & d.Upright("foot", within_deg=10)
    foot_set = foot_stands & d.Released("foot")
    cap_served = d.Once(d.Near("cap", "transfer", within=0.08))
    cap_on = d.On("cap", "foot") & d.Near("cap", "on_foot", within=0.03)
    built = foot_set & cap_on & d.Released("cap") & d.Stationary("cap")

    success = d.Sustained(built, seconds=1.0)
    failure = (
        d.Below("foot", height=0.35)
        | d.Below("cap", height=0.35)
        | d.ForceAbove("gantry", "arm", newtons=100)
    )
    stages = {"foot set": foot_set, "cap served": cap_served, "built": built, "kept there": success}
    reward = (
        d.Distance("carry foot", "foot", "on_plinth"),
        d.Distance("carry cap", "cap", "on_foot"),
        d.Bonus("foot", foot_set, 1.0, agent="arm"),
        d.Bonus("cap", cap_served, 1.0, agent="gantry"),
        d.Bonus("built", built, 4.0),
    )

    progress = d.Ladder(
        d.Closeness("gantry.tcp", "foot.middle", scale=0.4),
        (d.Held("foot", by="gantry"), 1.2 + d.Closeness("foot", "transfer", scale=0.4)),
        (d.Once(foot_there), 2.4 + d.Closeness("foot", "on_plinth", scale=0.4)),
        (foot_set, 3.6 + d.Closeness("cap", "transfer", scale=0.4)),
        (foot_set & cap_served, 4.8 + d.Closeness("cap", "on_foot", scale=0.3)),
        (foot_set & cap_on, 6.0 + 0.2 * d.GripperOpening("arm")),
        (built, 6.5 + d.Fraction(d.Duration(built), of=1.0)),
        (success, 8.0),
    )
    setback = d.Then(foot_set, d.Sustained(~foot_set & ~success, seconds=0.5))
