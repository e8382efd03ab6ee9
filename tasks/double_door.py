"""Double Door: success and reward."""

from taskbuilder import description as d


class DoubleDoor(d.Description):
    """Springs shut a leaf as soon as its knob is let go of, so each is held open by an arm."""

    left_held = d.Held("cabinet.left_leaf", by="left")
    right_held = d.Held("cabinet.right_leaf", by="right")
    left_open = d.JointAngle("cabinet.left_hinge", above_deg=50)
    right_open = d.JointAngle("cabinet.right_hinge", above_deg=50)
    opened = left_open & right_open & left_held & right_held

    success = d.Sustained(opened, seconds=1.0)
    failure = d.ForceAbove("left", "right", newtons=100)
    stages = {"both held": left_held & right_held, "both open": opened, "kept open": success}
    reward = (
        d.Distance("reach", "left.tcp", "cabinet.left_knob", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "cabinet.right_knob", 0.5, agent="right"),
        d.Bonus("take", left_held, 0.2, agent="left"),
        d.Bonus("take", right_held, 0.2, agent="right"),
        d.Bonus("ajar", d.JointAngle("cabinet.left_hinge", above_deg=25), 0.2, agent="left"),
        d.Bonus("ajar", d.JointAngle("cabinet.right_hinge", above_deg=25), 0.2, agent="right"),
        d.Bonus("open", opened, 3.0),
    )

    wide = d.Mean(
        *(
            d.Fraction(
                d.Count(
                    *(
                        d.JointAngle(f"cabinet.{side}_hinge", above_deg=deg)
                        for deg in (10, 20, 30, 40, 50)
                    )
                ),
                of=5,
            )
            for side in ("left", "right")
        )
    )
    progress = d.Ladder(
        d.Closeness("left.tcp", "cabinet.left_knob")
        + d.Closeness("right.tcp", "cabinet.right_knob"),
        (left_held & right_held, 2.5 + 2.0 * wide),
        (opened, 4.7 + d.Fraction(d.Duration(opened), of=1.0)),
        (success, 6.5),
    )
    setback = d.Then(left_held & right_held, d.Sustained(~left_held | ~right_held, seconds=0.5))
