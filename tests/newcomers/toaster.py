"""Toaster: success and reward."""

from taskbuilder import description as d


class Toaster(d.Description):
    """A spring pulls the toast out of reach as soon as nobody holds the knob."""

    raised = d.Held("toaster.lift", by="left") & d.JointPosition("toaster.carriage", above=0.06)
    taken = d.Held("toast", by="right")
    out = taken & d.Above("toast", "toaster", height=0.2)
    on_plate = d.On("toast", "plate") & d.Near("toast", "plate", within=0.06, axes="xy")
    served = on_plate & d.Released("toast")
    done = served & d.Released("toaster.lift") & d.JointPosition("toaster.carriage", below=0.01)

    success = d.Sustained(done, seconds=1.0)
    failure = d.Below("toast", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {"raised": raised, "out": out, "served": served, "lift down": done, "kept so": success}
    reward = (
        d.Distance("reach", "left.tcp", "toaster.knob", 0.3, agent="left"),
        d.Distance("reach", "right.tcp", "toast.top", 0.3, agent="right"),
        d.Distance("carry", "toast", "plate", agent="right"),
        d.Bonus("raise", raised | served, 0.5, agent="left"),
        d.Bonus("serve", served, 2.0, agent="right"),
        d.Bonus("done", done, 3.0),
    )
    progress = d.Ladder(
        d.Closeness("left.tcp", "toaster.knob"),
        (
            d.Held("toaster.lift", by="left"),
            1.1 + d.Fraction(d.Height("toast", "toaster") - 0.063, of=0.07),
        ),
        (raised, 2.2 + d.Closeness("right.tcp", "toast.top")),
        (taken, 3.4 + d.Closeness("toast", "plate", scale=0.4)),
        (served, 5.0),
        (done, 6.0 + d.Fraction(d.Duration(done), of=1.0)),
        (success, 8.0),
    )
