"""Trying an object: how it lies on a level surface, and whether it stays so."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from taskbuilder.geometry import ORIGIN, Pose, Vec3, conjugate, norm, rotate, to_rpy_deg
from taskbuilder.quiet import captured
from taskbuilder.schema.object_files import ObjectModel
from taskbuilder.shapes import BoxShape, Part
from taskbuilder.sim.bodies import create_body
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.trials.stand import PHYSICS_HZ
from taskbuilder.world.handling import Surfaces
from taskbuilder.world.lone_object import lone_object

_LOW_M, _WIDE_M, _THICK_M = 1e-3, 10.0, 0.5
_SETTLE_S, _STILL = 3.0, 0.02  # m/s and rad/s: what is slower lies still
_TILTED_DEG = 2.0
_RESET_S = 0.1  # so long a scene settles after a reset
_SIDES: tuple[Vec3, ...] = (
    (0, 0, 0), (180, 0, 0), (90, 0, 0), (-90, 0, 0), (0, 90, 0), (0, -90, 0),
)  # fmt: skip
_WATCHED_S, _YAWS, _WAKES = 5.0, 12, 0.1  # m/s and rad/s: what is faster has not stayed still


@dataclass(frozen=True)
class Rest:
    """How an object comes to lie.

    Attributes:
        tilt_deg: By how much its z axis is tilted.
        rpy_deg: Roll and pitch in which it lies, in whole degrees or else in tenths, and no yaw. If
            it tilts when it is put so, that of a side on which it does not, if there is one.
        still: Whether it lies still after three seconds; a ball may not.
        rocks: Whether it tilts again when it is put as it lay, as on a round underside.
        steady: Whether it lies still if it is put with ``rpy_deg``.
        twitches: Whether it moves now and then in that orientation, although nothing touches it.
    """

    tilt_deg: float
    rpy_deg: Vec3
    still: bool
    rocks: bool = False
    steady: bool = True
    twitches: bool = False

    @property
    def turned(self) -> bool:
        """Whether it is to be put in another orientation than its own."""
        return (self.still or self.steady) and any(self.rpy_deg)


def rest(model: ObjectModel) -> Rest:
    """Put an object on a level surface, upright in its own frame, and wait.

    If it tilts, it is put as it then lies, and if it tilts again, on each of its sides. In the
    orientation in which it lies still, it is watched with twelve yaws, for five seconds each.

    Args:
        model: The object; its files must be known to load.
    """
    with _surface(model) as placing:
        first = _settled(placing, (0, 0, 0))
        if _steady(placing, (0, 0, 0)):
            twitches = _twitches(placing, (0, 0, 0))
            return Rest(first.tilt_deg, (0, 0, 0), first.still, twitches=twitches)
        whole, tenths = (_rounded(first.rpy_deg, digits) for digits in (0, 1))
        for turn in (whole, tenths, *_SIDES):
            if _steady(placing, turn):
                rocks, twitches = turn not in (whole, tenths), _twitches(placing, turn)
                return Rest(first.tilt_deg, turn, first.still, rocks=rocks, twitches=twitches)
    return Rest(first.tilt_deg, whole, first.still, rocks=True, steady=False)


class _Placing(NamedTuple):
    """An object that is put on a level surface."""

    client: Client
    body: Body
    solid: Surfaces

    def put(self, rpy_deg: Vec3) -> None:
        """Put it just above the surface."""
        low = float(self.solid.lying(rpy_deg).low[2])
        self.body.place(Pose.from_rpy_deg((0.0, 0.0, _LOW_M - low), rpy_deg))

    @property
    def speed(self) -> float:
        """Its speed, in m/s or rad/s, whichever is more."""
        return max(map(norm, self.body.velocity()))


@contextmanager
def _surface(model: ObjectModel) -> Iterator[_Placing]:
    """The object and a level surface."""
    with (
        tempfile.TemporaryDirectory(prefix="taskbuilder-") as folder,
        Client(physics_hz=PHYSICS_HZ) as client,
        captured(),
    ):
        body = lone_object(client, model, Path(folder))
        plate = BoxShape((_WIDE_M, _WIDE_M, 2.0 * _THICK_M))
        ground = {"ground": Part(plate, Pose(), (1.0, 1.0, 1.0, 1.0))}
        create_body(client, ground, pose=Pose((0.0, 0.0, -_THICK_M)))
        yield _Placing(client, body, Surfaces.of(model))


class _Settled(NamedTuple):
    """How an object lies after it was put.

    Attributes:
        rpy_deg: Roll and pitch.
        tilt_deg: By how much it has tilted.
        still: Whether it lies still.
    """

    rpy_deg: Vec3
    tilt_deg: float
    still: bool


def _settled(placing: _Placing, turn: Vec3) -> _Settled:
    """Put an object, and wait."""
    placing.put(turn)
    placing.client.step(round(_SETTLE_S * PHYSICS_HZ))
    roll, pitch, _ = to_rpy_deg(placing.body.pose().quaternion)
    return _Settled((roll, pitch, 0.0), _tilt_deg(placing, turn), placing.speed <= _STILL)


def _steady(placing: _Placing, turn: Vec3) -> bool:
    """Whether an object lies still in an orientation, and does not rock on the way."""
    for yaw in _yaws():
        placing.put((turn[0], turn[1], yaw))
        placing.client.step(round(_RESET_S * PHYSICS_HZ))
        if _tilt_deg(placing, (turn[0], turn[1], yaw)) > _TILTED_DEG:
            return False
    settled = _settled(placing, turn)
    return settled.still and settled.tilt_deg <= _TILTED_DEG


def _yaws() -> Iterator[float]:
    yield from (360.0 / _YAWS * number for number in range(_YAWS))


def _tilt_deg(placing: _Placing, turn: Vec3) -> float:
    """By how much an object has tilted since it was put."""
    up = rotate(conjugate(Pose.from_rpy_deg(ORIGIN, turn).quaternion), (0.0, 0.0, 1.0))
    cosine = rotate(placing.body.pose().quaternion, up)[2]
    return math.degrees(math.acos(max(-1.0, min(1.0, cosine))))


def _rounded(rpy_deg: Vec3, digits: int) -> Vec3:
    roll, pitch, yaw = (round(angle, digits) + 0.0 for angle in rpy_deg)
    return roll, pitch, yaw


def _twitches(placing: _Placing, turn: Vec3) -> bool:
    """Whether an object that lies still moves without a cause.

    Bullet keeps four points of a contact, and replaces one of them by the next that it finds. On a
    flat side of a hull with many corners, the four that are left may not carry the object.
    """
    for yaw in _yaws():
        placing.put((turn[0], turn[1], yaw))
        placing.client.step(PHYSICS_HZ)
        for _ in range(round(_WATCHED_S * PHYSICS_HZ)):
            placing.client.step(1)
            if placing.speed > _WAKES:
                return True
    return False
