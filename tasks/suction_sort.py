"""Suction Sort: success and reward."""

from taskbuilder import description as d


class SuctionSort(d.Description):
    """The plate lies flat on the pad and the block in the tray, and nobody touches them."""

    plate_held, block_held = d.Held("plate", by="cup"), d.Held("block", by="hand")
    flat = (
        d.On("plate", "pad") & d.Near("plate", "pad", within=0.04) & d.Level("plate", within_deg=5)
    )
    plate_sorted = flat & d.Released("plate") & d.Stationary("plate")
    in_tray = d.Inside("block", "tray") & d.On("block", "tray")
    block_sorted = in_tray & d.Released("block") & d.Stationary("block")
    both = plate_sorted & block_sorted

    success = d.Sustained(both, seconds=1.0)
    failure = (
        d.Below("plate", height=0.35)
        | d.Below("block", height=0.35)
        | d.ForceAbove("cup", "hand", newtons=100)
    )
    stages = {"plate held": plate_held, "block held": block_held, "both sorted": both}
    stages["kept there"] = success
    reward = (
        d.Distance("reach", "cup.tcp", "plate.top", 0.3, agent="cup"),
        d.Distance("reach", "hand.tcp", "block.middle", 0.3, agent="hand"),
        d.Distance("carry", "plate", "pad", agent="cup"),
        d.Distance("carry", "block", "tray", agent="hand"),
        d.Bonus("plate", plate_sorted, 2.0),
        d.Bonus("block", block_sorted, 2.0),
    )

    plates = d.Ladder(
        d.Closeness("cup.tcp", "plate.top"),
        (plate_held, 1.2 + d.Closeness("plate", "pad", scale=0.4)),
        (flat, 2.4 + 0.2 * d.GripperOpening("cup")),
        (plate_sorted, 3.0),
    )
    blocks = d.Ladder(
        d.Closeness("hand.tcp", "block.middle"),
        (block_held, 1.2 + d.Closeness("block", "tray", scale=0.4)),
        (in_tray, 2.4 + 0.2 * d.GripperOpening("hand")),
        (block_sorted, 3.0),
    )
    progress = d.Ladder(
        plates + blocks,
        (both, 6.5 + d.Fraction(d.Duration(both), of=1.0)),
        (success, 8.0),
    )
    setback = d.Then(plate_held, d.Sustained(~plate_held & ~flat & ~success, seconds=0.5))
