"""ColourTrays: success and reward."""

from taskbuilder import description as d


class ColourTrays(d.Description):
    """Each cube belongs in the tray of its colour; either may come first."""

    warm_in = d.Inside("warm", "warm_tray") & d.Released("warm")
    cool_in = d.Inside("cool", "cool_tray") & d.Released("cool")
    sorted_out = warm_in & cool_in

    success = d.Sustained(sorted_out, seconds=1.0)
    failure = (
        d.Inside("warm", "cool_tray")
        | d.Inside("cool", "warm_tray")
        | d.Below("warm", height=0.35)
        | d.Below("cool", height=0.35)
    )
    stages = {
        "one cube taken": d.Once(d.Held("warm") | d.Held("cool")),
        "one cube sorted": warm_in | cool_in,
        "both sorted": sorted_out,
        "kept there": success,
    }
    reward = (
        d.Distance("carry_warm", "warm", "warm_tray"),
        d.Distance("carry_cool", "cool", "cool_tray"),
        d.Bonus("grasp", d.Held("warm") | d.Held("cool"), 0.25),
        d.Bonus("warm_in", warm_in, 1.0),
        d.Bonus("cool_in", cool_in, 1.0),
        d.Bonus("sorted", sorted_out, 2.0),
    )

    progress = d.Ladder(
        0.5 * d.Closeness("arm.tcp", "warm") + 0.5 * d.Closeness("arm.tcp", "cool"),
        (d.Held("warm"), 1.2 + d.Closeness("warm", "warm_tray", scale=0.4)),
        (d.Held("cool"), 1.2 + d.Closeness("cool", "cool_tray", scale=0.4)),
        (warm_in, 2.5 + d.Closeness("arm.tcp", "cool")),
        (cool_in, 2.5 + d.Closeness("arm.tcp", "warm")),
        (warm_in & d.Held("cool"), 3.6 + d.Closeness("cool", "cool_tray", scale=0.4)),
        (cool_in & d.Held("warm"), 3.6 + d.Closeness("warm", "warm_tray", scale=0.4)),
        (sorted_out, 4.8 + d.Fraction(d.Duration(sorted_out), of=1.0)),
        (success, 6.0),
    )
    lost = (d.Once(d.Held("warm")) & ~d.Held("warm") & ~d.Inside("warm", "warm_tray")) | (
        d.Once(d.Held("cool")) & ~d.Held("cool") & ~d.Inside("cool", "cool_tray")
    )
    setback = d.Sustained(lost & ~d.Once(success), seconds=0.8)
