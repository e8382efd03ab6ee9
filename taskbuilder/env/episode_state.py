"""Saved states of episodes: what leads to a state, and how an episode goes back to it.

A state holds the seed and all actions since the reset, so it can be restored by playing the actions
again, in any environment of the same task and options. That takes as long as the episode so far. So
a state holds a snapshot of the physics engine, too, where a snapshot leads to the same: see
`taskbuilder.sim.contact_order`. It belongs to one engine, and is left out of copies and pickles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from hashlib import blake2b
from typing import Any
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from taskbuilder.description.description import Outcome
from taskbuilder.env.course import ActionNumbers, Conditions
from taskbuilder.env.options import Options
from taskbuilder.errors import SimulationError, UsageError
from taskbuilder.sim.snapshots import Snapshot, release
from taskbuilder.task import Task
from taskbuilder.world.state import WorldState
from taskbuilder.world.world import World


@dataclass(frozen=True)
class EpisodeState:
    """A saved state of an episode.

    Attributes:
        task: Name of the task.
        options: The options on which the course of an episode depends.
        seed: Seed of the episode.
        variation: Number of its variation.
        actions: All actions since the reset.
        locking: The conditions that held after the reset and after each control step, where joints
            have locks.
        memory: Memory of the description.
        outcome: Outcome of the last evaluation.
        succeeded: As in `Episode`.
        failed: As in `Episode`.
        over: As in `Episode`.
        noise: State of the generator of observation noise.
        waiting: The actions of each delayed robot that it has yet to carry out.
        fingerprint: Hash of the physical state.
        snapshot: A snapshot of the world that leads to the same; None if none does.
    """

    task: str
    options: Mapping[str, Any]
    seed: int
    variation: int
    actions: tuple[ActionNumbers, ...]
    locking: tuple[Conditions, ...]
    memory: Any
    outcome: Outcome
    succeeded: bool
    failed: bool
    over: bool
    noise: Mapping[str, Any]
    waiting: Mapping[str, tuple[NDArray[np.float64], ...]]
    fingerprint: str
    snapshot: WorldState | None = None

    def __reduce__(self) -> tuple[Callable[..., EpisodeState], tuple[Any, ...]]:
        kept = [getattr(self, field.name) for field in fields(self) if field.name != "snapshot"]
        return EpisodeState, tuple(kept)

    def check_fits(self, task: Task, options: Options) -> None:
        """Check that an environment can play what leads to this state.

        Raises:
            UsageError: It is of another task, or plays with other options.
        """
        if self.task != task.name:
            raise UsageError(f"the state is of {self.task}; this environment plays {task.name}")
        for name, value in options.decisive.items():
            if self.options[name] != value:
                raise UsageError(
                    f"the state was saved with {name}={self.options[name]!r}, and this environment "
                    f"has {name}={value!r}; make one with the options of the state"
                )

    def restored(self, world: World) -> bool:
        """Restore the snapshot in a world, and return whether that led to this state exactly."""
        if self.snapshot is None or self.snapshot.snapshot.client is not world.client:
            return False
        world.restore(self.snapshot)
        return not world.contact_order.uncertain and fingerprint(world) == self.fingerprint


def snapshot_of(world: World) -> WorldState | None:
    """A snapshot of a world, or None if it might not lead to the same.

    It takes 250 KB of the engine's memory, which are freed with the last reference to it.
    """
    if world.contact_order.ambiguous:
        return None
    state = world.save()
    finalize(state, _forget, state.snapshot)
    return state


def _forget(snapshot: Snapshot) -> None:
    with suppress(SimulationError):  # the world may be closed by now, and the snapshot with it
        release(snapshot)


def fingerprint(world: World) -> str:
    """A hash of the physical state."""
    return blake2b(repr(list(_moving(world))).encode(), digest_size=16).hexdigest()


def _moving(world: World) -> Iterator[Any]:
    yield world.time, world.quantities
    bodies = [robot.body for robot in world.robots.values()]
    for body in (*bodies, *(obj.body for obj in world.objects.values())):
        yield body.pose(), body.velocity(), body.all_joint_states()
