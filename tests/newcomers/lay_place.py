"""LayPlace: success and reward."""

from taskbuilder import description as d


class LayPlace(d.Description):
    """Dish and cup come to stand on their spots, let go of, at the same moment."""

    dish_held = d.Held("dish", by="left")
    cup_held = d.Held("cup", by="right")
    dish_there = d.Near("dish", "dish_spot", within=0.03) & d.On("dish", "table.top")
    cup_there = d.Near("cup", "cup_spot", within=0.03) & d.On("cup", "table.top")
    dish_set = dish_there & d.Released("dish")
    cup_set = cup_there & d.Released("cup") & d.Upright("cup", within_deg=10)
    together = d.Simultaneous(dish_set, cup_set, within=0.5)
    laid = dish_set & cup_set & together

    success = d.Sustained(laid, seconds=1.0)
    failure = (
        d.Sustained((dish_set & ~cup_set) | (cup_set & ~dish_set), seconds=0.8)
        | d.Below("dish", height=0.38)
        | d.Below("cup", height=0.38)
        | d.ForceAbove("left", "right", newtons=100)
    )
    stages = {
        "both held": dish_held & cup_held,
        "both on the mat": dish_there & cup_there,
        "laid": laid,
        "kept there": success,
    }
    reward = (
        d.Distance("reach", "left.tcp", "dish.near", 0.2, agent="left"),
        d.Distance("reach", "right.tcp", "cup.top", 0.2, agent="right"),
        d.Distance("carry", "dish", "dish_spot", agent="left"),
        d.Distance("carry", "cup", "cup_spot", agent="right"),
        d.Bonus("take", dish_held | laid, 0.2, agent="left"),
        d.Bonus("take", cup_held | laid, 0.2, agent="right"),
        d.Bonus("laid", laid, 3.0),
    )

    progress = d.Ladder(
        0.5 * d.Closeness("left.tcp", "dish.near") + 0.5 * d.Closeness("right.tcp", "cup.top"),
        (
            dish_held & cup_held,
            1.2
            + d.Closeness("dish", "dish_spot", scale=0.3)
            + d.Closeness("cup", "cup_spot", scale=0.3),
        ),
        (
            dish_there & cup_there,
            3.4 + 0.5 * (d.GripperOpening("left") + d.GripperOpening("right")),
        ),
        (laid, 4.6 + d.Fraction(d.Duration(laid), of=1.0)),
        (success, 6.0),
    )
    dropped = (d.Released("dish") & ~dish_there) | (d.Released("cup") & ~cup_there)
    setback = d.Then(dish_held & cup_held, d.Sustained(dropped & ~d.Once(success), seconds=0.5))
