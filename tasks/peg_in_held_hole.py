"""Peg in Held Hole: success and reward."""

from taskbuilder.description import (
    Above,
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


class PegInHeldHole(Description):
    """The peg is in the block, which the left arm holds up; the right arm has let go of the peg."""

    both = Held("block", by="left") & Held("peg", by="right")
    lifted = Held("block", by="left") & Above("block", "table.top", height=0.06)
    inserted = lifted & Near("peg", "inserted", within=0.012)
    joined = inserted & Released("peg")

    success = Sustained(joined, seconds=1.0)
    failure = (
        Below("peg", height=0.38)
        | Below("block", height=0.38)
        | ForceAbove("left", "right", newtons=100)
    )
    stages = {"both held": both, "inside": inserted, "let go of": joined, "kept so": success}
    reward = (
        Distance("reach", "left.tcp", "block.handle_top", 0.2, agent="left"),
        Distance("reach", "right.tcp", "peg.top", 0.2, agent="right"),
        Distance("join", "peg", "inserted"),
        Bonus("lift", lifted, 0.3, agent="left"),
        Bonus("inside", inserted, 1.0),
        Bonus("joined", joined, 1.5),
    )
    progress = Ladder(
        0.5 * Closeness("left.tcp", "block.handle_top") + 0.5 * Closeness("right.tcp", "peg.top"),
        (both, 1.5 + Fraction(Duration(lifted), of=0.3) + 2.0 * Closeness("peg", "mouth")),
        (inserted, 5.0),
        (joined, 5.5 + Fraction(Duration(joined), of=1.0)),
        (success, 7.0),
    )
    setback = Then(both, Sustained(~both & ~inserted & ~Once(success), seconds=0.5))
