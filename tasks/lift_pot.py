"""Lift Pot: success and reward."""

from taskbuilder import description as d


class LiftPot(d.Description):
    """Held by one handle the pot tips and its lid slides off, so both are lifted as one."""

    left_held, right_held = (d.Held(f"pot.{side}_handle", by=side) for side in ("left", "right"))
    covered = d.On("lid", "pot") & d.Near("lid", "pot", within=0.03, axes="xy")
    lifted = left_held & right_held & covered & ~d.On("pot", "table")
    over = lifted & d.Near("pot", "hob.plate", within=0.04, axes="xy")
    standing = d.On("pot", "hob.plate") & d.Near("pot", "hob.plate", within=0.04, axes="xy")
    set_down = standing & d.Level("pot", within_deg=3) & covered & d.Released("pot")

    success = d.Sustained(set_down, seconds=1.0)
    failure = (
        d.Below("pot", height=0.35)
        | d.Below("lid", "pot", height=0.09)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"lifted": lifted, "over the hob": over, "set down": set_down, "kept there": success}
    reward = (
        d.Distance("reach", "left.tcp", "pot.left_grip", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "pot.right_grip", 0.5, agent="right"),
        d.Distance("carry", "pot", "hob.plate"),
        d.Bonus("lift", lifted | set_down, 0.5),
        d.Bonus("set down", set_down, 3.0),
    )

    near = d.Closeness("pot", "hob.plate")
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "pot.left_grip")
        + 0.5 * d.Closeness("right.tcp", "pot.right_grip"),
        (left_held & right_held & covered, 1.5 + near),
        (lifted, 2.5 + near),
        (standing & covered, 3.7 + 0.5 * (d.GripperOpening("left") + d.GripperOpening("right"))),
        (set_down, 4.8 + d.Fraction(d.Duration(set_down), of=1.0)),
        (success, 6.5),
    )
    setback = d.Then(lifted, d.Sustained(~lifted & ~standing & ~d.Once(success), seconds=0.5))
