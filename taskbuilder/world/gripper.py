"""Make a gripper's joints move as one.

PyBullet leaves the joints of a gripper independent, even where the URDF ties them by mimic tags.
Two fingers driven apart from each other hold an object with no stiffness between them: the pair
floats sideways along the closing axis when the arm accelerates. So the joints are geared to each
other, as they are in the metal.
"""

from __future__ import annotations

from itertools import pairwise

from taskbuilder.schema.robots import RobotModel
from taskbuilder.sim.body import Body
from taskbuilder.sim.motors import Motors, couple

LEAST_INERTIA = 1e-3
"""Principal moments, in kg·m², that links of turning gripper joints have at least.

Published grippers have knuckles of 5e-6, with which the solver does not converge; a geared motor's
rotor, which a URDF leaves out, adds about this much.
"""


def build_gripper(body: Body, model: RobotModel) -> Motors:
    """Couple, brace and motorise the joints of a gripper, in the order of the robot file.

    In each finger the joint nearest the palm is driven; joints further out are geared to it, the
    driven joints to each other, and whatever else the linkage has to the first of them.
    """
    spec = model.spec.gripper
    chains = [_chain(model, finger[-1]) for finger in spec.fingers]
    driven = [chain[0] for chain in chains]
    beside = [joint for joint in spec.joints if not any(joint in chain for chain in chains)]
    gears = [gear for chain in chains for gear in pairwise(chain)]
    gears += [(driven[0], joint) for joint in (*driven[1:], *beside)]
    for leader, follower in gears:
        ratio = _travel(model, follower) / _travel(model, leader)
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


def _chain(model: RobotModel, link: str) -> list[str]:
    """The gripper's joints between the palm and a finger's link, from the palm outwards."""
    chain: list[str] = []
    joint = model.urdf.joint_above(link)
    while joint is not None:
        if joint.name in model.spec.gripper.joints:
            chain.insert(0, joint.name)
        joint = model.urdf.joint_above(joint.parent)
    return chain


def _travel(model: RobotModel, joint: str) -> float:
    ends = model.spec.gripper.joints[joint]
    return ends.open - ends.closed
