"""Forces between pairs of bodies, metered at every physics step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from taskbuilder.errors import UsageError
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.contacts import normal_force
from taskbuilder.world.touch import Touch

WINDOW_HZ = 60
"""Forces are averaged over the physics steps that fit in 1/60 s: shorter peaks of a rigid contact
say more of the solver than of the blow."""

Pair = tuple[str, str]


@dataclass(frozen=True, slots=True)
class Reading:
    """What is known of the force between two bodies.

    Attributes:
        window: Force in newtons at each of the last physics steps, the latest last.
        peak: Largest mean over the window in the last control step.
    """

    window: tuple[float, ...]
    peak: float = 0.0


@dataclass(frozen=True, slots=True)
class _Watched:
    """Two bodies, and the link of each where only that is meant."""

    one: Body
    other: Body
    one_link: int | None
    other_link: int | None


class ForceMeter:
    """The force with which watched pairs of bodies press on each other.

    Force is the sum of the normal forces between the pair, averaged over `WINDOW_HZ`; the average
    runs on from one control step into the next. Of each control step the peak is kept.

    Args:
        client: The physics.
        touch: Finds bodies by name.
        pairs: Names of the bodies to watch, in either order.

    Raises:
        UnknownNameError: There is no such object, part or robot.
    """

    def __init__(self, client: Client, touch: Touch, pairs: Iterable[Pair] = ()) -> None:
        self._client = client
        self._watched: dict[Pair, _Watched] = {}
        for first, second in map(_ordered, pairs):
            (one, one_link), (other, other_link) = touch.body(first), touch.body(second)
            self._watched[first, second] = _Watched(one, other, one_link, other_link)
        self._steps = max(1, client.physics_hz // WINDOW_HZ)
        self.readings: Mapping[Pair, Reading] = {}
        self.clear()

    def __bool__(self) -> bool:
        """Whether anything is watched."""
        return bool(self._watched)

    def clear(self) -> None:
        """Forget all forces, as at the beginning of an episode."""
        self.restore({})

    def restore(self, readings: Mapping[Pair, Reading]) -> None:
        """Go on from what was known at another moment; pairs watched since begin at zero."""
        nothing = Reading((0.0,) * self._steps)
        self.readings = {pair: readings.get(pair, nothing) for pair in self._watched}

    def begin(self) -> None:
        """A control step begins."""
        self.readings = {pair: Reading(known.window) for pair, known in self.readings.items()}

    def read(self) -> None:
        """A physics step has passed."""
        readings = {}
        for pair, watched in self._watched.items():
            known = self.readings[pair]
            force = normal_force(
                self._client,
                watched.one,
                watched.other,
                link_a=watched.one_link,
                link_b=watched.other_link,
            )
            window = (*known.window[1:], force)
            readings[pair] = Reading(window, max(known.peak, sum(window) / self._steps))
        self.readings = readings

    def force(self, first: str, second: str) -> float:
        """Peak force between two bodies in the last control step, in newtons.

        Raises:
            UsageError: The pair is not watched.
        """
        found = self.readings.get(_ordered((first, second)))
        if found is None:
            raise UsageError(
                f'the force between "{first}" and "{second}" is not watched; ask for it by '
                f'ContactForce("{first}", "{second}"), or name the pair in force_pairs of a '
                "condition or measure of your own"
            )
        return found.peak


def _ordered(pair: Pair) -> Pair:
    """The one order that stands for both."""
    first, second = pair
    return (first, second) if first <= second else (second, first)
