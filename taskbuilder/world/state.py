"""The state of a world, as it is saved and restored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from taskbuilder.geometry import Pose
from taskbuilder.sim.contacts import ContactPoint
from taskbuilder.sim.snapshots import Snapshot
from taskbuilder.world.forces import ForceReading, Pair
from taskbuilder.world.looks import Look


@dataclass(frozen=True)
class WorldState:
    """A saved state of a world, to restore in the same world.

    Attributes:
        snapshot: The physics and the motors' targets.
        time: Seconds since the episode began.
        sites: Pose of each site, in the world or in the frame that it moves with.
        quantities: Values of the quantities that the task can randomise.
        contacts: All contacts in which something can move.
        forces: Forces between the watched pairs of bodies.
        look: How the episode looks.
        disturbed: What the episode drew for disturbances, by axis.
    """

    snapshot: Snapshot
    time: float
    sites: Mapping[str, Pose]
    quantities: Mapping[str, Any]
    contacts: tuple[ContactPoint, ...]
    forces: Mapping[Pair, ForceReading]
    look: Look
    disturbed: Mapping[str, Any]
