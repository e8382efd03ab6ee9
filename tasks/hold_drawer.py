"""Hold Drawer: success and reward."""

from taskbuilder import description as d


class HoldDrawer(d.Description):
    """A spring shuts the drawer as soon as nobody holds it, so the cube needs a second arm."""

    opened = d.Held("cabinet.drawer", by="left") & d.JointPosition("cabinet.runner", above=0.11)
    taken = d.Held("cube", by="right")
    put = d.Inside("cube", "cabinet.drawer") & d.Released("cube")
    shut = d.JointPosition("cabinet.runner", below=0.01) & d.Released("cabinet.drawer")
    stored = put & shut

    success = d.Sustained(stored, seconds=1.0)
    failure = d.Below("cube", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {"opened": opened, "put in": put, "stored": stored, "kept there": success}
    reward = (
        d.Distance("reach", "left.tcp", "cabinet.knob", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "cube", 0.5, agent="right"),
        d.Distance("carry", "cube", "inside"),
        d.Bonus("pull", opened | put, 0.5, agent="left"),
        d.Bonus("put", put, 2.0, agent="right"),
        d.Bonus("stored", stored, 3.0),
    )

    pull = d.Fraction(d.Gap("cabinet.drawer", "cabinet") - 0.02, of=0.13)
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "cabinet.knob") + 0.5 * d.Closeness("right.tcp", "cube.top"),
        (taken, 1.0 + pull + 0.5 * d.Closeness("left.tcp", "cabinet.knob")),
        (taken & opened, 3.0 + d.Closeness("cube", "inside", scale=0.4)),
        (put, 4.5 - 0.3 * pull + 0.2 * d.GripperOpening("left")),
        (stored, 5.0 + d.Fraction(d.Duration(stored), of=1.0)),
        (success, 7.0),
    )
    setback = d.Then(taken, d.Sustained(~taken & ~put & ~d.Once(success), seconds=0.5))
