"""Covered Well: success and reward."""

from taskbuilder import description as d


class CoveredWell(d.Description):
    """Only the cup can lift the flat lid, and only the hand reaches the mark."""

    opened = d.Held("lid", by="cup") & d.Above("lid", "well", height=0.12)
    taken = d.Held("block", by="hand")
    on_mark = d.Near("block", "mark", within=0.05, axes="xy") & d.On("block", "mark")
    put = on_mark & d.Released("block") & d.Stationary("block")
    covered = d.On("lid", "well") & d.Near("lid", "seat", within=0.03) & d.Released("lid")
    done = put & covered

    success = d.Sustained(done, seconds=1.0)
    failure = (
        d.Below("block", height=0.35)
        | d.Below("lid", "well", height=0.06)
        | d.ForceAbove("cup", "hand", newtons=100)
    )
    stages = {
        "opened": opened,
        "taken": taken,
        "put": put,
        "covered again": done,
        "kept so": success,
    }
    reward = (
        d.Distance("reach", "cup.tcp", "lid.top", 0.3, agent="cup"),
        d.Distance("reach", "hand.tcp", "block.top", 0.3, agent="hand"),
        d.Distance("carry", "block", "mark", agent="hand"),
        d.Bonus("open", opened | put, 0.5, agent="cup"),
        d.Bonus("put", put, 2.0, agent="hand"),
        d.Bonus("done", done, 3.0),
    )
    progress = d.Ladder(
        d.Closeness("cup.tcp", "lid.top"),
        (d.Held("lid", by="cup"), 1.2 + d.Fraction(d.Height("lid", "well") - 0.078, of=0.05)),
        (opened, 2.4 + d.Closeness("hand.tcp", "block.top")),
        (taken, 3.6 + d.Closeness("block", "mark", scale=0.4)),
        (put, 4.8 + d.Closeness("lid", "seat", scale=0.4)),
        (done, 6.0 + d.Fraction(d.Duration(done), of=1.0)),
        (success, 8.0),
    )
