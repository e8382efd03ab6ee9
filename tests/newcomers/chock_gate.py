"""ChockGate: success and reward."""

from taskbuilder import description as d


class ChockGate(d.Description):
    """The gate falls shut unless it is held, so the bar needs a second arm."""

    lifted = d.Held("gate.panel", by="left") & d.JointPosition("gate.lift", above=0.07)
    taken = d.Held("bar", by="right")
    under = d.Near("bar", "slot", within=0.04) & d.JointPosition("gate.lift", above=0.03)
    chocked = under & d.Contact("gate.panel", "bar")
    resting = chocked & d.Released("gate.panel") & d.Released("bar")

    success = d.Sustained(resting, seconds=1.0)
    failure = d.Below("bar", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {
        "bar taken": taken,
        "gate lifted": lifted,
        "bar under the gate": under,
        "gate rests on the bar": resting,
        "kept there": success,
    }
    reward = (
        d.Distance("reach", "left.tcp", "gate.knob", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "bar", 0.5, agent="right"),
        d.Distance("carry", "bar", "slot"),
        d.Bonus("lift", lifted | under, 0.5, agent="left"),
        d.Bonus("under", under, 1.0, agent="right"),
        d.Bonus("resting", resting, 3.0),
    )

    lift = d.Fraction(d.Height("gate.panel", "gate"), of=0.11)
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "gate.knob")
        + 0.5 * d.Closeness("right.tcp", "bar.right_end"),
        (taken, 1.0 + 0.5 * d.Closeness("left.tcp", "gate.knob") + lift),
        (taken & lifted, 2.5 + 1.5 * d.Closeness("bar", "slot", scale=0.4)),
        (under, 4.0 + 0.5 * (1 - lift)),
        (resting, 4.6 + d.Fraction(d.Duration(resting), of=1.0)),
        (success, 6.0),
    )
    setback = d.Then(taken, d.Sustained(~taken & ~under & ~d.Once(success), seconds=0.5))
