"""Fingers: a gripper whose joints move as one.

PyBullet leaves the joints of a gripper independent, even where the URDF ties them by mimic tags.
Two fingers driven apart from each other hold an object with no stiffness between them: the pair
floats sideways along the closing axis when the arm accelerates. So the joints are geared to each
other, as they are in the metal.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise

from taskbuilder.geometry import ORIGIN, add, dot, norm, scale, subtract, total, unit
from taskbuilder.schema.robot import GripperSpec
from taskbuilder.schema.robots import RobotModel
from taskbuilder.sim.attachments import Graspable
from taskbuilder.sim.body import Body
from taskbuilder.sim.contacts import forget_turned
from taskbuilder.sim.motors import Command, Motors, couple
from taskbuilder.world.end_effector import Push, Pushes
from taskbuilder.world.grip_force import LEAST_INERTIA

GRASP_FORCE_N = 0.5
"""What each finger must press with to hold something: well above the noise of a touch."""

STOPPED = 0.01
"""Speed below which a joint counts as stopped, m/s or rad/s."""

SPREAD = 0.02
"""Opening that is missing to the commanded one, from which fingers press outwards."""

_BALANCED = 0.775  # length of the sum of directions; that of two at the limit below
_OPPOSING = -0.7  # cosine of the angle between the forces of two fingers; -1 is straight against


class Fingers:
    """A gripper that closes. It is an `EndEffector`.

    Args:
        body: The robot.
        model: What it is.
        spec: Its gripper.

    Attributes:
        driven: Indices of the joints with a motor; the others are geared to them.
    """

    rest = 0.0

    def __init__(self, body: Body, model: RobotModel, spec: GripperSpec) -> None:
        self.tips = tuple(tuple(body.links[link] for link in finger) for finger in spec.fingers)
        self._body, self._ends = body, tuple(spec.joints.values())
        self._motors = _motorised(body, model, spec)
        self.joints = self._motors.indices
        self.driven = tuple(
            index for index, force in zip(self.joints, self._motors.forces, strict=True) if force
        )

    @property
    def command(self) -> Command:
        """The last command to its motors."""
        return self._motors.command

    def issue(self, command: Command) -> None:
        """Give a command, perhaps one remembered from earlier."""
        self._motors.issue(command)

    def opening(self) -> float:
        """How far it is open, from 0 (closed) to 1, averaged over its joints."""
        positions, _ = self._body.joint_states(self.joints)
        shares = [
            (position - end.closed) / (end.open - end.closed)
            for position, end in zip(positions, self._ends, strict=True)
            if end.open != end.closed
        ]
        return total(shares) / len(shares)

    def told(self) -> float:
        """The last commanded opening."""
        ends = zip(self.command.values, self._ends, strict=True)
        value, end = next((value, end) for value, end in ends if end.open != end.closed)
        return (value - end.closed) / (end.open - end.closed)

    def move(self, opening: float) -> None:
        """Drive it to an opening from 0 (closed) to 1 (open)."""
        positions = self.positions(opening)
        if positions == self.command.values:
            return  # motors go on with what they were told
        if self.command.values and opening > self.told():
            forget_turned(self._body)
        self._motors.position(positions)

    def stop(self) -> None:
        """Hold its joints where they are."""
        self._motors.position(self._body.joint_states(self.joints)[0])

    def positions(self, opening: float) -> tuple[float, ...]:
        """Positions of its joints at an opening from 0 to 1."""
        return tuple(end.closed + opening * (end.open - end.closed) for end in self._ends)

    def go_home(self) -> None:
        """Open it at once, past all motors, and hold it there."""
        self._body.reset_joints(self.joints, self.positions(1.0))
        self.move(1.0)

    # Unused arguments are part of the `EndEffector` protocol.
    def holds(self, body: Body, link: int | None, pushes: Pushes) -> bool:  # noqa: ARG002
        """Whether fingers press on a body, or on a link of it, from opposite sides.

        They press towards each other or, if they are commanded further open than they are, away
        from each other on what they hold from inside. Three fingers also hold what they press on if
        their forces balance.
        """
        strong = [push for push in pushes() if norm(push.force) > GRASP_FORCE_N]
        if any(_opposed(*pair, inwards=True) for pair in combinations(strong, 2)):
            return True
        if any(_balanced(three, inwards=True) for three in combinations(strong, 3)):
            return True
        if len(strong) < 2 or self.told() - self.opening() < SPREAD:
            return False
        return any(_opposed(*pair, inwards=False) for pair in combinations(strong, 2)) or any(
            _balanced(three, inwards=False) for three in combinations(strong, 3)
        )

    def forces(self, body: Body, link: int | None, pushes: Pushes) -> tuple[float, ...]:  # noqa: ARG002
        """Force of each finger on a body, or on a link of it, in newtons."""
        return tuple(norm(push.force) for push in pushes())

    def moves(self) -> bool:
        """Whether its joints have not stopped yet."""
        return max(map(abs, self._body.joint_speeds(self.joints))) >= STOPPED

    def closes(self) -> bool:
        """It never does: what it holds is between its fingers."""
        return False

    def words(self) -> str:
        """How far it is open, for messages."""
        return f"its gripper is {max(self.opening(), 0.0) * 100:.0f} % open"

    def drive(self, things: Sequence[Graspable]) -> None:
        """Nothing: motors go on with what they were told."""


def _opposed(one: Push, other: Push, *, inwards: bool) -> bool:
    """Whether two fingers press against each other: towards each other, with their inner sides.

    Args:
        one: The push of one finger.
        other: That of the other.
        inwards: Whether they press towards each other; else away from each other.
    """
    across = subtract(other.at, one.at)
    against = dot(one.force, other.force) < _OPPOSING * norm(one.force) * norm(other.force)
    return against and (dot(one.force, across) > 0.0) == inwards


def _balanced(pushes: Sequence[Push], *, inwards: bool) -> bool:
    """Whether the directions of several pushes add up to little, and all point to their middle."""
    directions = [unit(push.force) for push in pushes]
    middle, sum_ = ORIGIN, ORIGIN
    for push, direction in zip(pushes, directions, strict=True):
        middle = add(middle, scale(push.at, 1.0 / len(pushes)))
        sum_ = add(sum_, direction)
    sides = [dot(push.force, subtract(middle, push.at)) > 0.0 for push in pushes]
    return norm(sum_) < _BALANCED and all(side == inwards for side in sides)


def _motorised(body: Body, model: RobotModel, spec: GripperSpec) -> Motors:
    """Couple, brace and motorise the joints of a gripper, in the order of the robot file.

    In each finger the joint nearest the palm is driven; joints further out are geared to it, the
    driven joints to each other, and whatever else the linkage has to the first of them. A fixed
    jaw has no joints.
    """
    chains = [_chain(model, spec, finger[-1]) for finger in spec.fingers]
    chains = [chain for chain in chains if chain]
    driven = [chain[0] for chain in chains]
    beside = [joint for joint in spec.joints if not any(joint in chain for chain in chains)]
    gears = [gear for chain in chains for gear in pairwise(chain)]
    gears += [(driven[0], joint) for joint in (*driven[1:], *beside)]
    for leader, follower in gears:
        if not (_travel(spec, leader) and _travel(spec, follower)):
            continue  # one of them stays where it is
        ratio = _travel(spec, follower) / _travel(spec, leader)
        couple(
            body.client, body, body.joints[leader].index, body.joints[follower].index, ratio=ratio
        )
    for joint in spec.joints:
        if body.joints[joint].type == "revolute":
            body.raise_inertia(body.joints[joint].child, LEAST_INERTIA)
    for finger in spec.fingers:
        for link in finger:
            body.set_grip(body.links[link], spec.friction)
    return Motors(
        body,
        [body.joints[joint].index for joint in spec.joints],
        forces=[spec.force if joint in driven else 0.0 for joint in spec.joints],
    )


def _chain(model: RobotModel, spec: GripperSpec, link: str) -> list[str]:
    """The gripper's joints between the palm and a finger's link, from the palm outwards."""
    chain: list[str] = []
    joint = model.urdf.joint_above(link)
    while joint is not None:
        if joint.name in spec.joints:
            chain.insert(0, joint.name)
        joint = model.urdf.joint_above(joint.parent)
    return chain


def _travel(spec: GripperSpec, joint: str) -> float:
    ends = spec.joints[joint]
    return ends.open - ends.closed
