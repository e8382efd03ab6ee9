"""TopplesDominoes: success and reward."""

from taskbuilder import description as d


class ToppleDominoes(d.Description):
    """The missing domino is stood in the gap, then the whole row is toppled."""

    held = d.Held("spare", by="left")
    standing = (
        d.All(d.Upright("row", within_deg=30))
        & d.Upright("last", within_deg=30)
        & d.Upright("spare", within_deg=10)
    )
    in_gap = d.Near("spare", "gap", within=0.02) & d.Released("spare") & standing
    row_complete = d.Once(in_gap)
    row_down = d.All(~d.Upright("row", within_deg=45))
    last_down = ~d.Upright("last", within_deg=45)
    all_down = row_complete & row_down & ~d.Upright("spare", within_deg=45) & last_down

    success = d.Sustained(all_down & d.Stationary("last"), seconds=1.0)
    too_early = ~row_complete & (
        d.Any(~d.Upright("row", within_deg=30)) | ~d.Upright("last", within_deg=30)
    )
    failure = (
        d.Any(d.Below("row", height=0.3))
        | d.Below("last", height=0.3)
        | d.Below("spare", height=0.3)
        | too_early
    )
    stages = {
        "held": held,
        "row complete": row_complete,
        "all down": all_down,
        "stays down": success,
    }
    fallen = d.Fraction(d.Count(~d.Upright("row", within_deg=45)), of=3)
    reward = (
        d.Distance("reach", "left.tcp", "spare", 0.5, agent="left"),
        d.Distance("carry", "spare", "gap", 2.0),
        d.Bonus("complete", row_complete & ~d.Once(too_early), 1.0),
        d.Distance("approach", "right.tcp", "row_3", 0.5, agent="right"),
        d.Bonus("down", all_down & ~d.Once(too_early), 4.0),
    )

    progress = d.Ladder(
        d.Closeness("left.tcp", "spare"),
        (held, 1.5 + d.Closeness("spare", "gap")),
        (row_complete, 3.0 + d.Closeness("right.tcp", "row_3") + 0.5 * fallen),
        (all_down, 5.0 + d.Fraction(d.Duration(all_down), of=1.0)),
        (success, 6.5),
    )
    setback = d.Then(held, d.Sustained(~held & ~row_complete, seconds=0.5))
