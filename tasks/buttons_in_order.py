"""Buttons in Order: success and reward."""

from taskbuilder.description import (
    Bonus,
    Closeness,
    Description,
    Distance,
    Duration,
    Fraction,
    JointPosition,
    Ladder,
    Once,
    Sustained,
    Then,
)


class ButtonsInOrder(Description):
    """The buttons are pressed one after the other and in their order, and then let go of."""

    first, second, third = (
        JointPosition(f"{button}.press", above=0.008) for button in ("first", "second", "third")
    )
    one, two, three = Once(first), Then(first, second), Then(first, second, third)
    done = three & ~first & ~second & ~third

    success = Sustained(done, seconds=1.0)
    failure = (second & ~one) | (third & ~two)
    stages = {
        "first pressed": one,
        "second pressed": two,
        "third pressed": three,
        "all released": success,
    }
    reward = (
        Distance("reach", "left.tcp", "first.cap", 0.2, agent="left"),
        Distance("reach", "back.tcp", "second.cap", 0.2, agent="back"),
        Distance("reach", "right.tcp", "third.cap", 0.2, agent="right"),
        Bonus("first", one, 0.5),
        Bonus("second", two, 0.5),
        Bonus("third", three, 0.5),
        Bonus("done", done, 1.0),
    )
    progress = Ladder(
        Closeness("left.tcp", "first.cap"),
        (one, 1.5 + Closeness("back.tcp", "second.cap")),
        (two, 3.0 + Closeness("right.tcp", "third.cap")),
        (three, 4.5),
        (done, 5.0 + Fraction(Duration(done), of=1.0)),
        (success, 6.5),
    )
    setback = Sustained(three & ~done & ~Once(success), seconds=2.0)
