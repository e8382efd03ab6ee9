"""Carry Table: success and reward."""

from taskbuilder import description as d

ARMS = ("front_left", "front_right", "back_left", "back_right")


class CarryTable(d.Description):
    """All four arms have carried the small table, it stands on the mark, and the vase stands."""

    held = d.All(*(d.Held(f"desk.knob_{n}", by=arm) for n, arm in enumerate(ARMS, start=1)))
    vase_stands = d.On("vase", "desk") & d.Upright("vase", within_deg=10)
    lifted = held & vase_stands & d.Above("desk", "table.top", height=0.06)
    over = lifted & d.Near("desk", "goal", within=0.04, axes="xy")
    there = d.On("desk", "table") & d.Near("desk", "goal", within=0.04) & vase_stands
    let_go = d.Released("desk") & d.Level("desk", within_deg=3)
    set_down = d.Once(lifted) & there & let_go

    success = d.Sustained(set_down, seconds=1.0)
    failure = (
        d.Below("desk", height=0.35)
        | ~d.Upright("vase", within_deg=45)
        | d.ForceAbove("front_left", "back_left", newtons=100)
        | d.ForceAbove("front_right", "back_right", newtons=100)
    )
    stages = {"lifted": lifted, "over the mark": over, "set down": set_down, "kept there": success}
    reward = (
        *(
            d.Distance("reach", f"{arm}.tcp", f"desk.grip_{n}", 0.3, agent=arm)
            for n, arm in enumerate(ARMS, start=1)
        ),
        d.Distance("carry", "desk", "goal"),
        d.Bonus("lift", lifted | set_down, 0.5),
        d.Bonus("set down", set_down, 3.0),
    )

    near = d.Closeness("desk", "goal")
    opening = d.Mean(*(d.GripperOpening(arm) for arm in ARMS))
    progress = d.Ladder(
        d.Mean(
            *(d.Closeness(f"{arm}.tcp", f"desk.grip_{n}") for n, arm in enumerate(ARMS, start=1))
        ),
        (held & vase_stands, 1.5 + near),
        (lifted, 2.6 + near),
        (d.Once(lifted) & there, 3.7 + opening),
        (set_down, 4.8 + d.Fraction(d.Duration(set_down), of=1.0)),
        (success, 6.5),
    )
    setback = d.Then(lifted, d.Sustained(~held & ~there & ~d.Once(success), seconds=0.5))
