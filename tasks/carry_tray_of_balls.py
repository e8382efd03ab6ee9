"""Carry Tray of Balls: success and reward."""

from taskbuilder import description as d


class CarryTrayOfBalls(d.Description):
    """Held by one handle the tray tips and its balls roll out, so it is carried by both."""

    left_held, right_held = (d.Held(f"tray.{side}_handle", by=side) for side in ("left", "right"))
    all_on = d.All(d.Inside("balls", "tray"))
    carried = left_held & right_held & all_on & ~d.On("tray", "table")
    across = carried & d.Near("tray", "mat", within=0.08, axes="xy")
    on_mat = d.On("tray", "mat") & d.Near("tray", "mat", within=0.06, axes="xy") & all_on
    set_down = on_mat & d.Released("tray") & d.Level("tray", within_deg=3)

    success = d.Sustained(set_down, seconds=1.0)
    failure = (
        d.Any(~d.Inside("balls", "tray"))
        | d.Below("tray", height=0.38)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"lifted": carried, "across": across, "set down": set_down, "kept there": success}
    reward = (
        d.Distance("reach", "left.tcp", "tray.left_grip", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "tray.right_grip", 0.5, agent="right"),
        d.Distance("carry", "tray", "mat"),
        d.Bonus("lift", carried | set_down, 0.5),
        d.Bonus("set down", set_down, 3.0),
    )

    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "tray.left_grip")
        + 0.5 * d.Closeness("right.tcp", "tray.right_grip"),
        (left_held & right_held, 1.5),
        (carried, 2.0 + d.Closeness("tray", "mat", scale=0.4)),
        (across, 3.2 + d.Closeness("tray", "mat", scale=0.1)),
        (on_mat, 4.4 + 0.5 * (d.GripperOpening("left") + d.GripperOpening("right"))),
        (set_down, 5.5 + d.Fraction(d.Duration(set_down), of=1.0)),
        (success, 7.0),
    )
    setback = d.Then(carried, d.Sustained(~carried & ~on_mat & ~d.Once(success), seconds=0.5))
