"""Pass Crayon: success and reward."""

from taskbuilder import description as d


class PassCrayon(d.Description):
    """Only the crayon of the named colour is passed on; the right arm takes no other one."""

    taken = d.Held("crayon", by="left")
    handed_over = d.Held("crayon", by="right") & ~taken
    on_paper = d.On("crayon", "paper") & d.Near("crayon", "on_paper", within=0.06)
    laid = on_paper & d.Released("crayon") & d.Stationary("crayon")
    wrong = d.Any(
        *(d.Held(other, by="right") | d.On(other, "paper") for other in ("second", "third"))
    )

    success = d.Sustained(laid, seconds=1.0)
    failure = (
        wrong
        | d.Any(*(d.Below(one, height=0.35) for one in ("crayon", "second", "third")))
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"taken": taken, "handed over": handed_over, "laid": laid, "kept there": success}
    reward = (
        d.Distance("reach", "left.tcp", "crayon", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "crayon", 0.5, agent="right"),
        d.Distance("carry", "crayon", "on_paper"),
        d.Bonus("taken", taken | handed_over | on_paper, 0.3, agent="left"),
        d.Bonus("handed over", handed_over | on_paper, 1.0),
        d.Bonus("laid", laid, 3.0),
    )

    lift = d.Fraction(d.Height("crayon", "table.top"), of=0.1)
    progress = d.Ladder(
        d.Closeness("left.tcp", "crayon.left_end"),
        (
            taken,
            1.3
            + 0.7 * d.Closeness("crayon", "meeting", scale=0.3)
            + lift * d.Closeness("right.tcp", "crayon.right_end", scale=0.3),
        ),
        (d.Held("crayon", by="right"), 3.1),
        (handed_over, 3.3 + 1.5 * d.Closeness("crayon", "on_paper", scale=0.4)),
        (on_paper, 4.9 + 0.5 * d.GripperOpening("right")),
        (laid, 5.6 + d.Fraction(d.Duration(laid), of=1.0)),
        (success, 7.0),
    )
    held = taken | d.Held("crayon", by="right")
    setback = d.Then(held, d.Sustained(~held & ~on_paper & ~d.Once(success), seconds=0.5))
