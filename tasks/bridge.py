"""Bridge: success and reward."""

from taskbuilder import description as d


class Bridge(d.Description):
    """The pillars stand on their marks, each in reach of one arm only, and carry the plank."""

    left_set, right_set = (
        d.Near(f"{side}_pillar", f"{side}_mark", within=0.07) & d.On(f"{side}_pillar", "table.top")
        for side in ("left", "right")
    )
    pillars = left_set & right_set & d.Released("left_pillar") & d.Released("right_pillar")
    lifted = d.Held("plank", by="left") & d.Held("plank", by="right") & ~d.On("plank", "table")
    across = d.On("plank", "left_pillar") & d.On("plank", "right_pillar") & pillars
    built = across & d.Released("plank") & d.Level("plank", within_deg=3)

    success = d.Sustained(built, seconds=1.0)
    failure = (
        d.Below("plank", height=0.38)
        | ~d.Upright("left_pillar", within_deg=60)
        | ~d.Upright("right_pillar", within_deg=60)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"pillars set": pillars, "plank lifted": pillars & lifted, "built": built}
    stages["standing"] = success
    reward = (
        d.Distance("left", "left_pillar", "left_mark"),
        d.Distance("right", "right_pillar", "right_mark"),
        d.Distance("plank", "plank", "deck"),
        d.Bonus("pillars", pillars, 0.5),
        d.Bonus("built", built, 3.0),
    )

    grip_left = d.Closeness("left.tcp", "plank.left_end")
    grip_right = d.Closeness("right.tcp", "plank.right_end")
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "left_pillar.top")
        + 0.5 * d.Closeness("right.tcp", "right_pillar.top")
        + d.Closeness("left_pillar", "left_mark")
        + d.Closeness("right_pillar", "right_mark"),
        (left_set & right_set, 3.1 + 0.2 * (d.GripperOpening("left") + d.GripperOpening("right"))),
        (pillars, 3.6 + 0.5 * grip_left + 0.5 * grip_right),
        (pillars & lifted, 4.8 + d.Closeness("plank", "deck", scale=0.4)),
        (across, 6.0 + 0.5 * (d.GripperOpening("left") + d.GripperOpening("right"))),
        (built, 7.2 + d.Fraction(d.Duration(built), of=1.0)),
        (success, 8.5),
    )
    setback = d.Then(built, d.Sustained(~built & ~d.Once(success), seconds=0.5))
