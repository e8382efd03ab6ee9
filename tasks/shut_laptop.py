"""Shut Laptop: success and reward."""

from taskbuilder import description as d


class ShutLaptop(d.Description):
    """Held at one side only, the heavy laptop tips out of the gripper."""

    shut = d.JointAngle("laptop.hinge", below_deg=4)
    held = shut & d.Held("laptop", by=("left", "right"))
    # A laptop at rest rattles: for a step, it turns by up to 20°/s, and stays where it is.
    still = d.Stationary("laptop", speed=0.02, turn_deg=45)
    on_dock = shut & d.On("laptop", "dock") & d.Near("laptop", "on_dock", within=0.04)
    rests = on_dock & d.Released("laptop") & still

    success = d.Sustained(rests, seconds=1.0)
    failure = (
        d.Below("laptop", height=0.45)
        | ~d.Upright("laptop", within_deg=15)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"shut": shut, "both hold it": held, "on the stand": on_dock, "let go": success}
    reward = (
        d.Distance("reach", "left.tcp", "laptop.left", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "laptop.right", 0.5, agent="right"),
        d.Distance("carry", "laptop", "on_dock"),
        d.Bonus("shut", shut, 0.5, agent="right"),
        d.Bonus("held", held | on_dock, 0.5),
        d.Bonus("rests", rests, 3.0),
    )

    near = 0.5 * (d.Closeness("left.tcp", "laptop.left") + d.Closeness("right.tcp", "laptop.right"))
    progress = d.Ladder(
        0.5 * d.Closeness("right.tcp", "laptop.screen_top")
        + d.JointTravel("laptop.hinge", to_deg=0),
        (shut, 1.6 + near),
        (held, 3.0 + 1.5 * d.Closeness("laptop", "on_dock", scale=0.4)),
        (on_dock, 4.6),
        (rests, 5.0 + d.Fraction(d.Duration(rests), of=1.0)),
        (success, 7.0),
    )
    setback = d.Then(held, d.Sustained(~held & ~on_dock & ~d.Once(success), seconds=0.5))
