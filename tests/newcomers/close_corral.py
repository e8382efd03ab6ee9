"""Close Corral: success and reward."""

from taskbuilder import description as d


class CloseCorral(d.Description):
    """The two halves of the fence stand around the sheep, closed and let go of."""

    left_held = d.Held("left_fence", by="left")
    right_held = d.Held("right_fence", by="right")
    left_home = d.On("left_fence", "table") & d.Near("left_fence", "left_place", within=0.03)
    right_home = d.On("right_fence", "table") & d.Near("right_fence", "right_place", within=0.03)
    # The ends of the halves meet: a gap of 1.5 cm more than planned is still too narrow for the sheep.
    joined = d.Near("left_fence.north", "right_fence.north", within=0.115) & d.Near(
        "left_fence.south", "right_fence.south", within=0.115
    )
    penned = d.Near("sheep", "meadow", within=0.07, axes="xy")
    closed = (
        left_home
        & right_home
        & joined
        & penned
        & d.Released("left_fence")
        & d.Released("right_fence")
    )

    success = d.Sustained(closed, seconds=1.0)
    failure = (
        d.Below("left_fence", height=0.38)
        | d.Below("right_fence", height=0.38)
        | d.Moved("sheep", by=0.12)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {
        "both held": d.Once(left_held) & d.Once(right_held),
        "closed": closed,
        "kept closed": success,
    }
    reward = (
        d.Distance("reach", "left.tcp", "left_fence.grip", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "right_fence.grip", 0.5, agent="right"),
        d.Distance("left half", "left_fence", "left_place"),
        d.Distance("right half", "right_fence", "right_place"),
        d.Bonus("left placed", left_home, 0.5, agent="left"),
        d.Bonus("right placed", right_home, 0.5, agent="right"),
        d.Bonus("closed", closed, 2.0),
    )

    left_way = d.Ladder(
        0.5 * d.Closeness("left.tcp", "left_fence.grip"),
        (d.Once(left_held), 0.6 + d.Closeness("left_fence", "left_place")),
        (left_home, 1.8),
    )
    right_way = d.Ladder(
        0.5 * d.Closeness("right.tcp", "right_fence.grip"),
        (d.Once(right_held), 0.6 + d.Closeness("right_fence", "right_place")),
        (right_home, 1.8),
    )
    progress = d.Ladder(
        left_way + right_way,
        (closed, 4.0 + d.Fraction(d.Duration(closed), of=1.0)),
        (success, 5.5),
    )
    setback = d.Then(left_held, d.Sustained(~left_held & ~left_home, seconds=0.3)) | d.Then(
        right_held, d.Sustained(~right_held & ~right_home, seconds=0.3)
    )
