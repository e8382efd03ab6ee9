"""Load the Stretcher: success and reward."""

from taskbuilder import description as d

GRIPS = {"left": "left_end", "right": "right_end"}


class LoadTheStretcher(d.Description):
    """The canister stands on the stretcher, let go of, while two arms hold that level in the air."""

    carried = d.All(*(d.Held(f"stretcher.{arm}_grip", by=arm) for arm in GRIPS))
    aloft = (
        carried
        & d.Above("stretcher", "table.top", height=0.12)
        & d.Level("stretcher", within_deg=6)
    )
    taken = d.Held("canister", by="loader")
    loaded = d.On("canister", "stretcher.pad") & d.Upright("canister", within_deg=10)
    done = aloft & loaded & d.Released("canister") & d.Stationary("canister", speed=0.03)

    success = d.Sustained(done, seconds=1.0)
    failure = (
        d.Below("canister", height=0.38)
        | d.Below("stretcher", height=0.38)
        | d.Any(*(d.ForceAbove(arm, "loader", newtons=100) for arm in GRIPS))
    )
    stages = {"aloft": aloft, "on the pad": aloft & loaded, "let go": done, "kept there": success}
    reward = (
        *(
            d.Distance("reach", f"{a}.tcp", f"stretcher.{g}", 0.3, agent=a)
            for a, g in GRIPS.items()
        ),
        d.Distance("reach", "loader.tcp", "canister.body", 0.3, agent="loader"),
        d.Distance("lift", "stretcher", "aloft"),
        d.Distance("load", "canister", "stretcher.pad"),
        d.Bonus("carried", aloft, 0.2),
        d.Bonus("loaded", done, 3.0),
    )

    progress = d.Ladder(
        d.Mean(*(d.Closeness(f"{a}.tcp", f"stretcher.{g}") for a, g in GRIPS.items())),
        (carried, 1.2 + d.Fraction(d.Height("stretcher", "table.top") - 0.02, of=0.14)),
        (aloft, 2.4 + d.Closeness("canister", "stretcher.pad", scale=0.3)),
        (aloft & loaded, 3.6 + d.GripperOpening("loader")),
        (done, 4.8 + d.Fraction(d.Duration(done), of=1.0)),
        (success, 6.5),
    )
