"""Pin Assembly: success and reward."""

from taskbuilder.description import (
    Below,
    Bonus,
    Closeness,
    Description,
    Distance,
    Duration,
    ForceAbove,
    Fraction,
    Held,
    Ladder,
    Near,
    Once,
    Released,
    Sustained,
    Then,
)


class PinAssembly(Description):
    """The pin is through the plate and in the block, both held up, and let go of by its arm."""

    parts_held = Held("block", by="left") & Held("plate", by="right")
    aligned = parts_held & Near("plate", "on_block", within=0.02)
    pinned = aligned & Near("pin", "through", within=0.015)
    joined = pinned & Released("pin")

    success = Sustained(joined, seconds=1.0)
    failure = (
        Below("pin", height=0.38)
        | Below("block", height=0.38)
        | Below("plate", height=0.38)
        | ForceAbove("left", "right", newtons=100)
        | ForceAbove("left", "back", newtons=100)
        | ForceAbove("right", "back", newtons=100)
    )
    stages = {"parts held": parts_held, "parts aligned": aligned, "pin inside": pinned}
    reward = (
        Distance("reach", "left.tcp", "block.handle_top", 0.2, agent="left"),
        Distance("reach", "right.tcp", "plate.handle_top", 0.2, agent="right"),
        Distance("reach", "back.tcp", "pin.top", 0.2, agent="back"),
        Distance("align", "plate", "on_block"),
        Distance("join", "pin", "through"),
        Bonus("aligned", aligned, 0.5),
        Bonus("pinned", pinned, 1.0),
        Bonus("joined", joined, 1.5),
    )
    progress = Ladder(
        Closeness("left.tcp", "block.handle_top") + Closeness("right.tcp", "plate.handle_top"),
        (parts_held, 2.5 + Closeness("plate", "on_block")),
        (
            aligned,
            4.0
            + Closeness("back.tcp", "pin.top")
            + Ladder(0.0, (Held("pin", by="back"), 0.5 + Closeness("pin", "through"))),
        ),
        (pinned, 7.0),
        (joined, 7.5 + Fraction(Duration(joined), of=1.0)),
        (success, 9.0),
    )
    setback = Then(aligned, Sustained(~aligned & ~Once(success), seconds=0.5))
