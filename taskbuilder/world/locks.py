"""Locks of joints, which conditions of the description open."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

from taskbuilder.sim.passive_joints import PassiveJoint
from taskbuilder.world.scene_objects import SceneObject


@dataclass(frozen=True)
class JointLock:
    """A lock of an object's joint.

    Attributes:
        name: Of the joint, as ``box.hinge``.
        joint: The joint.
        unless: The condition of the description that frees it.
    """

    name: str
    joint: PassiveJoint
    unless: str

    def obey(self, conditions: Mapping[str, bool]) -> None:
        """Lock or free the joint, as the description's conditions say.

        Args:
            conditions: Whether each condition of the description holds, by its name.
        """
        if conditions[self.unless]:
            self.joint.unlock()
        else:
            self.joint.lock()


@dataclass(frozen=True)
class Locks:
    """Every lock of a scene."""

    of: tuple[JointLock, ...]

    def obey(self, conditions: Mapping[str, bool]) -> None:
        """Lock or free every joint, as the description's conditions say."""
        for lock in self.of:
            lock.obey(conditions)

    @property
    def joints(self) -> list[PassiveJoint]:
        """The joints that have a lock."""
        return [lock.joint for lock in self.of]

    @property
    def locked(self) -> Mapping[str, str]:
        """The locked joints, such as ``box.hinge``, each with the condition that frees it."""
        return {lock.name: lock.unless for lock in self.of if lock.joint.locked}

    @cached_property
    def holds(self) -> tuple[Callable[[], None], ...]:
        """What holds those that a motor alone does not hold; called after each physics step."""
        return tuple(joint.hold for joint in self.joints if joint.drifts)


def locks_of(objects: Mapping[str, SceneObject]) -> Locks:
    """Every lock of a scene."""
    of = tuple(
        JointLock(f"{name}.{inner}", joint, lock.unless)
        for name, thing in objects.items()
        for inner, joint in thing.passive.items()
        if (lock := thing.spec.joint(inner, turns=True).lock) is not None
    )
    return Locks(of)
