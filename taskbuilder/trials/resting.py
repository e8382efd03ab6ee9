"""Trying an object: whether it stands on a level surface as its own frame has it."""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

from taskbuilder.geometry import ORIGIN, Pose, norm, to_rpy_deg
from taskbuilder.quiet import captured
from taskbuilder.schema.object_files import ObjectModel
from taskbuilder.shapes import BoxShape, Part
from taskbuilder.sim.bodies import create_body
from taskbuilder.sim.client import Client
from taskbuilder.trials.stand import PHYSICS_HZ
from taskbuilder.world.lone_object import lone_object

_LOW_M, _WIDE_M, _THICK_M = 1e-3, 10.0, 0.5
_SETTLE_S, _STILL = 3.0, 0.02  # m/s and rad/s: what is slower lies still
_TILTED_DEG = 2.0


@dataclass(frozen=True)
class Rest:
    """How an object comes to lie.

    Attributes:
        tilt_deg: By how much its z axis is tilted.
        rpy_deg: Roll and pitch in which it lies, whole degrees, and no yaw.
        still: Whether it lies still after three seconds; a ball may not.
    """

    tilt_deg: float
    rpy_deg: tuple[int, int, int]
    still: bool

    @property
    def upright(self) -> bool:
        """Whether it stands as it was put."""
        return self.tilt_deg <= _TILTED_DEG


def rest(model: ObjectModel, low: float) -> Rest:
    """Put an object on a level surface, upright in its own frame, and wait.

    Args:
        model: The object; its files must be known to load.
        low: Smallest z of its surfaces in its frame, in metres.
    """
    with (
        tempfile.TemporaryDirectory(prefix="taskbuilder-") as folder,
        Client(physics_hz=PHYSICS_HZ) as client,
        captured(),
    ):
        body = lone_object(client, model, Path(folder))
        plate = BoxShape((_WIDE_M, _WIDE_M, 2.0 * _THICK_M))
        ground = {"ground": Part(plate, Pose(), (1.0, 1.0, 1.0, 1.0))}
        create_body(client, ground, pose=Pose((0.0, 0.0, -_THICK_M)))
        body.place(Pose((0.0, 0.0, _LOW_M - low)))
        client.step(round(_SETTLE_S * PHYSICS_HZ))
        pose, moves = body.pose(), body.velocity()
    roll, pitch, _ = to_rpy_deg(pose.quaternion)
    tilt = math.degrees(math.acos(max(-1.0, min(1.0, Pose(ORIGIN, pose.quaternion).axis(2)[2]))))
    return Rest(tilt, (round(roll), round(pitch), 0), max(map(norm, moves)) <= _STILL)
