"""Forces between pairs of bodies, metered at every physics step."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from taskbuilder.errors import UsageError
from taskbuilder.geometry import total
from taskbuilder.sim.contacts import normal_force_reader
from taskbuilder.world.touch import Touch

WINDOW_HZ = 60
"""Forces are averaged over the physics steps that fit in 1/60 s: shorter peaks of a rigid contact
say more of the solver than of the blow."""

Pair = tuple[str, str]


@dataclass(frozen=True, slots=True)
class ForceReading:
    """What is known of the force between two bodies.

    Attributes:
        window: Force in newtons at each of the last physics steps, the latest last.
        peak: Largest mean over the window in the last control step.
    """

    window: tuple[float, ...]
    peak: float = 0.0


class _Gauge:
    """Follows the force between two bodies."""

    def __init__(self, read: Callable[[], float], steps: int) -> None:
        self._read = read
        self._nothing = ForceReading((0.0,) * steps)
        self.known = self._nothing

    def begin(self) -> None:
        """A control step begins."""
        if self.known is not self._nothing:
            window = self.known.window
            self.known = ForceReading(window) if any(window) else self._nothing

    def read(self) -> None:
        """A physics step has passed."""
        force = self._read()
        if not force and self.known is self._nothing:
            return  # as nearly always
        window = (*self.known.window[1:], force)
        self.known = ForceReading(window, max(self.known.peak, total(window) / len(window)))

    def restore(self, known: ForceReading | None) -> None:
        """Go on from a reading, or from nothing."""
        self.known = known or self._nothing


class ForceMeter:
    """The force with which watched pairs of bodies press on each other.

    Force is the sum of the normal forces between the pair, averaged over `WINDOW_HZ`; the average
    runs on from one control step into the next. Of each control step the peak is kept.

    Args:
        physics_hz: Physics steps a second.
        touch: Finds bodies by name.
        pairs: Names of the bodies to watch, in either order.

    Raises:
        UnknownNameError: There is no such object, part or robot.
    """

    def __init__(self, physics_hz: int, touch: Touch, pairs: Iterable[Pair] = ()) -> None:
        steps = max(1, physics_hz // WINDOW_HZ)
        self._gauges: dict[Pair, _Gauge] = {}
        for first, second in map(_ordered, pairs):
            (one, one_link), (other, other_link) = touch.body(first), touch.body(second)
            reader = normal_force_reader(one, other, link_a=one_link, link_b=other_link)
            self._gauges[first, second] = _Gauge(reader, steps)

    def __bool__(self) -> bool:
        """Whether anything is watched."""
        return bool(self._gauges)

    @property
    def readings(self) -> Mapping[Pair, ForceReading]:
        """What is known now, to `restore` later."""
        return {pair: gauge.known for pair, gauge in self._gauges.items()}

    def clear(self) -> None:
        """Forget all forces, as at the beginning of an episode."""
        self.restore({})

    def restore(self, readings: Mapping[Pair, ForceReading]) -> None:
        """Go on from what was known at another moment; pairs watched since begin at zero."""
        for pair, gauge in self._gauges.items():
            gauge.restore(readings.get(pair))

    def begin(self) -> None:
        """A control step begins."""
        for gauge in self._gauges.values():
            gauge.begin()

    def read(self) -> None:
        """A physics step has passed."""
        for gauge in self._gauges.values():
            gauge.read()

    def force(self, first: str, second: str) -> float:
        """Peak force between two bodies in the last control step, in newtons.

        Raises:
            UsageError: The pair is not watched.
        """
        gauge = self._gauges.get(_ordered((first, second)))
        if gauge is None:
            raise UsageError(
                f'the force between "{first}" and "{second}" is not watched; ask for it by '
                f'ContactForce("{first}", "{second}"), or name the pair in force_pairs of a '
                "condition or measure of your own"
            )
        return gauge.known.peak


def _ordered(pair: Pair) -> Pair:
    """The one order that stands for both."""
    first, second = pair
    return (first, second) if first <= second else (second, first)
