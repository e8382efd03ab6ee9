"""Bottle in Fridge: success and reward."""

from taskbuilder import description as d


class BottleInFridge(d.Description):
    """A spring shuts the door as soon as nobody holds it, so the bottle needs a second arm."""

    opened = d.Held("fridge.door", by="left") & d.JointAngle("fridge.hinge", above_deg=80)
    taken = d.Held("bottle", by="right")
    inside = d.Near("bottle", "shelf", within=0.08) & d.Upright("bottle", within_deg=10)
    put = inside & d.Released("bottle")
    shut = d.JointAngle("fridge.hinge", below_deg=4) & d.Released("fridge.door")
    stored = put & shut

    success = d.Sustained(stored, seconds=1.0)
    failure = d.Below("bottle", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {"opened": opened, "put in": put, "stored": stored, "kept there": success}
    reward = (
        d.Distance("reach", "left.tcp", "fridge.handle", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "bottle", 0.5, agent="right"),
        d.Distance("carry", "bottle", "shelf"),
        d.Bonus("open", opened | put, 0.5, agent="left"),
        d.Bonus("put", put, 2.0, agent="right"),
        d.Bonus("stored", stored, 3.0),
    )

    ajar = d.JointTravel("fridge.hinge", to_deg=85)
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "fridge.handle")
        + 0.5 * d.Closeness("right.tcp", "bottle.side"),
        (taken, 1.0 + ajar + 0.5 * d.Closeness("left.tcp", "fridge.handle")),
        (taken & opened, 2.6 + 1.5 * d.Closeness("bottle", "shelf", scale=0.4)),
        (put, 4.2 + (1.0 - ajar)),
        (stored, 5.3 + d.Fraction(d.Duration(stored), of=1.0)),
        (success, 7.0),
    )
    setback = d.Then(taken, d.Sustained(~taken & ~inside & ~d.Once(success), seconds=0.5))
