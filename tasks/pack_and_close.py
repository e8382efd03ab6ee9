"""Pack and Close: success and reward."""

from taskbuilder import description as d

SIDES = ("left", "right")


class PackAndClose(d.Description):
    """Both blocks are in the chest, each put there by its own arm, and the lid is shut."""

    each_in = tuple(
        d.Inside(f"{side}_block", "chest.case") & d.Released(f"{side}_block") for side in SIDES
    )
    packed = d.All(*each_in)
    knob_held = packed & d.Held("chest.lid")
    shut = d.JointAngle("chest.hinge", below_deg=4)
    done = packed & shut & d.Released("chest.lid")

    success = d.Sustained(done, seconds=1.0)
    failure = d.Any(*(d.Below(f"{side}_block", height=0.38) for side in SIDES)) | d.ForceAbove(
        "left", "right", newtons=100
    )
    stages = {"one packed": d.Any(*each_in), "both packed": packed, "lid down": packed & shut}
    stages |= {"let go": done, "kept so": success}
    reward = (
        *(d.Distance("carry", f"{s}_block", f"{s}_room", agent=s) for s in SIDES),
        *(d.Bonus("packed", d.Inside(f"{s}_block", "chest.case"), 0.3, agent=s) for s in SIDES),
        d.Bonus("shut", packed & shut, 1.0),
        d.Bonus("done", done, 2.0),
    )

    each_way = tuple(
        d.Ladder(
            0.5 * d.Closeness(f"{side}.tcp", f"{side}_block.top"),
            (d.Held(f"{side}_block", by=side), 0.6 + d.Closeness(f"{side}_block", f"{side}_room")),
            (put, 1.7),
        )
        for side, put in zip(SIDES, each_in, strict=True)
    )
    lowered = d.Fraction(0.27 - d.Height("chest.knob", "chest"), of=0.12)
    progress = d.Ladder(
        d.Mean(*each_way) * 2,
        (packed, 3.5 + 0.5 * d.Closeness("left.tcp", "chest.knob")),
        (knob_held, 4.1 + lowered),
        (packed & shut, 5.2 + 0.5 * d.GripperOpening("left")),
        (done, 5.9 + d.Fraction(d.Duration(done), of=1.0)),
        (success, 7.5),
    )
    setback = d.Then(packed, d.Sustained(~packed & ~d.Once(success), seconds=0.5))
