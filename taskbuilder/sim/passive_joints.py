"""Joints that nobody drives, but that have a spring, damping or a lock."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from taskbuilder.sim.body import BASE, AddedInertia, Body, JointInfo
from taskbuilder.sim.bullet import p
from taskbuilder.sim.motors import FREE, Command

LOCK_FORCE = 1e4
"""What a lock holds against, N or N m: some ten times what an arm can exert."""

LOCK_GAIN = 0.2
"""Share of a locked joint's position error that is removed in one physics step."""

HELD = AddedInertia(mass=100.0, moment=10.0)
"""What is added to a locked link whose joint is on the ground: many times what pushes it."""

LENT = 0.9
"""Share of a link's smallest moment of inertia that the locked joints on it may take over."""


class PassiveJoint:
    """A joint of an object: free, with what resists and pulls it, or locked where it is.

    Friction and damping are the largest force of a motor that brakes, so they stop a joint and
    never turn it round, however large they are. The spring pushes as Bullet applies forces, once
    a physics step: it is stable while its stiffness is below four times the moved mass times the
    square of the physics steps a second.

    A lock is a motor. The engine solves motors and contacts in turns, and stops before a light
    link between a motor and an arm is at rest: an arm of 20 kg turned a wheel of 0.2 kg by 24°.
    Hence a locked link gets inertia against which a contact
    can do nothing, where that changes nothing else: on a joint that is fixed to the ground the
    link is at rest, whatever its inertia. On a joint of something that moves, a locked link takes
    over inertia from the link that it is on, which leaves that of both together as it was, and
    after each physics step `hold` puts the joint back where it was locked.

    It begins free. As with `Motors`, the last command is kept for snapshots.

    Args:
        body: The body.
        index: Index of the joint.
        grounded: Whether the base of the body is fixed.
        friction: What it takes to move it, N or N m.
        damping: What grows with its speed, N s/m or N m s/rad.
        stiffness: Of its spring, N/m or N m/rad; 0 for none.
        rest: Where the spring does not pull, m or rad.

    Attributes:
        command: "free", or "position" with the position at which it is locked.
        drifts: Whether it must be put back after each physics step while it is locked; see `hold`.
    """

    def __init__(
        self,
        body: Body,
        index: int,
        *,
        grounded: bool,
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
        joint = _joint(body, index)
        self.drifts = not (grounded and _on_base(body, joint))
        self._when_locked = _lent(body, joint) if self.drifts else {joint.child: HELD}
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
            if not self.drifts:  # with the inertia of a locked link it would go on for long
                self._body.reset_joints((self._index,), positions)
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
            self._body.add_inertia(self._index, self._when_locked)
        else:
            self._body.add_inertia(self._index, {})
            self._body.set_joint_friction(self._index, self._friction)
        self.command = command

    def hold(self) -> None:
        """Put it back where it was locked, at rest; called after each physics step."""
        if self.locked:
            self._body.reset_joints((self._index,), self.command.values)

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


def _joint(body: Body, index: int) -> JointInfo:
    return next(joint for joint in body.joints.values() if joint.index == index)


def _on_base(body: Body, joint: JointInfo) -> bool:
    """Whether nothing between a joint and the base of its body can move."""
    while joint.parent != BASE:
        joint = _joint(body, joint.parent)
        if joint.type != "fixed":
            return False
    return True


def _lent(body: Body, joint: JointInfo) -> Mapping[int, AddedInertia]:
    """Moments that a link takes over from the one that its joint is on.

    Equal moments about all axes are the same in every frame, and two links that are fixed to each
    other have the inertia of both, however it is spread: together they move as before.
    """
    if joint.type == "prismatic":  # what resists there is mass, and mass has a place
        return {}
    _, moments = body.inertia(joint.parent)
    sharers = sum(j.parent == joint.parent and j.type != "fixed" for j in body.joints.values())
    lent = LENT * min(moments) / sharers
    return {joint.parent: AddedInertia(moment=-lent), joint.child: AddedInertia(moment=lent)}
