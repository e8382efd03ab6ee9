"""Ring Pass: success and reward."""

from taskbuilder import description as d

ARMS = ("front_left", "front_right", "back_right", "back_left")
CUBES = dict(zip(("red", "blue", "yellow", "green"), ARMS, strict=True))
NEXT = dict(zip(ARMS, (*ARMS[1:], ARMS[0]), strict=True))


def way(cube, arm):
    """How far a cube has come: 0 to 3."""
    passed = d.Then(d.Held(cube, by=arm), d.Held(cube, by=NEXT[arm]))
    return d.Ladder(
        0.5 * d.Closeness(f"{arm}.tcp", f"{cube}.top"),
        (d.Once(d.Held(cube, by=arm)), 0.6 + d.Closeness(cube, f"{cube}_spot")),
        (passed, 1.8 + d.Closeness(cube, f"{cube}_home")),
        (d.On(cube, f"{cube}_plate") & d.Near(cube, f"{cube}_home", within=0.03), 3.0),
    )


class RingPass(d.Description):
    """Each cube stands on the plate of its colour, one place on in the ring, and is let go of."""

    taken = d.All(*(d.Once(d.Held(cube, by=arm)) for cube, arm in CUBES.items()))
    passed = d.All(*(d.Once(d.Held(cube, by=NEXT[arm])) for cube, arm in CUBES.items()))
    home = d.All(*(d.On(c, f"{c}_plate") & d.Near(c, f"{c}_home", within=0.03) for c in CUBES))
    sorted_out = home & d.All(*(d.Released(cube) for cube in CUBES))

    success = d.Sustained(sorted_out, seconds=1.0)
    failure = d.Any(
        *(d.Below(cube, height=0.38) for cube in CUBES),
        *(d.ForceAbove(arm, NEXT[arm], newtons=100) for arm in ARMS),
    )
    stages = {"all taken": taken, "all taken over": taken & passed}
    stages |= {"sorted": sorted_out, "kept there": success}
    reward = (
        *(d.Distance("carry", c, f"{c}_home", agent=NEXT[arm]) for c, arm in CUBES.items()),
        *(d.Bonus("give", d.Once(d.Held(c, by=arm)), 0.1, agent=arm) for c, arm in CUBES.items()),
        d.Bonus("sorted", sorted_out, 3.0),
    )

    progress = d.Ladder(
        sum((way(cube, arm) for cube, arm in CUBES.items()), start=0.0),
        (sorted_out, 12.5 + d.Fraction(d.Duration(sorted_out), of=1.0)),
        (success, 14.0),
    )
    setback = d.Then(sorted_out, d.Sustained(~sorted_out & ~d.Once(success), seconds=0.5))
