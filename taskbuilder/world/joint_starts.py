"""Joints of objects that start somewhere else in each episode."""

from __future__ import annotations

import numpy as np

from taskbuilder.world.mimics import starting
from taskbuilder.world.scene_objects import SceneObject


def draw_joints(thing: SceneObject, rng: np.random.Generator) -> None:
    """Put the joints of an object that start at random where this episode has them.

    Args:
        thing: The object, as it was built.
        rng: The episode's generator for placement. An object without such joints draws nothing.
    """
    if not thing.start_ranges:
        return
    drawn = {name: float(rng.uniform(*bounds)) for name, bounds in thing.start_ranges.items()}
    names = [name for name, joint in thing.body.joints.items() if joint.index in thing.joints]
    built = {name: thing.body.joint_position(name) for name in names}
    locked = [joint for name, joint in thing.passive.items() if name in drawn and joint.locked]
    for joint in locked:
        joint.unlock()
    thing.body.put_joints(starting({**built, **drawn}, thing.mimics))
    for joint in locked:
        joint.lock()
