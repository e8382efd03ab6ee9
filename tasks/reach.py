"""Reach: success and reward."""

from taskbuilder.description import (
    Bonus,
    Closeness,
    Contact,
    Description,
    Distance,
    Duration,
    ForceAbove,
    Fraction,
    Ladder,
    Near,
    Once,
    Sustained,
    Then,
)


class Reach(Description):
    """The arm brings its tool to the ball and keeps it there, and touches no pillar."""

    there = Near("arm.tcp", "target", within=0.02)

    success = Sustained(there, seconds=1.0)
    failure = (
        Contact("near_pillar", robot="arm")
        | Contact("far_pillar", robot="arm")
        | ForceAbove("arm", "table", newtons=100)
    )
    stages = {"at the ball": there, "kept there": success}
    reward = (Distance("reach", "arm.tcp", "target"), Bonus("there", there, 1.0))
    progress = Ladder(
        Closeness("arm.tcp", "target", scale=0.3),
        (there, 1.5 + Fraction(Duration(there), of=1.0)),
        (success, 3.0),
    )
    setback = Then(there, Sustained(~there & ~Once(success), seconds=0.5))
