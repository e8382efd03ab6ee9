"""Lift Triangle: success and reward."""

from taskbuilder import description as d

SIDES = ("left", "right", "back")


class LiftTriangle(d.Description):
    """The tray is held by all three handles and level, and the bottle on it stands at the goal."""

    left_held, right_held, back_held = (d.Held(f"tray.{side}_handle", by=side) for side in SIDES)
    all_held = left_held & right_held & back_held
    standing = d.On("bottle", "tray") & d.Upright("bottle", within_deg=10)
    lifted = all_held & standing & ~d.On("tray", "table")
    presented = lifted & d.Near("bottle", "goal", within=0.05) & d.Level("tray", within_deg=5)

    success = d.Sustained(presented, seconds=1.0)
    failure = (
        d.Below("tray", height=0.35)
        | d.Below("bottle", "tray", height=-0.02)
        | ~d.Upright("bottle", within_deg=45)
        | d.ForceAbove("left", "right", newtons=100)
        | d.ForceAbove("left", "back", newtons=100)
        | d.ForceAbove("right", "back", newtons=100)
    )
    stages = {"all hold": all_held, "lifted": lifted, "at the goal": presented, "kept so": success}
    reward = (
        *(d.Distance("reach", f"{s}.tcp", f"tray.{s}_top", 0.5, agent=s) for s in SIDES),
        *(d.Bonus("grasp", d.Held(f"tray.{s}_handle", by=s), 0.2, agent=s) for s in SIDES),
        d.Distance("lift", "bottle", "goal"),
        d.Bonus("goal", presented, 3.0),
    )

    lowest = d.Minimum(*(d.Height(f"tray.{s}_handle", "table.top") for s in SIDES))
    progress = d.Ladder(
        d.Mean(*(d.Closeness(f"{s}.tcp", f"tray.{s}_top") for s in SIDES))
        + 0.5 * d.Count(left_held, right_held, back_held),
        (all_held, 3.0 + d.Fraction(lowest - 0.065, of=0.1)),
        (lifted, 4.1 + d.Fraction(lowest - 0.065, of=0.1) + d.Closeness("bottle", "goal")),
        (presented, 6.2 + d.Fraction(d.Duration(presented), of=1.0)),
        (success, 8.0),
    )
    setback = d.Then(lifted, d.Sustained(~lifted & ~d.Once(success), seconds=0.5))
