"""Locks of joints, which conditions of the description open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from taskbuilder.schema.joints import JointSpec
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


def locks_of(objects: Mapping[str, SceneObject]) -> tuple[JointLock, ...]:
    """Every lock of a scene."""
    return tuple(
        JointLock(f"{name}.{key}", joint, written.lock.unless)
        for name, thing in objects.items()
        for key, joint in thing.passive.items()
        if isinstance(written := thing.spec.joints[key], JointSpec) and written.lock is not None
    )
