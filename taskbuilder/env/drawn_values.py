"""What a reset draws besides where things are, as numbers of the state for centralised critics.

These are the variation, and the quantities that the task file lists under ``randomize``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from taskbuilder.env.observations import ObservedValue
from taskbuilder.env.options import Options
from taskbuilder.schema.values import rgb
from taskbuilder.world.world import World

if TYPE_CHECKING:
    from taskbuilder.env.episode import Episode


def drawn_values(world: World, options: Options) -> Iterator[ObservedValue]:
    """The drawn values of an environment; none where the options draw none.

    The variation is one number for each of the task's variations: 1 for that of the episode, and 0
    for the others. A colour is its red, green and blue, from 0 to 1. Other quantities are in the
    units of the task file.

    Args:
        world: The world.
        options: The options of the environment.
    """
    count = len(world.task.scenes)
    if options.variation == "random" and count > 1:
        names = tuple(f"variation_{number}" for number in range(count))
        read = partial(_one_hot, count)
        yield ObservedValue("variation", read, (0.0,) * count, (1.0,) * count, names=names)
    if options.draws_quantities:
        for key in world.spec.randomize:
            yield _quantity(key, world)


def _one_hot(count: int, episode: Episode) -> Sequence[float]:
    return tuple(float(number == episode.variation) for number in range(count))


def _quantity(key: str, world: World) -> ObservedValue:
    distribution = world.spec.randomize[key]
    values = (*(distribution.uniform or distribution.choice or ()), world.quantities[key])
    columns = tuple(zip(*map(partial(_numbers, key), values), strict=True))
    return ObservedValue(
        key,
        lambda episode: _numbers(key, episode.quantities[key]),
        tuple(map(min, columns)),
        tuple(map(max, columns)),
        names=tuple(f"{key}.{part}" for part in _COLORS) if _is_color(key) else (key,),
    )


_COLORS = ("red", "green", "blue")


def _is_color(key: str) -> bool:
    return key.endswith(".color")


def _numbers(key: str, value: Any) -> Sequence[float]:
    return rgb(value) if _is_color(key) else (float(value),)
