"""PedestalRelay: success and reward."""

from taskbuilder import description as d


class PedestalRelay(d.Description):
    """The arms never hold the block together: it stands on the pedestal in between."""

    taken = d.Held("block", by="left")
    set_down = d.On("block", "pedestal") & d.Released("block") & d.Upright("block", within_deg=15)
    fetched = d.Then(set_down, d.Held("block", by="right"))
    served = fetched & d.On("block", "plate") & d.Released("block")

    success = d.Sustained(served & d.Stationary("block"), seconds=1.0)
    failure = d.Below("block", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {
        "taken": taken,
        "on the pedestal": set_down,
        "fetched": fetched,
        "on the plate": served,
        "kept there": success,
    }
    reward = (
        d.Distance("reach", "left.tcp", "block", 0.3, agent="left"),
        d.Distance("reach", "right.tcp", "block", 0.3, agent="right"),
        d.Distance("carry", "block", "on_plate"),
        d.Bonus("grasp", taken, 0.2, agent="left"),
        d.Bonus("set_down", set_down | fetched, 0.6),
        d.Bonus("fetched", fetched, 0.6),
        d.Bonus("served", served, 2.0),
    )

    progress = d.Ladder(
        d.Closeness("left.tcp", "block.top"),
        (taken, 1.2 + d.Closeness("block", "on_pedestal", scale=0.3)),
        (set_down, 2.3 + d.Closeness("right.tcp", "block.top")),
        (fetched, 3.4 + d.Closeness("block", "on_plate", scale=0.3)),
        (served, 4.5 + d.Fraction(d.Duration(served), of=1.0)),
        (success, 6.0),
    )
    held = taken | d.Held("block", by="right")
    setback = d.Then(held, d.Sustained(~held & ~set_down & ~served & ~d.Once(success), seconds=0.5))
