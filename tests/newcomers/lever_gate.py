"""LeverGate: success and reward."""

from taskbuilder import description as d


class LeverGate(d.Description):
    """The lever frees the gate, and the block rests behind the gate, let go of."""

    gripped = d.Held("lever.bar", by="arm")
    unlocked = d.JointAngle("lever.pivot", above_deg=50)
    free = unlocked & ~d.Contact("lever", robot="arm")
    swung = unlocked & d.JointAngle("gate.hinge", above_deg=30)
    there = swung & d.Near("block", "goal", within=0.04, axes="xy")
    let_go = there & d.Released("block") & d.Stationary("block")

    success = d.Sustained(let_go, seconds=1.0)
    failure = d.Below("block", height=0.38) | d.ForceAbove("block", "gate", newtons=60)
    stages = {
        "lever held": gripped,
        "unlocked": unlocked,
        "gate pushed open": swung,
        "on the mark": there,
        "kept there": success,
    }

    turned = d.Fraction(
        d.Count(*(d.JointAngle("lever.pivot", above_deg=deg) for deg in (10, 20, 30, 40, 50))), of=5
    )
    reward = (
        d.Paid("lever", d.Ladder(d.Closeness("arm.tcp", "lever.grip"), (unlocked, 1.0)), 0.3),
        d.Paid("turn", turned, 0.4),
        d.Distance("push", "block", "goal", 2.0),
        d.Bonus("swung", swung, 0.5),
        d.Bonus("there", there, 0.5),
        d.Bonus("let go", let_go, 2.0),
    )

    progress = d.Ladder(
        d.Closeness("arm.tcp", "lever.grip"),
        (gripped, 1.2 + turned),
        (unlocked, 2.3 + 0.4 * d.GripperOpening("arm")),
        (free, 2.8 + 0.5 * d.Closeness("arm.tcp", "block")),
        (swung, 3.4 + d.Closeness("block", "goal")),
        (there, 4.5),
        (let_go, 4.8 + d.Fraction(d.Duration(let_go), of=1.0)),
        (success, 6.0),
    )
    setback = d.Then(unlocked, d.Sustained(~unlocked & ~d.Once(success), seconds=0.5))
