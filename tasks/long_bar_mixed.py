"""Long Bar Mixed: success and reward."""

from taskbuilder import description as d

GRIPS = {"left": "left_end", "back": "middle", "right": "right_end"}
HELD = {"left": "left_grip", "back": "middle_grip", "right": "right_grip"}


class LongBarMixed(d.Description):
    """The bar lies level on both trestles, let go of, after all three arms have lifted it."""

    each_held = tuple(d.Held(f"bar.{part}", by=arm) for arm, part in HELD.items())
    all_held = d.All(*each_held)
    lifted = all_held & d.Above("bar", "table.top", height=0.08) & d.Level("bar", within_deg=10)
    on_both = d.On("bar", "left_trestle") & d.On("bar", "right_trestle")
    there = on_both & d.Near("bar", "deck", within=0.06)
    laid = d.Then(lifted, there) & there & d.Released("bar") & d.Level("bar", within_deg=3)

    success = d.Sustained(laid, seconds=1.0)
    failure = d.Below("bar", height=0.38) | d.Any(
        *(d.ForceAbove(arm, "back", newtons=100) for arm in ("left", "right"))
    )
    stages = {"all hold": all_held, "lifted": lifted, "on the trestles": d.Then(lifted, there)}
    stages |= {"let go": laid, "kept there": success}
    reward = (
        *(d.Distance("reach", f"{a}.tcp", f"bar.{g}", 0.3, agent=a) for a, g in GRIPS.items()),
        *(d.Bonus("grasp", d.Held(f"bar.{p}", by=a), 0.1, agent=a) for a, p in HELD.items()),
        d.Distance("carry", "bar", "deck"),
        d.Bonus("laid", laid, 3.0),
    )

    near = d.Closeness("bar", "deck", scale=0.3)
    raised = d.Fraction(d.Height("bar", "table.top") - 0.025, of=0.12)
    opening = d.Mean(*(d.GripperOpening(arm) for arm in GRIPS))
    progress = d.Ladder(
        d.Mean(*(d.Closeness(f"{arm}.tcp", f"bar.{grip}") for arm, grip in GRIPS.items()))
        + 0.5 * d.Count(*each_held),
        (all_held, 2.6 + raised),
        (lifted, 3.6 + near),
        (d.Once(lifted) & there, 4.7 + opening),
        (laid, 5.8 + d.Fraction(d.Duration(laid), of=1.0)),
        (success, 7.5),
    )
    setback = d.Then(lifted, d.Sustained(~all_held & ~there & ~d.Once(success), seconds=0.5))
