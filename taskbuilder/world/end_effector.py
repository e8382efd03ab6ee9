"""What an arm works with: fingers that close, suction, or a tool that takes hold of nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from taskbuilder.geometry import Vec3, add, norm, scale, subtract
from taskbuilder.sim.attachments import Graspable
from taskbuilder.sim.body import Body
from taskbuilder.sim.motors import FREE, Command
from taskbuilder.sim.snapshots import Commanded

SOFT_S = 0.03
"""Time over which forces on what holds an object are averaged, in seconds, so that jolts pass."""


def averaged(before: Vec3, now: Vec3, dt: float) -> Vec3:
    """The running average of a force, over about `SOFT_S`, after one more physics step.

    Args:
        before: The average before this step, in newtons.
        now: The force of this step.
        dt: Length of a physics step in seconds.
    """
    return add(before, scale(subtract(now, before), min(1.0, dt / SOFT_S)))


@dataclass(frozen=True, slots=True)
class Push:
    """Force of a part of an end effector on a body (N), and where it acts, in the world."""

    force: Vec3
    at: Vec3


Pushes = Callable[[], Sequence[Push]]
"""Reads what each of the tips does to a body; no tip does anything if none touches."""


class EndEffector(Commanded, Protocol):
    """The end effector of a robot. As with motors, snapshots keep its last command."""

    @property
    def tips(self) -> tuple[tuple[int, ...], ...]:
        """Link indices of each part that touches what it works on: of a finger, or of a tool."""

    @property
    def joints(self) -> tuple[int, ...]:
        """Indices of the joints that it moves."""

    @property
    def rest(self) -> float | None:
        """Opening with which it pushes and presses; None if it neither opens nor closes."""

    def opening(self) -> float:
        """How far it is open, from 0 (closed) to 1."""

    def told(self) -> float:
        """The last commanded opening."""

    def move(self, opening: float) -> None:
        """Drive it to an opening from 0 (closed) to 1 (open)."""

    def go_home(self) -> None:
        """Open it at once, past all motors."""

    def holds(self, body: Body, link: int | None, pushes: Pushes) -> bool:
        """Whether it holds a body, or a link of it."""

    def forces(self, body: Body, link: int | None, pushes: Pushes) -> tuple[float, ...]:
        """Force of each tip on a body, or on a link of it, in newtons."""

    def moves(self) -> bool:
        """Whether it has not come to rest yet."""

    def closes(self) -> bool:
        """Whether fingers still close around what it holds already, as it is attached to them."""

    def words(self) -> str:
        """Its state, for messages."""

    def drive(self, things: Sequence[Graspable]) -> Iterator[None] | None:
        """What it does before each physics step and after the last, if anything, once a `next`.

        Args:
            things: Everything that has a surface, with the links that are free to move; suction
                also holds on to what is fixed.
        """


class Tool:
    """A plate, a paddle or a tip: it has nothing to open, and takes hold of nothing.

    Args:
        link: Index of the link that pushes.
    """

    rest = None
    joints: tuple[int, ...] = ()

    def __init__(self, link: int) -> None:
        self.tips = ((link,),)
        self.command: Command = FREE

    def issue(self, command: Command) -> None:
        """Nothing."""

    def opening(self) -> float:
        """Closed."""
        return 0.0

    def told(self) -> float:
        """Closed."""
        return 0.0

    def move(self, opening: float) -> None:
        """Nothing."""

    def go_home(self) -> None:
        """Nothing."""

    # Unused arguments are part of the `EndEffector` protocol.
    def holds(self, body: Body, link: int | None, pushes: Pushes) -> bool:  # noqa: ARG002
        """It never does."""
        return False

    def forces(self, body: Body, link: int | None, pushes: Pushes) -> tuple[float, ...]:  # noqa: ARG002
        """Force of the tool on a body, or on a link of it, in newtons."""
        return tuple(norm(push.force) for push in pushes())

    def moves(self) -> bool:
        """It never does."""
        return False

    def closes(self) -> bool:
        """It never does."""
        return False

    def words(self) -> str:
        """It has no state."""
        return "it has no gripper"

    def drive(self, things: Sequence[Graspable]) -> None:
        """Nothing."""
