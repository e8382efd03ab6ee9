"""Fill Bin: success and reward."""

from taskbuilder import description as d


class FillBin(d.Description):
    """The bin and the slide are on different sides, each in reach of one arm."""

    below = d.Near("bin", "under", within=0.03, axes="xy")
    filled = d.All(d.Inside("balls", "bin"))
    served = filled & d.Released("bin") & d.Released("hopper") & d.Level("bin", within_deg=3)

    success = d.Sustained(served, seconds=1.0)
    failure = d.Any(d.Below("balls", "bin", height=0.0)) | d.ForceAbove(
        "left", "right", newtons=100
    )
    stages = {"below": below, "filled": filled, "served": served, "kept there": success}
    reward = (
        d.Distance("reach", "left.tcp", "hopper.knob", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "bin.handle", 0.5, agent="right"),
        d.Distance("carry", "bin", "under", agent="right"),
        d.Bonus("filled", filled, 1.0),
        d.Bonus("served", served, 3.0),
    )

    inside = d.Fraction(d.Count(d.Inside("balls", "bin")), of=8.0)
    pulled = d.Fraction(d.Gap("hopper.slide", "hopper") - 0.216, of=0.05)
    progress = d.Ladder(
        d.Closeness("bin", "under", scale=0.3),
        (below, 1.5 + 0.5 * d.Closeness("left.tcp", "hopper.knob") + pulled + inside),
        (
            filled,
            4.0 + 0.3 * (d.GripperOpening("left") + d.Fraction(d.Gap("right.tcp", "bin"), of=0.3)),
        ),
        (served, 5.5 + d.Fraction(d.Duration(served), of=1.0)),
        (success, 7.0),
    )
    setback = d.Then(below, d.Sustained(~below & ~d.Once(success), seconds=0.5))
