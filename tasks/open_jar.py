"""Open Jar: success and reward."""

from taskbuilder import description as d


class OpenJar(d.Description):
    """The lid is tight: a jar that nobody holds turns along with it, and the lid stays on."""

    held = d.Held("jar", by="left")
    gripped = held & d.Held("lid", by="right")
    loose = d.JointAngle("jar.screw", above_deg=70)
    off = loose & d.Above("lid", "jar", height=0.13)
    laid = loose & d.On("lid", "coaster") & d.Near("lid", "on_coaster", within=0.06)
    stands = d.On("jar", "stand") & d.Upright("jar", within_deg=10)
    done = laid & stands & d.Released("lid") & d.Released("jar") & d.Stationary("lid")

    success = d.Sustained(done, seconds=1.0)
    failure = (
        d.Below("jar", height=0.42)
        | d.Below("lid", height=0.35)
        | ~d.Upright("jar", within_deg=45)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"both held": gripped, "loose": loose, "off": off, "laid": laid}
    stages["kept there"] = success
    reward = (
        d.Distance("reach", "left.tcp", "jar.side", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "lid.grip", 0.5, agent="right"),
        d.Distance("carry", "lid", "on_coaster"),
        d.Bonus("held", held | laid, 0.3, agent="left"),
        d.Bonus("loose", loose, 0.5),
        d.Bonus("done", done, 3.0),
    )

    near = 0.5 * d.Closeness("left.tcp", "jar.side") + 0.5 * d.Closeness("right.tcp", "lid.grip")
    progress = d.Ladder(
        near,
        (gripped, 1.5 + d.JointTravel("jar.screw", to_deg=90)),
        (loose, 2.6 + d.Fraction(d.Height("lid", "jar") - 0.11, of=0.05)),
        (off, 3.7 + d.Closeness("lid", "on_coaster", scale=0.4)),
        (laid, 4.8 + 0.5 * (d.GripperOpening("left") + d.GripperOpening("right"))),
        (done, 5.9 + d.Fraction(d.Duration(done), of=1.0)),
        (success, 7.5),
    )
    lost = ~d.Held("lid", by="right") & ~laid & ~d.Once(success)
    setback = d.Then(off, d.Sustained(lost, seconds=0.5))
