"""Serve Named Side: success and reward."""

from taskbuilder import description as d


class ServeNamedSide(d.Description):
    """Where the named table stands, near or far, is drawn anew in each episode."""

    held = d.Held("tray", by=("left", "right"))
    lifted = held & d.Above("tray", "table.top", height=0.08)
    standing = d.On("mug", "tray") & d.Upright("mug", within_deg=15)
    served = d.On("tray", "wanted") & d.Near("tray", "on_wanted", within=0.05) & standing
    let_go = served & d.Released("tray") & d.Level("tray", within_deg=6)

    success = d.Sustained(let_go, seconds=1.0)
    failure = (
        d.On("tray", "other")
        | ~d.Upright("mug", within_deg=45)
        | d.Below("tray", height=0.35)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"held": held, "lifted": lifted, "on the table": served, "let go": let_go}
    stages["kept there"] = success
    reward = (
        d.Distance("reach", "left.tcp", "tray.left", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "tray.right", 0.5, agent="right"),
        d.Distance("carry", "tray", "on_wanted"),
        d.Bonus("held", held | served, 0.5),
        d.Bonus("let go", let_go, 3.0),
    )

    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "tray.left") + 0.5 * d.Closeness("right.tcp", "tray.right"),
        (held, 1.5 + d.Fraction(d.Height("tray", "table.top"), of=0.08)),
        (lifted, 2.6 + 1.5 * d.Closeness("tray", "on_wanted", scale=0.4)),
        (served, 4.2 + 0.5 * (d.GripperOpening("left") + d.GripperOpening("right"))),
        (let_go, 5.4 + d.Fraction(d.Duration(let_go), of=1.0)),
        (success, 7.0),
    )
    setback = d.Then(lifted, d.Sustained(~held & ~served & ~d.Once(success), seconds=0.5))
