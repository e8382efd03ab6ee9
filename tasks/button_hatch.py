"""Button Hatch: success and reward."""

from taskbuilder import description as d


class ButtonHatch(d.Description):
    """The hatch is locked while the button is up, so that one arm cannot open it alone."""

    button_down = d.JointPosition("button.press", above=0.008)
    gripped = d.Held("chest.lid", by="left")
    opened = d.JointAngle("chest.hinge", above_deg=75)
    taken = opened & d.Held("cube", by="left")
    on_plate = opened & d.On("cube", "plate") & d.Near("cube", "on_plate", within=0.04)
    let_go = on_plate & d.Released("cube") & d.Stationary("cube")

    success = d.Sustained(let_go, seconds=1.0)
    failure = d.Below("cube", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {"unlocked": button_down, "opened": opened, "taken": taken, "placed": let_go}
    stages["kept there"] = success
    reward = (
        d.Distance("press", "right.tcp", "button.cap", 0.2, agent="right"),
        d.Distance("reach", "left.tcp", "cube", 0.3, agent="left"),
        d.Distance("carry", "cube", "on_plate"),
        d.Bonus("unlocked", button_down | opened, 0.2, agent="right"),
        d.Bonus("opened", opened, 0.8, agent="left"),
        d.Bonus("placed", let_go, 3.0),
    )

    lifted = d.Fraction(d.Height("chest.lid", "chest") - 0.1, of=0.08)
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "chest.grip") + 0.5 * d.Closeness("right.tcp", "button.cap"),
        (button_down, 1.1 + 0.4 * d.Closeness("left.tcp", "chest.grip")),
        (button_down & gripped, 1.6 + lifted),
        (opened, 2.8 + d.Closeness("left.tcp", "cube.top")),
        (taken, 4.0 + 1.5 * d.Closeness("cube", "on_plate", scale=0.4)),
        (on_plate, 5.6 + d.GripperOpening("left")),
        (let_go, 6.7 + d.Fraction(d.Duration(let_go), of=1.0)),
        (success, 8.0),
    )
    setback = d.Then(taken, d.Sustained(~taken & ~on_plate & ~d.Once(success), seconds=0.5))
