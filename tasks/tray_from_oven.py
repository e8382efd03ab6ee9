"""Tray from Oven: success and reward."""

from taskbuilder import description as d


class TrayFromOven(d.Description):
    """A spring shuts the door as soon as nobody holds it, so the tray needs a second arm."""

    opened = d.Held("oven.door", by="left") & d.JointAngle("oven.hinge", above_deg=75)
    taken = d.Held("tray", by="right")
    out = d.On("tray", "rack") & d.Near("tray", "on_rack", within=0.05)
    put = out & d.Released("tray")
    shut = d.JointAngle("oven.hinge", below_deg=4) & d.Released("oven.door")
    done = put & shut

    success = d.Sustained(done, seconds=1.0)
    failure = d.Below("tray", height=0.41) | d.ForceAbove("left", "right", newtons=100)
    stages = {
        "opened": opened,
        "taken out": d.Then(taken, out),
        "door shut": done,
        "kept so": success,
    }
    reward = (
        d.Distance("reach", "left.tcp", "oven.knob", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "tray", 0.5, agent="right"),
        d.Distance("carry", "tray", "on_rack"),
        d.Bonus("open", opened | put, 0.5, agent="left"),
        d.Bonus("put", put, 2.0, agent="right"),
        d.Bonus("done", done, 3.0),
    )

    ajar = d.JointTravel("oven.hinge", to_deg=80)
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "oven.knob") + 0.5 * d.Closeness("right.tcp", "tray.tab"),
        (d.Held("oven.door", by="left"), 1.1 + ajar),
        (opened, 2.2 + d.Closeness("right.tcp", "tray.tab")),
        (taken, 3.3 + 1.4 * d.Closeness("tray", "on_rack", scale=0.4)),
        (put, 4.8 + (1.0 - ajar)),
        (done, 6.0 + d.Fraction(d.Duration(done), of=1.0)),
        (success, 8.0),
    )
    setback = d.Then(taken, d.Sustained(~taken & ~out & ~d.Once(success), seconds=0.5))
