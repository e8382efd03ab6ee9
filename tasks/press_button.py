"""Press Button: success and reward."""

from taskbuilder import description as d


class PressButton(d.Description):
    """The button on the right pad is held down, and the other one was not touched."""

    down = d.JointPosition("button.press", above=0.008)
    wrong = d.JointPosition("other.press", above=0.008)

    success = d.Sustained(down, seconds=1.0)
    failure = wrong | d.ForceAbove("arm", "table", newtons=100)
    stages = {"pressed": down, "held down": success}
    reward = (d.Distance("reach", "arm.tcp", "button.cap"), d.Bonus("down", down, 1.0))

    progress = d.Ladder(
        d.Closeness("arm.tcp", "button.cap", scale=0.3),
        (down, 1.5 + d.Fraction(d.Duration(down), of=1.0)),
        (success, 3.0),
    )
    setback = d.Then(down, d.Sustained(~down & ~d.Once(success), seconds=0.5))
