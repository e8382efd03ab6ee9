"""Fingers that attach what they close around, as grippers do in RLBench.

Fingers that went on pressing on an object that is fixed to their own gripper would slowly push it
out of its place, wherever they touch it on one side only. So they stop where they touch it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from taskbuilder.geometry import ORIGIN, Vec3, norm
from taskbuilder.schema.grasping import Grasping
from taskbuilder.schema.robot import Tcp
from taskbuilder.sim.attachments import Attachment, Graspable, Holder
from taskbuilder.sim.body import Body
from taskbuilder.sim.contacts import links_touch
from taskbuilder.sim.motors import FREE, Command
from taskbuilder.world.end_effector import Pushes, averaged
from taskbuilder.world.fingers import Fingers

HALF = 0.5
"""Commanded opening below which the gripper is closed, and holds what it has attached."""

TOUCH_M = 1e-3
"""Gap between a finger and an object at which the finger stops."""

ARRIVED = 0.01
"""Difference between opening and commanded opening at which fingers have arrived."""


@dataclass(frozen=True, slots=True)
class AttachingState:
    """The state of a gripper that attaches, which snapshots keep.

    Attributes:
        fingers: The last command to the motors of its fingers.
        told: The last commanded opening.
        phase: ``closing`` from the command to close until the next physics step, in which it takes
            what is near. Then ``closed``, and ``stopped`` when its fingers have touched what it
            took or have nothing left to close, until it is told to open.
        held: What it holds, or None.
        force: Force in newtons that this exerts on it, averaged as for a suction cup, in the world.
            It is only followed if the gripper has a limit.
    """

    fingers: Command = FREE
    told: float = 1.0
    phase: Literal["open", "closing", "closed", "stopped"] = "open"
    held: Attachment | None = None
    force: Vec3 = ORIGIN


class AttachingFingers:
    """Fingers that attach an object when they close, and let go of it when they open.

    They are an `EndEffector`. Fingers that have attached nothing move as without attaching.

    Args:
        body: The robot.
        fingers: Its fingers.
        grasping: What they attach.
        tcp: The point from which distances to objects are measured.
    """

    def __init__(self, body: Body, fingers: Fingers, grasping: Grasping, tcp: Tcp) -> None:
        self.tips, self.joints, self.rest = fingers.tips, fingers.joints, fingers.rest
        self._body, self._fingers, self._grasping = body, fingers, grasping
        self._holder = Holder(body, body.links[tcp.link], tcp.pose, grasping.force)
        self._state = AttachingState()

    @property
    def command(self) -> AttachingState:
        """Its state."""
        return replace(self._state, fingers=self._fingers.command)

    def issue(self, command: AttachingState) -> None:
        """Take on a state, perhaps one remembered from earlier."""
        self._holder.hold(command.held)
        self._fingers.issue(command.fingers)
        self._state = command

    def opening(self) -> float:
        """How far it is open, from 0 (closed) to 1, averaged over its joints."""
        return self._fingers.opening()

    def told(self) -> float:
        """The last commanded opening, however far the fingers have come."""
        return self._state.told

    def move(self, opening: float) -> None:
        """Drive it to an opening from 0 (closed) to 1 (open); let go if it passes half way."""
        state = self._state
        if opening >= HALF:
            self._holder.hold(None)
            self._state = AttachingState(told=opening)
        elif state.phase == "open":
            self._state = replace(state, told=opening, phase="closing")
        elif opening != state.told:
            self._state = replace(state, told=opening, phase="closed")
        else:
            return  # fingers that have stopped stay
        self._fingers.move(opening)

    def go_home(self) -> None:
        """Let go, open it at once, past all motors, and hold it there."""
        self._holder.hold(None)
        self._state = AttachingState()
        self._fingers.go_home()

    def holds(self, body: Body, link: int | None, pushes: Pushes) -> bool:
        """Whether a body, or a link of it, is attached, or held by friction all the same."""
        held = self._state.held
        if held is not None and held.body == body.id and link in (None, held.link):
            return True
        return self._fingers.holds(body, link, pushes)

    def forces(self, body: Body, link: int | None, pushes: Pushes) -> tuple[float, ...]:
        """Force of each finger on a body, or on a link of it, in newtons."""
        return self._fingers.forces(body, link, pushes)

    def moves(self) -> bool:
        """Whether its joints have not stopped yet."""
        return self._fingers.moves()

    def closes(self) -> bool:
        """Whether its fingers still come up to what is attached."""
        around = self._state.phase == "closed" and self._state.held is not None
        return around and self.moves()

    def words(self) -> str:
        """How far it is open, and whether it attached something, for messages."""
        words = self._fingers.words()
        if self._state.phase == "open":
            return words
        if self._state.held is not None:
            return f"{words}, and has an object attached"
        near = f"{self._grasping.distance * 1000:g} mm of its tool point when it closed"
        return f"{words}, and no object was within {near}"

    def drive(self, things: Sequence[Graspable]) -> Iterator[None] | None:
        """Take the nearest object if told to close, and stop the fingers where they touch it.

        Args:
            things: What can be held.
        """
        if self._state.phase == "closing":
            surface = self._holder.around(things, self._grasping.distance)
            held = self._holder.attach(surface) if surface is not None else None
            self._holder.hold(held)
            self._state = replace(self._state, phase="closed", held=held)
        if self._state.held is None:
            return None
        settled = self._state.phase == "stopped" and self._grasping.force is None
        return None if settled else self._follow()

    def _follow(self) -> Iterator[None]:
        """Before each physics step, see where the fingers are and what it bears."""
        while True:
            held = self._state.held
            if held is not None and self._state.phase == "closed":
                self._see_fingers(held)
            yield
            if self._state.held is not None and self._grasping.force is not None:
                self._feel(self._grasping.force)

    def _see_fingers(self, held: Attachment) -> None:
        """Stop the fingers if they touch what is held."""
        left = self._fingers.opening() - self._state.told
        if abs(left) < ARRIVED:
            self._state = replace(self._state, phase="stopped")
        elif left > 0.0 and links_touch(self._body, self.joints, held.body, within=TOUCH_M):
            self._fingers.stop()
            self._state = replace(self._state, phase="stopped")

    def _feel(self, most: float) -> None:
        """Average the force of the last physics step, and let go if it is above a limit."""
        force = averaged(self._state.force, self._holder.force(), self._body.client.dt)
        self._state = replace(self._state, force=force)
        if norm(force) > most:
            self._holder.hold(None)
            self._state = AttachingState(told=self._state.told, phase="closed")
            self._fingers.move(self._state.told)
