"""Gather Cubes: success and reward."""

from taskbuilder import description as d


class GatherCubes(d.Description):
    """Each arm reaches one board, and a board gathers the cubes of its own side."""

    left_held, right_held = d.Held("left_board", by="left"), d.Held("right_board", by="right")
    on_stripe = d.All(d.Near("cubes", "middle", within=0.12, axes="x"))
    left_stands = d.Released("left_board") & d.Upright("left_board", within_deg=5)
    right_stands = d.Released("right_board") & d.Upright("right_board", within_deg=5)
    gathered = on_stripe & left_stands & right_stands

    success = d.Sustained(gathered, seconds=1.0)
    failure = d.Any(d.Below("cubes", height=0.35)) | d.ForceAbove("left", "right", newtons=100)
    stages = {
        "boards held": left_held & right_held,
        "on the stripe": on_stripe,
        "gathered": gathered,
        "kept there": success,
    }
    reward = (
        d.Distance("reach", "left.tcp", "left_board.grip", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "right_board.grip", 0.5, agent="right"),
        d.Distance("sweep", "left_board", "left_stop", agent="left"),
        d.Distance("sweep", "right_board", "right_stop", agent="right"),
        d.Bonus("on the stripe", on_stripe, 1.0),
        d.Bonus("gathered", gathered, 3.0),
    )

    share = d.Fraction(d.Count(d.Near("cubes", "middle", within=0.12, axes="x")), of=12.0)
    near = 0.5 * (d.Closeness("left_board", "left_stop") + d.Closeness("right_board", "right_stop"))
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "left_board.grip")
        + 0.5 * d.Closeness("right.tcp", "right_board.grip"),
        (left_held & right_held, 1.5 + near + share),
        (on_stripe, 4.0 + 0.5 * (d.GripperOpening("left") + d.GripperOpening("right"))),
        (gathered, 5.5 + d.Fraction(d.Duration(gathered), of=1.0)),
        (success, 7.0),
    )
    setback = d.Sustained(
        d.Then(left_held & right_held, ~left_held & ~right_held & ~on_stripe), seconds=0.5
    )
