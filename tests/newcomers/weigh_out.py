"""WeighOut: success and reward."""

from taskbuilder import description as d


class WeighOut(d.Description):
    """Both weights stand on the spring scale, and press it down into the band."""

    held_red = d.Held("red", by="left")
    held_blue = d.Held("blue", by="right")
    red_on = d.On("red", "scale.platform") & d.Released("red")
    blue_on = d.On("blue", "scale.platform") & d.Released("blue")
    in_band = d.JointPosition("scale.sink", above=0.04, below=0.055)
    weighed = red_on & blue_on & in_band

    success = d.Sustained(weighed, seconds=1.0)
    failure = (
        d.Below("red", height=0.35)
        | d.Below("blue", height=0.35)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {
        "both held": d.Once(held_red) & d.Once(held_blue),
        "red on": d.Once(red_on),
        "weighed": weighed,
        "stays": success,
    }
    reward = (
        d.Distance("reach", "left.tcp", "red", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "blue", 0.5, agent="right"),
        d.Distance("carry", "red", "red_spot", 1.0, agent="left"),
        d.Distance("carry", "blue", "blue_spot", 1.0, agent="right"),
        d.Bonus("on", red_on, 1.0, agent="left"),
        d.Bonus("on", blue_on, 1.0, agent="right"),
        d.Bonus("weighed", weighed, 3.0),
    )
    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "red") + 0.5 * d.Closeness("right.tcp", "blue"),
        (
            held_red | held_blue,
            1.0 + 0.5 * d.Closeness("red", "red_spot") + 0.5 * d.Closeness("right.tcp", "blue"),
        ),
        (held_red & held_blue, 2.0 + d.Closeness("red", "red_spot")),
        (red_on, 3.0 + d.Closeness("blue", "blue_spot")),
        (weighed, 4.5 + d.Fraction(d.Duration(weighed), of=1.0)),
        (success, 6.0),
    )
    setback = d.Then(held_red, d.Sustained(~held_red & ~red_on, seconds=0.5)) | d.Then(
        held_blue, d.Sustained(~held_blue & ~blue_on, seconds=0.5)
    )
