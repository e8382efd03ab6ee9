"""Suction: a cup that holds on to a surface within its reach, and lets go beyond its force."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from taskbuilder.geometry import ORIGIN, Pose, Vec3, dot, norm, scale, subtract
from taskbuilder.schema.robot import SuctionSpec, Tcp
from taskbuilder.sim.attachments import Attachment, Graspable, Holder, Surface
from taskbuilder.sim.body import Body
from taskbuilder.world.end_effector import Pushes, averaged

FARTHEST_M = 0.1
"""Distance up to which a gap between a cup and a surface is measured, in metres."""


@dataclass(frozen=True, slots=True)
class SuctionState:
    """The state of a cup, which snapshots keep.

    Attributes:
        on: Whether it sucks.
        held: What it holds, or None.
        force: Force in newtons that this exerts on it, averaged over about `SOFT_S`,
            in the world.
    """

    on: bool = False
    held: Attachment | None = None
    force: Vec3 = ORIGIN


class Suction:
    """A suction cup. It is an `EndEffector`: closed while it sucks, and open while it does not.

    Args:
        body: The robot.
        spec: Its suction.
        tcp: Where the mouth of the cup is; its z axis points out of it.

    Attributes:
        command: Its state.
    """

    rest = 1.0  # it would stick to what it pushes
    joints: tuple[int, ...] = ()

    def __init__(self, body: Body, spec: SuctionSpec, tcp: Tcp) -> None:
        self.tips = ((body.links[spec.cup],),)
        self.command = SuctionState()
        self._spec = spec
        self._dt = body.client.dt
        self._holder = Holder(body, body.links[tcp.link], tcp.pose, spec.force)

    def issue(self, command: SuctionState) -> None:
        """Take on a state, perhaps one remembered from earlier."""
        self._holder.hold(command.held)
        self.command = command

    def opening(self) -> float:
        """0 while it sucks, else 1."""
        return 0.0 if self.command.on else 1.0

    def told(self) -> float:
        """0 while it sucks, else 1."""
        return self.opening()

    def move(self, opening: float) -> None:
        """Suck if told to close; else let go."""
        if opening >= 0.5:
            self.issue(SuctionState())
        elif not self.command.on:
            self.command = SuctionState(on=True)

    def go_home(self) -> None:
        """Let go."""
        self.issue(SuctionState())

    # Unused arguments are part of the `EndEffector` protocol.
    def holds(self, body: Body, link: int | None, pushes: Pushes) -> bool:  # noqa: ARG002
        """Whether the cup holds a body, or a link of it."""
        held = self.command.held
        return held is not None and held.body == body.id and link in (None, held.link)

    def forces(self, body: Body, link: int | None, pushes: Pushes) -> tuple[float, ...]:
        """Force in newtons with which a body, or a link of it, pulls at the cup."""
        return (self.pull() if self.holds(body, link, pushes) else 0.0,)

    def moves(self) -> bool:
        """It never does."""
        return False

    def closes(self) -> bool:
        """It never does."""
        return False

    def words(self) -> str:
        """Its state, for messages."""
        if not self.command.on:
            return "its suction is off"
        near = f"no surface is within {self._spec.reach * 1000:g} mm of its cup"
        return "its suction is on" if self.command.held else f"its suction is on, and {near}"

    def drive(self, things: Sequence[Graspable]) -> Iterator[None]:
        """Take a surface within reach; then let go as soon as it pulls too hard.

        Args:
            things: Everything that has a surface, what is fixed included.
        """
        if self.command.on and self.command.held is None:
            bodies = [body for body, _ in things]
            surface = self._holder.surface(bodies, self._spec.reach)
            if surface is not None:
                self.issue(SuctionState(on=True, held=self._holder.attach(surface)))
        while True:
            yield
            if self.command.held is not None:
                self._feel()

    def _feel(self) -> None:
        """Average the force of the last physics step, and let go if it pulls too hard."""
        force = averaged(self.command.force, self._holder.force(), self._dt)
        self.command = replace(self.command, force=force)
        if self.pull() > self._spec.force:
            self.issue(SuctionState(on=True))

    def pull(self) -> float:
        """Force in newtons that pulls the cup off, along its axis and sideways.

        What presses on it does not pull it off, and bears as much force sideways by friction.
        """
        force, axis = self.command.force, self._holder.pose.axis(2)
        along = dot(force, axis)
        sideways = norm(subtract(force, scale(axis, along))) - max(-along, 0.0)
        return math.hypot(max(along, 0.0), max(sideways, 0.0))

    @property
    def reach(self) -> float:
        """Distance in metres at which it takes hold of a surface."""
        return self._spec.reach

    def gap(self, body: Body, tool: Pose) -> float:
        """Distance in metres to the surface of a body, with the tcp at a pose in the world.

        It is negative inside the body, and infinite beyond `FARTHEST_M`.
        """
        found: Surface | None = self._holder.surface_at(tool, [body], FARTHEST_M)
        return math.inf if found is None else found.gap
