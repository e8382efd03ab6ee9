"""Apple in Basket: success and reward."""

from taskbuilder import description as d


class AppleInBasket(d.Description):
    """Words say which apple goes into the basket, and on which mat the basket stands."""

    apple_taken = d.Held("apple", by="left")
    basket_taken = d.Held("basket", by="right")
    set_down = d.On("basket", "mat") & d.Near("basket", "on_mat", within=0.05)
    laid = set_down & d.Upright("basket", within_deg=15)
    filled = laid & d.Near("apple", "inside", within=0.1) & d.Released("apple")
    # A basket at rest rattles: for a step, it turns by up to 15°/s, and stays where it is.
    still = d.Stationary("basket", speed=0.02, turn_deg=45)
    served = filled & d.Released("basket") & still

    success = d.Sustained(served, seconds=1.0)
    others = ("second", "third")
    failure = (
        d.On("basket", "spare")
        | d.Any(*(d.Near(other, "inside", within=0.1) for other in others))
        | d.Any(*(d.Below(one, height=0.35) for one in ("apple", "basket", *others)))
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {"apple taken": apple_taken, "basket on the mat": laid, "apple in the basket": filled}
    stages["kept there"] = success
    reward = (
        d.Distance("reach", "left.tcp", "apple", 0.5, agent="left"),
        d.Distance("reach", "right.tcp", "basket.grip", 0.5, agent="right"),
        d.Distance("carry", "basket", "on_mat", agent="right"),
        d.Distance("carry", "apple", "in_basket", agent="left"),
        d.Bonus("taken", apple_taken | filled, 0.3, agent="left"),
        d.Bonus("laid", laid, 0.5, agent="right"),
        d.Bonus("served", served, 3.0),
    )

    near = 0.5 * d.Closeness("left.tcp", "apple.top") + 0.5 * d.Closeness(
        "right.tcp", "basket.grip"
    )
    progress = d.Ladder(
        near,
        (basket_taken, 1.2 + d.Closeness("basket", "on_mat", scale=0.4)),
        (laid, 2.4 + 0.5 * d.Closeness("left.tcp", "apple.top")),
        (laid & apple_taken, 3.1 + 1.5 * d.Closeness("apple", "in_basket", scale=0.4)),
        (filled, 4.7),
        (served, 5.0 + d.Fraction(d.Duration(served), of=1.0)),
        (success, 6.3),
    )
    setback = d.Then(
        apple_taken, d.Sustained(~apple_taken & ~filled & ~d.Once(success), seconds=0.5)
    )
