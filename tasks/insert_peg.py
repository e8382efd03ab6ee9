"""Insert Peg: success and reward."""

from taskbuilder.description import (
    Below,
    Bonus,
    Closeness,
    Description,
    Distance,
    Duration,
    Fraction,
    Held,
    Ladder,
    Near,
    Once,
    Released,
    Stationary,
    Sustained,
    Then,
)


class InsertPeg(Description):
    """The peg stands in the hole of the block, let go of and at rest."""

    held = Held("peg", by="arm")
    over = Near("peg", "mouth", within=0.02)
    inside = Near("peg", "inserted", within=0.01)
    standing = inside & Released("peg") & Stationary("peg")

    success = Sustained(standing, seconds=1.0)
    failure = Below("peg", height=0.38) | Below("block", height=0.38)
    stages = {"held": held, "over the hole": held & over, "inside": inside, "stays": success}
    reward = (
        Distance("reach", "arm.tcp", "peg.top", 0.2),
        Distance("carry", "peg", "inserted"),
        Bonus("inside", inside, 0.5),
        Bonus("standing", standing, 1.0),
    )
    progress = Ladder(
        Closeness("arm.tcp", "peg.top"),
        (held, 1.5 + 1.5 * Closeness("peg", "mouth")),
        (held & over, 3.2 + 0.8 * Closeness("peg", "inserted", scale=0.05)),
        (inside, 4.5),
        (standing, 5.0 + Fraction(Duration(standing), of=1.0)),
        (success, 6.5),
    )
    setback = Then(held, Sustained(~held & ~inside & ~Once(success), seconds=0.5))
