"""Trying an arm: what gravity asks of its motors, and how well they follow."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from taskbuilder.assets.model import UrdfJoint
from taskbuilder.geometry import cross, dot, rotate, scale, subtract, total
from taskbuilder.trials.gripping import GRAVITY
from taskbuilder.trials.stand import Stand
from taskbuilder.world.robot_building import ARM_EFFORT, ARM_SPEED

FASTEST_RAD, FASTEST_M = 4.0, 1.0
"""Speed limits in rad/s and m/s above which the limits of joints are not believed."""

_POSTURES = 300  # drawn within the limits, besides the ends of each joint
_HALF_SPEED, _SETTLE_S = 0.5, 0.4
_LONGEST_S = 4.0  # that a joint moves one way; on long rails it does not get to the end
_WIDE = math.pi  # how far a joint that turns without end is turned


@dataclass(frozen=True)
class JointTrial:
    """What was found out about a joint of an arm; rad, or m where it slides.

    Attributes:
        joint: Its name.
        slides: Whether it slides.
        effort: What its motor exerts at most, Nm or N.
        needed: What gravity asks of it at most, in any posture that was looked at.
        sag: Distance from where it was told to be, at rest, at most.
        lag: Distance behind where it was told to be, in motion, at most.
    """

    joint: str
    slides: bool
    effort: float
    needed: float
    sag: float
    lag: float


def try_arm(stand: Stand) -> tuple[JointTrial, ...]:
    """Move every joint of an arm to its limits and back, under gravity, with its own motors.

    The other joints stay home. Then the arm is put into the posture in which gravity asks most of
    the joint, of those that were drawn, and has to keep it.
    """
    loads, worst = _loads(stand)
    trials = []
    for index, name in enumerate(stand.robot.model.spec.arm):
        sag, lag = _moved(stand, index)
        sag = max(sag, _kept(stand, index, worst[index]))
        effort = stand.robot.body.joints[name].effort or ARM_EFFORT
        slides = not bool(stand.robot.chain.revolute[index])
        trials.append(JointTrial(name, slides, effort, loads[index], sag, lag))
    return tuple(trials)


def _ends(stand: Stand) -> tuple[np.ndarray, np.ndarray]:
    chain, home = stand.robot.chain, np.array(stand.robot.home)
    low = np.where(np.isfinite(chain.lower), chain.lower, home - _WIDE)
    return low, np.where(np.isfinite(chain.upper), chain.upper, home + _WIDE)


def _loads(stand: Stand) -> tuple[list[float], list[list[float]]]:
    """What gravity asks of each joint at most, and the posture in which it does."""
    stand.at_home()
    low, high = _ends(stand)
    rng = np.random.default_rng(0)
    home = np.array(stand.robot.home)
    postures = [home]
    for index in range(len(home)):
        for end in (low, high):
            posture = home.copy()
            posture[index] = end[index]
            postures.append(posture)
    postures += list(rng.uniform(low, high, (_POSTURES, len(home))))
    beyond = _beyond(stand)
    most, worst = [0.0] * len(home), [home.tolist()] * len(home)
    for posture in postures:
        stand.robot.pose_arm(posture.tolist())
        for index, load in enumerate(_torques(stand, beyond)):
            if load > most[index]:
                most[index], worst[index] = load, posture.tolist()
    return most, worst


def _beyond(stand: Stand) -> list[tuple[UrdfJoint, list[str]]]:
    """The joints of the arm, with the links that each moves."""
    urdf = stand.robot.model.urdf
    above = {link.name: urdf.moving_joints_above(link.name) for link in urdf.links}
    return [
        (joint, [name for name, joints in above.items() if joint in joints])
        for joint in stand.robot.model.arm
    ]


def _torques(stand: Stand, beyond: Sequence[tuple[UrdfJoint, Sequence[str]]]) -> Iterator[float]:
    """Torque (Nm) or force (N) of gravity on each joint of the arm, as it is posed."""
    body = stand.robot.body
    moved = dict.fromkeys(name for _, names in beyond for name in names)
    centers = {name: body.center_of_mass(name) for name in moved}
    weights = {name: scale(GRAVITY, body.mass_of(name)) for name in moved}
    for joint, links in beyond:
        frame = body.pose_of(joint.child)
        axis = rotate(frame.quaternion, joint.axis)
        if joint.type == "prismatic":
            yield abs(total(dot(weights[name], axis) for name in links))
            continue
        arms = {name: subtract(centers[name], frame.position) for name in links}
        yield abs(total(dot(cross(arms[name], weights[name]), axis) for name in links))


def _moved(stand: Stand, index: int) -> tuple[float, float]:
    """Sag at the limits of a joint, and lag on the way."""
    stand.at_home()
    stand.client.set_gravity(GRAVITY)
    robot, client = stand.robot, stand.client
    low, high = _ends(stand)
    name = robot.model.spec.arm[index]
    most = FASTEST_M if robot.body.joints[name].type == "prismatic" else FASTEST_RAD
    speed = _HALF_SPEED * min(robot.body.joints[name].velocity or ARM_SPEED, most)
    target = list(robot.home)
    sag = lag = 0.0
    for end in (float(low[index]), float(high[index]), robot.home[index]):
        start, longest = target[index], speed * _LONGEST_S
        goal = min(max(end, start - longest), start + longest)
        way = goal - start
        steps = max(1, math.ceil(abs(way) / speed / client.dt))
        for step in range(1, steps + 1):
            target[index] = start + way * step / steps
            robot.arm.pass_by(target)
            client.step(1)
            lag = max(lag, _off(stand, index, target[index]))
        robot.move_arm(target)
        client.step(round(_SETTLE_S / client.dt))
        sag = max(sag, _off(stand, index, goal))
    return sag, lag


def _kept(stand: Stand, index: int, posture: list[float]) -> float:
    """How far a joint gets from a posture in which it was put."""
    stand.at_home()
    stand.robot.pose_arm(posture)
    stand.robot.move_arm(posture)
    stand.client.set_gravity(GRAVITY)
    stand.client.step(round(_SETTLE_S / stand.client.dt))
    return _off(stand, index, posture[index])


def _off(stand: Stand, index: int, target: float) -> float:
    position = stand.robot.arm_state()[0][index]
    off = abs(position - target)
    return off if math.isfinite(off) else math.inf
