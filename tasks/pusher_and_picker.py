"""Pusher and Picker: success and reward."""

from taskbuilder import description as d


class PusherAndPicker(d.Description):
    """The block is pushed to where the other arm can take it, and ends on the shelf, let go of."""

    at_line_end = d.Near("block", "meeting", within=0.06)
    pushed = d.Once(at_line_end)
    held = d.Held("block", by="picker")
    shelved = d.On("block", "shelf") & d.Released("block") & d.Stationary("block")

    success = d.Sustained(shelved, seconds=1.0)
    failure = d.Below("block", height=0.35) | d.ForceAbove("pusher", "picker", newtons=100)
    stages = {"pushed": pushed, "held": held, "shelved": shelved, "kept there": success}
    reward = (
        d.Distance("push", "block", "meeting", 0.3, agent="pusher"),
        d.Distance("reach", "picker.tcp", "block.middle", 0.3, agent="picker"),
        d.Distance("carry", "block", "shelf"),
        d.Bonus("held", held, 1.0, agent="picker"),
        d.Bonus("shelved", shelved, 4.0),
    )

    progress = d.Ladder(
        0.5 * d.Closeness("pusher.tcp", "block") + d.Closeness("block", "meeting", scale=0.3),
        (pushed, 1.7 + d.Closeness("picker.tcp", "block.middle")),
        (held, 3.0 + d.Closeness("block", "shelf", scale=0.4)),
        (d.On("block", "shelf"), 4.2 + d.GripperOpening("picker")),
        (shelved, 5.5 + d.Fraction(d.Duration(shelved), of=1.0)),
        (success, 7.5),
    )
    setback = d.Then(held, d.Sustained(~held & ~d.On("block", "shelf") & ~success, seconds=0.5))
