"""Swap Places: success and reward."""

from taskbuilder import description as d


class SwapPlaces(d.Description):
    """Each cube stands on the plate of its own colour, let go of, at the other arm's side."""

    red_home = d.On("red_cube", "right_plate") & d.Near("red_cube", "on_right", within=0.03)
    blue_home = d.On("blue_cube", "left_plate") & d.Near("blue_cube", "on_left", within=0.03)
    red_passed = d.Then(d.Held("red_cube", by="left"), d.Held("red_cube", by="right"))
    blue_passed = d.Then(d.Held("blue_cube", by="right"), d.Held("blue_cube", by="left"))
    swapped = red_home & blue_home & d.Released("red_cube") & d.Released("blue_cube")

    success = d.Sustained(swapped, seconds=1.0)
    failure = (
        d.Below("red_cube", height=0.38)
        | d.Below("blue_cube", height=0.38)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"red passed on": red_passed, "both passed on": red_passed & blue_passed}
    stages |= {"swapped": swapped, "kept there": success}
    reward = (
        d.Distance("red", "red_cube", "on_right"),
        d.Distance("blue", "blue_cube", "on_left"),
        d.Bonus("red passed", red_passed, 0.5, agent="right"),
        d.Bonus("blue passed", blue_passed, 0.5, agent="left"),
        d.Bonus("red home", red_home, 0.5),
        d.Bonus("blue home", blue_home, 0.5),
        d.Bonus("swapped", swapped, 2.0),
    )

    red_way = d.Ladder(
        0.5 * d.Closeness("left.tcp", "red_cube.top"),
        (d.Once(d.Held("red_cube", by="left")), 0.6 + d.Closeness("red_cube", "near_spot")),
        (red_passed, 1.8 + d.Closeness("red_cube", "on_right", scale=0.4)),
        (red_home, 3.0),
    )
    blue_way = d.Ladder(
        0.5 * d.Closeness("right.tcp", "blue_cube.top"),
        (d.Once(d.Held("blue_cube", by="right")), 0.6 + d.Closeness("blue_cube", "far_spot")),
        (blue_passed, 1.8 + d.Closeness("blue_cube", "on_left", scale=0.4)),
        (blue_home, 3.0),
    )
    progress = d.Ladder(
        red_way + blue_way,
        (swapped, 6.5 + d.Fraction(d.Duration(swapped), of=1.0)),
        (success, 8.0),
    )
    setback = d.Then(swapped, d.Sustained(~swapped & ~d.Once(success), seconds=0.5))
