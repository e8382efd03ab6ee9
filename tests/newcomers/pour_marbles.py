"""PourMarbles: success and reward."""

from taskbuilder import description as d


class PourMarbles(d.Description):
    """The marbles are poured from the cup into the bowl, and the empty cup is held upright above its stand."""

    held = d.Held("cup", by="arm")
    over_bowl = held & d.Near("cup", "over", within=0.05)
    poured = d.Inside("marbles", "bowl") & ~d.Inside("marbles", "cup")
    first_poured = held & d.AtLeast(1, poured)
    emptied = held & d.AtLeast(5, poured)
    brought_back = emptied & d.Near("cup", "rest", within=0.05) & d.Upright("cup", within_deg=10)

    success = d.Sustained(brought_back, seconds=1.0)
    failure = d.Any(d.Below("marbles", height=0.3)) | d.Below("cup", height=0.38)
    stages = {
        "held": held,
        "over bowl": over_bowl,
        "emptied": emptied,
        "brought back": brought_back,
        "stays": success,
    }
    progress = d.Ladder(
        d.Closeness("arm.tcp", "cup"),
        (held, 1.5 + d.Closeness("cup", "over")),
        (first_poured, 2.5 + 0.25 * d.Count(poured)),
        (emptied, 4.0 + d.Closeness("cup", "rest")),
        (brought_back, 5.5 + d.Fraction(d.Duration(brought_back), of=1.0)),
        (success, 7.0),
    )
    setback = d.Then(held, d.Sustained(~held, seconds=0.3))
    reward = (
        d.Distance("reach", "arm.tcp", "cup"),
        d.Paid("carry", d.Ladder(0.0, (held, 0.5 + 0.5 * d.Closeness("cup", "over")))),
        d.Paid(
            "poured",
            d.Ladder(
                0.0, (held, 0.3 * d.Count(poured)), (emptied, 2.0 + d.Closeness("cup", "rest"))
            ),
        ),
        d.Bonus("brought back", brought_back, 3.0),
    )
