"""StandCarton: success and reward."""

from taskbuilder import description as d


class StandCarton(d.Description):
    """The carton stands upright on the coaster, let go of."""

    held = d.Held("carton", by="arm")
    raised = held & d.Upright("carton", within_deg=15)
    over = d.Near("carton", "on_coaster", within=0.04, axes="xy")
    standing = d.On("carton", "coaster") & over & d.Upright("carton", within_deg=8)
    let_go = standing & d.Released("carton") & d.Stationary("carton")

    success = d.Sustained(let_go, seconds=1.0)
    failure = d.Below("carton", height=0.38) | d.ForceAbove("arm", "table", newtons=100)
    stages = {
        "held": held,
        "upright": raised,
        "standing": standing,
        "let go": let_go,
        "kept there": success,
    }

    # the neck is 55 mm above the middle of the carton when the carton is upright
    turned = d.Fraction(d.Height("carton.neck", "carton"), of=0.05)
    reward = (
        d.Paid("reach", d.Ladder(d.Closeness("arm.tcp", "carton.neck"), (standing, 1.0)), 0.3),
        d.Bonus("take", held | standing, 0.3),
        d.Paid("turn", turned, 0.4),
        d.Distance("carry", "carton", "on_coaster"),
        d.Bonus("standing", standing, 0.5),
        d.Bonus("let go", let_go, 2.0),
    )

    progress = d.Ladder(
        d.Closeness("arm.tcp", "carton.neck"),
        (held, 1.2 + turned + turned * d.Closeness("carton", "on_coaster", scale=0.3)),
        (standing, 3.3 + 0.5 * d.GripperOpening("arm")),
        (let_go, 4.0 + d.Fraction(d.Duration(let_go), of=1.0)),
        (success, 5.2),
    )
    setback = d.Then(held, d.Sustained(~held & ~standing & ~d.Once(success), seconds=0.5))
