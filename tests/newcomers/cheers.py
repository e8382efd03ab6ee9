"""Cheers: success and reward."""

from taskbuilder import description as d

NAMES = ("left", "front", "back")
PAIRS = (("left", "front"), ("front", "back"), ("back", "left"))


class Cheers(d.Description):
    """Three arms each raise a glass by its stem, and clink all three together in the middle."""

    left_holds = d.Held("left_glass", by="left")
    front_holds = d.Held("front_glass", by="front")
    back_holds = d.Held("back_glass", by="back")
    all_hold = left_holds & front_holds & back_holds

    raised = all_hold & d.All(*[d.Above(f"{n}_glass", "table", height=0.25) for n in NAMES])
    clinked = d.Once(d.All(*[d.Contact(f"{a}_glass", f"{b}_glass") for a, b in PAIRS]))
    together = (
        raised
        & d.All(*[d.Upright(f"{n}_glass", within_deg=15) for n in NAMES])
        & d.All(*[d.Near(f"{n}_glass", "toast", within=0.08) for n in NAMES])
        & d.All(*[d.Near(f"{a}_glass", f"{b}_glass", within=0.095) for a, b in PAIRS])
    )
    toasting = together & clinked

    success = d.Sustained(toasting, seconds=1.0)
    failure = (
        d.Any(*[d.Below(f"{n}_glass", height=0.4) for n in NAMES])
        | d.Any(*[~d.Upright(f"{n}_glass", within_deg=60) for n in NAMES])
        | d.Any(*[d.ForceAbove(a, b, newtons=100) for a, b in PAIRS])
    )
    stages = {"all hold": all_hold, "raised": raised, "toasting": toasting, "kept so": success}
    reward = (
        *[d.Distance("reach", f"{n}.tcp", f"{n}_glass.stem", 0.5, agent=n) for n in NAMES],
        *[d.Bonus("grasp", d.Held(f"{n}_glass", by=n), 0.2, agent=n) for n in NAMES],
        *[d.Distance("raise", f"{n}_glass", "toast", agent=n) for n in NAMES],
        d.Bonus("clink", toasting, 3.0),
    )

    near = d.Mean(*[d.Closeness(f"{n}_glass", "toast") for n in NAMES])
    progress = d.Ladder(
        d.Mean(*[d.Closeness(f"{n}.tcp", f"{n}_glass.stem") for n in NAMES])
        + 0.4 * d.Count(left_holds, front_holds, back_holds),
        (all_hold, 2.2 + near),
        (raised, 3.0 + near),
        (toasting, 4.2 + d.Fraction(d.Duration(toasting), of=1.0)),
        (success, 5.5),
    )
    setback = d.Any(
        *[
            d.Sustained(
                d.Once(d.Held(f"{n}_glass", by=n)) & ~d.Held(f"{n}_glass", by=n), seconds=0.5
            )
            for n in NAMES
        ]
    )
