"""Open Lid: success and reward."""

from taskbuilder import description as d


class OpenLid(d.Description):
    """A spring shuts the lid as soon as nobody holds it, so the block needs a second arm."""

    opened = d.Held("chest.lid", by="left") & d.JointAngle("chest.hinge", above_deg=65)
    taken = d.Held("block", by="right")
    out = d.Near("block", "mark", within=0.05, axes="xy") & d.On("block", "mark")
    put = out & d.Released("block")
    closed = d.JointAngle("chest.hinge", below_deg=4) & d.Released("chest.lid")
    done = put & closed

    success = d.Sustained(done, seconds=1.0)
    failure = d.Below("block", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {"opened": opened, "taken out": d.Then(taken, out), "shut": done, "kept so": success}
    reward = (
        d.Distance("reach", "left.tcp", "chest.knob", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "block", 0.5, agent="right"),
        d.Distance("carry", "block", "mark"),
        d.Bonus("open", opened | put, 0.5, agent="left"),
        d.Bonus("put", put, 2.0, agent="right"),
        d.Bonus("done", done, 3.0),
    )

    carry = d.Closeness("block", "mark", scale=0.4)
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "chest.knob") + 0.5 * d.Closeness("right.tcp", "mark"),
        (
            d.Held("chest.lid", by="left"),
            1.1 + d.Fraction(d.Height("chest.knob", "chest") - 0.15, of=0.1),
        ),
        (opened, 2.2 + d.Closeness("right.tcp", "block.top")),
        (taken, 3.4 + carry),
        (put, 4.6 + d.Fraction(0.27 - d.Height("chest.knob", "chest"), of=0.12)),
        (done, 6.0 + d.Fraction(d.Duration(done), of=1.0)),
        (success, 8.0),
    )
    setback = d.Then(taken, d.Sustained(~taken & ~out & ~d.Once(success), seconds=0.5))
