"""Joints that nobody drives, but that have a spring, damping or a lock."""

from __future__ import annotations

from collections.abc import Iterator

from taskbuilder.sim.body import Body
from taskbuilder.sim.bullet import p
from taskbuilder.sim.motors import FREE, Command

LOCK_FORCE = 1e4
"""What a lock holds against, N or N m: some ten times what an arm can exert."""

LOCK_GAIN = 0.2
"""Share of a locked joint's position error that is removed in one physics step."""


class PassiveJoint:
    """A joint of an object: free, with what resists and pulls it, or locked where it is.

    Friction and damping are the largest force of a motor that brakes, so they stop a joint and
    never turn it round, however large they are. The spring pushes as Bullet applies forces, once
    a physics step: it is stable while its stiffness is below four times the moved mass times the
    square of the physics steps a second.

    It begins free. As with `Motors`, the last command is kept for snapshots.

    Args:
        body: The body.
        index: Index of the joint.
        friction: What it takes to move it, N or N m.
        damping: What grows with its speed, N s/m or N m s/rad.
        stiffness: Of its spring, N/m or N m/rad; 0 for none.
        rest: Where the spring does not pull, m or rad.

    Attributes:
        command: "free", or "position" with the position at which it is locked.
    """

    def __init__(
        self,
        body: Body,
        index: int,
        *,
        friction: float,
        damping: float = 0.0,
        stiffness: float = 0.0,
        rest: float = 0.0,
    ) -> None:
        self.command: Command = FREE
        self._body, self._index = body, index
        self._friction, self._damping = friction, damping
        self._stiffness, self._rest = stiffness, rest
        self._control = body.client.bullet.setJointMotorControl2
        self.issue(FREE)

    @property
    def acts(self) -> bool:
        """Whether its force changes from one physics step to the next."""
        return bool(self._damping or self._stiffness)

    @property
    def locked(self) -> bool:
        """Whether it is held where it is."""
        return self.command.mode == "position"

    def lock(self) -> None:
        """Hold it where it is now, if it is not held already."""
        if not self.locked:
            positions, _ = self._body.joint_states((self._index,))
            self.issue(Command("position", positions))

    def unlock(self) -> None:
        """Let it move."""
        if self.locked:
            self.issue(FREE)

    def issue(self, command: Command) -> None:
        """Lock it at a position, or free it, perhaps by a command remembered from earlier."""
        if command.mode == "position":
            self._control(
                self._body.id,
                self._index,
                p.POSITION_CONTROL,
                targetPosition=command.values[0],
                force=LOCK_FORCE,
                positionGain=LOCK_GAIN,
            )
        else:
            self._body.set_joint_friction(self._index, self._friction)
        self.command = command

    def act(self) -> Iterator[None]:
        """Apply the spring and the damping of the next physics step, once a `next`."""
        while True:
            if not self.locked:
                (position,), (speed,) = self._body.joint_states((self._index,))
                if self._damping:
                    resistance = self._friction + self._damping * abs(speed)
                    self._body.set_joint_friction(self._index, resistance)
                if self._stiffness:
                    pull = self._stiffness * (self._rest - position)
                    self._control(self._body.id, self._index, p.TORQUE_CONTROL, force=pull)
            yield
