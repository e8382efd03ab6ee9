"""A bin is tipped and a ball raked out of it: the ball touches several shapes of a moving link."""

from taskbuilder import description as d


class TipAndRake(d.Description):
    """The ball is out of the bin and at rest in the pen, while the bin is tilted and held."""

    tilted = d.Held("bin.bin", by="left") & d.JointAngle("bin.tilt", above_deg=15)
    out = d.Inside("ball", "pen")
    done = out & tilted

    success = d.Sustained(done, seconds=0.5)
    failure = d.Below("ball", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {"tilted": tilted, "raked out": done, "kept": success}
    reward = (
        d.Distance("reach", "left.tcp", "bin.knob", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "ball", 0.5, agent="right"),
        d.Paid("tilt", d.JointTravel("bin.tilt", to_deg=25), 0.5, agent="left"),
        d.Distance("rake", "ball", "pen", 2.0),
        d.Bonus("out", done, 2.0),
    )
