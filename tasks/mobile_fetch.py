"""Mobile Fetch: success and reward."""

from taskbuilder import description as d


class MobileFetch(d.Description):
    """The cup comes from the side table to the other one, and ends upright on the coaster."""

    fetched, taken = d.Held("cup", by="mobile"), d.Held("cup", by="fixed")
    served = d.Once(d.On("cup", "table.top"))
    on_coaster = d.On("cup", "coaster") & d.Upright("cup", within_deg=10)
    handed = d.Then(served, taken)
    placed = handed & on_coaster & d.Released("cup") & d.Stationary("cup")

    success = d.Sustained(placed, seconds=1.0)
    failure = d.Below("cup", height=0.35) | d.ForceAbove("mobile", "fixed", newtons=100)
    stages = {"fetched": fetched, "served": served, "placed": placed, "kept there": success}
    reward = (
        d.Distance("reach", "mobile.tcp", "cup.middle", 0.3, agent="mobile"),
        d.Distance("carry", "cup", "on_coaster"),
        d.Bonus("served", served, 1.0, agent="mobile"),
        d.Bonus("taken", served & taken, 1.0, agent="fixed"),
        d.Bonus("placed", placed, 6.0),
    )

    progress = d.Ladder(
        d.Closeness("mobile.tcp", "cup.middle", scale=0.5),
        (fetched, 1.2 + d.Closeness("cup", "serving", scale=1.5)),
        (served, 2.5 + d.Closeness("fixed.tcp", "cup.middle", scale=0.4)),
        (served & taken, 3.8 + d.Closeness("cup", "on_coaster", scale=0.4)),
        (handed & on_coaster, 5.0 + 0.2 * d.GripperOpening("fixed")),
        (placed, 5.5 + d.Fraction(d.Duration(placed), of=1.0)),
        (success, 7.5),
    )
    setback = d.Then(taken, d.Sustained(d.Released("cup") & ~on_coaster & ~success, seconds=0.5))
