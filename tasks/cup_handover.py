"""Cup Handover: success and reward."""

from taskbuilder import description as d


class CupHandover(d.Description):
    """The ball is in the cup, and the cup has changed hands and stands on the coaster."""

    taken = d.Held("cup", by="left")
    handed_over = d.Then(taken, d.Held("cup", by="right") & ~taken)
    carried = handed_over & d.Held("cup", by="right") & ~taken
    on_coaster = d.On("cup", "coaster") & d.Near("cup", "coaster", within=0.03, axes="xy")
    filled = d.Inside("ball", "cup") & d.Upright("cup", within_deg=10)
    standing = handed_over & on_coaster & filled
    set_down = standing & d.Released("cup") & d.Stationary("cup")

    success = d.Sustained(set_down, seconds=1.0)
    failure = (
        ~d.Near("ball", "cup", within=0.1)
        | ~d.Upright("cup", within_deg=45)
        | d.Below("cup", height=0.38)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"taken": taken, "handed over": handed_over, "on the coaster": standing}
    stages |= {"set down": set_down, "kept there": success}
    reward = (
        d.Distance("reach", "left.tcp", "cup.left_grip", 0.3, agent="left"),
        d.Distance("carry", "cup", "coaster"),
        d.Bonus("handover", carried | set_down, 1.0, agent="right"),
        d.Bonus("set down", set_down, 3.0),
    )

    progress = d.Ladder(
        d.Closeness("left.tcp", "cup.left_grip"),
        (taken, 1.2 + d.Closeness("cup", "meeting") + 0.3 * d.GripperOpening("right")),
        (taken & d.Held("cup", by="right"), 2.8),
        (carried & filled, 3.2 + 2.0 * d.Closeness("cup", "coaster", scale=0.3)),
        (standing, 5.4 + d.GripperOpening("right")),
        (set_down, 6.5 + d.Fraction(d.Duration(set_down), of=1.0)),
        (success, 8.0),
    )
    loose = d.Released("cup") & ~standing
    setback = d.Then(taken, d.Sustained(loose & ~d.Once(success), seconds=0.5))
