"""Lift Ball: success and reward."""

from taskbuilder import description as d


class LiftBall(d.Description):
    """The ball is wider than a gripper opens, so it is pressed between two arms."""

    pressed = d.Contact("ball", robot="left") & d.Contact("ball", robot="right")
    lifted = pressed & d.Above("ball", "tray", height=0.2)
    on_stand = d.On("ball", "stand") & d.Near("ball", "seat", within=0.03)
    rests = on_stand & d.Released("ball") & d.Stationary("ball")

    success = d.Sustained(rests, seconds=1.0)
    failure = d.Below("ball", height=0.35) | d.ForceAbove("left", "right", newtons=100)
    stages = {"pressed": pressed, "lifted": lifted, "on the stand": on_stand, "let go": success}
    reward = (
        d.Distance("reach", "left.tcp", "ball", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "ball", 0.5, agent="right"),
        d.Distance("carry", "ball", "seat", 2.0),
        d.Bonus("lifted", lifted | on_stand, 0.5),
        d.Bonus("rests", rests, 3.0),
    )

    lift = d.Fraction(d.Height("ball", "tray") - 0.12, of=0.1)
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "ball") + 0.5 * d.Closeness("right.tcp", "ball"),
        (pressed, 1.0 + lift),
        (lifted, 2.1 + d.Closeness("ball", "seat", scale=0.4)),
        (on_stand, 3.5),
        (rests, 4.0 + d.Fraction(d.Duration(rests), of=1.0)),
        (success, 6.0),
    )
    setback = d.Then(lifted, d.Sustained(~lifted & ~on_stand, seconds=0.5))
