"""Stack Three: success and reward."""

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
    On,
    Once,
    Released,
    Stationary,
    Sustained,
    Then,
)


class StackThree(Description):
    """The middle cube stands on the bottom one and the top one on both, let go of and at rest."""

    two = On("middle", "bottom") & Released("middle")
    tower = two & On("top", "middle") & Released("top") & Stationary("top")

    success = Sustained(tower, seconds=1.0)
    failure = (
        Below("bottom", height=0.38) | Below("middle", height=0.38) | Below("top", height=0.38)
    )
    stages = {"two stacked": two, "three stacked": tower, "standing": success}
    reward = (
        Distance("middle", "middle", "on_bottom"),
        Distance("top", "top", "on_middle"),
        Bonus("two", two, 1.0),
        Bonus("tower", tower, 2.0),
    )
    progress = Ladder(
        Closeness("arm.tcp", "middle.grip")
        + Ladder(0.0, (Held("middle"), 0.5))
        + Closeness("middle", "on_bottom"),
        (
            two,
            3.0
            + Closeness("arm.tcp", "top.grip")
            + Ladder(0.0, (Held("top"), 0.5))
            + Closeness("top", "on_middle"),
        ),
        (tower, 6.0 + Fraction(Duration(tower), of=1.0)),
        (success, 7.5),
    )
    setback = Then(two, Sustained(~two & ~Once(success), seconds=0.3))
