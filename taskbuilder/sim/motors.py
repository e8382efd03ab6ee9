"""Motors: what drives the joints of a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

from taskbuilder.errors import SimulationError
from taskbuilder.geometry import ORIGIN
from taskbuilder.sim.body import Body
from taskbuilder.sim.bullet import p
from taskbuilder.sim.client import Client

Mode = Literal["free", "position", "velocity", "torque"]


@dataclass(frozen=True, slots=True)
class Command:
    """What a group of motors was told: a mode and a value for each motor.

    Attributes:
        values: Positions (rad or m), velocities, or torques (Nm or N); empty when free.
    """

    mode: Mode
    values: tuple[float, ...] = ()


FREE = Command("free")


class Motors:
    """The motors of some joints of one body, commanded together.

    Free until first commanded. The last command is kept, because Bullet's saved states leave
    out what motors were told.

    Args:
        body: The body.
        indices: Its joints' indices; the values of a command come in this order.
        forces: Largest force (N) or torque (Nm) of each.
        velocities: Fastest speed in position control of each, rad/s or m/s.
        position_gain: Share of a position error removed in one physics step.
        velocity_gain: Share of a velocity error removed in one physics step.

    Attributes:
        command: The last command.

    Raises:
        SimulationError: The lists differ in length.
    """

    def __init__(
        self,
        body: Body,
        indices: Sequence[int],
        *,
        forces: Sequence[float],
        velocities: Sequence[float] | None = None,
        position_gain: float = 0.1,
        velocity_gain: float = 1.0,
    ) -> None:
        count = len(indices)
        if len(forces) != count or len(velocities or forces) != count:
            raise SimulationError(f"{body.name}: {count} motors need {count} forces and velocities")
        self.body = body
        self.indices = tuple(indices)
        self.forces = tuple(forces)
        self.command = FREE
        self._idle = (0.0,) * count
        self._gains = position_gain, velocity_gain
        self.scale_gain(1.0)
        self._velocities = None if velocities is None else tuple(velocities)
        self.release()

    def scale_gain(self, factor: float) -> None:
        """Multiply the position gain of the built motors by a factor.

        Args:
            factor: 1 for the motors as they were built.
        """
        position_gain, velocity_gain = self._gains
        count = len(self.indices)
        self._to_positions = partial(
            self.body.client.bullet.setJointMotorControlArray,
            self.body.id,
            self.indices,
            p.POSITION_CONTROL,
            forces=self.forces,
            positionGains=(factor * position_gain,) * count,
            velocityGains=(velocity_gain,) * count,
        )
        if self.command.mode == "position":  # which the engine goes on with as it was told
            self.repeat()

    def position(self, positions: Sequence[float]) -> None:
        """Drive the joints to positions (rad or m) and hold them there."""
        self.issue(Command("position", tuple(positions)))

    def pass_by(self, positions: Sequence[float]) -> None:
        """Drive towards a waypoint that a command soon to follow leads beyond; not remembered."""
        self._to_positions(targetPositions=positions)

    def velocity(self, velocities: Sequence[float]) -> None:
        """Turn or slide the joints at velocities (rad/s or m/s)."""
        self.issue(Command("velocity", tuple(velocities)))

    def torque(self, torques: Sequence[float]) -> None:
        """Apply torques (Nm) or forces (N) during the next physics step.

        Bullet forgets them after each: pass `repeat` to `Client.step` to keep them up.
        """
        self.issue(Command("torque", tuple(torques)))

    def release(self) -> None:
        """Let the joints move freely."""
        self.issue(FREE)

    def repeat(self) -> None:
        """Give the last command again."""
        self.issue(self.command)

    def issue(self, command: Command) -> None:
        """Give a command, perhaps one remembered from earlier.

        Raises:
            SimulationError: It has not one value for each motor.
        """
        control = self.body.client.bullet.setJointMotorControlArray
        body, joints, values = self.body.id, self.indices, command.values
        match command.mode:
            case "position":
                if self.command.mode != "position":
                    self._limit_velocities()
                self._to_positions(targetPositions=values)
            case "velocity":
                control(
                    body, joints, p.VELOCITY_CONTROL, targetVelocities=values, forces=self.forces
                )
            case "torque":
                if self.command.mode != "torque":  # the motor would brake against the torque
                    control(body, joints, p.VELOCITY_CONTROL, forces=self._idle)
                control(body, joints, p.TORQUE_CONTROL, forces=values)
            case "free":
                control(body, joints, p.VELOCITY_CONTROL, forces=self._idle)
        self.command = command

    def _limit_velocities(self) -> None:
        """Only commands for a single joint take a limit; it stays until the mode changes."""
        for index, velocity in zip(self.indices, self._velocities or (), strict=False):
            self.body.client.bullet.setJointMotorControl2(
                self.body.id, index, p.POSITION_CONTROL, force=0.0, maxVelocity=velocity
            )


def couple(
    client: Client,
    body: Body,
    leader: int,
    follower: int,
    *,
    ratio: float = 1.0,
    offset: float = 0.0,
    max_force: float = 100.0,
) -> int:
    """Make one joint follow another: follower position = ratio · leader position + offset.

    Args:
        client: The client of the body.
        body: The body.
        leader: Index of the joint that leads.
        follower: Index of the joint that follows.
        ratio: Follower position for a unit of leader position; not 0.
        offset: Follower position at leader position 0, rad or m.
        max_force: Largest force (N) or torque (Nm) of the coupling.

    Returns:
        Bullet's number of the constraint.
    """
    axis = client.bullet.getJointInfo(body.id, leader)[13]
    constraint: int = client.bullet.createConstraint(
        body.id, leader, body.id, follower, p.JOINT_GEAR, axis, ORIGIN, ORIGIN
    )
    # Bullet holds leader + gearRatio · follower at the target.
    client.bullet.changeConstraint(
        constraint,
        gearRatio=-1.0 / ratio,
        relativePositionTarget=-offset / ratio,
        erp=0.1,
        maxForce=max_force,
    )
    return constraint
