"""All trials of a robot, as figures."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from taskbuilder.schema.robots import RobotModel
from taskbuilder.trials.arm import JointTrial, try_arm
from taskbuilder.trials.gripping import BlockGrip, Motion, free_motion, grips
from taskbuilder.trials.opening import Opening, measure, widest
from taskbuilder.trials.stand import Stand, stand
from taskbuilder.trials.sucking import SuctionTrial, try_cup
from taskbuilder.world.fingers import Fingers


@dataclass(frozen=True)
class GripperTrial:
    """What was found out about a gripper.

    Attributes:
        opened: What is free between the fingers when it is open.
        closed: What is free when it is closed.
        expected: Force of each finger that follows from the robot file, in newtons.
        motion: How it moves when nothing is in its way.
        grips: What it does with blocks; none where nothing is between the fingers.
    """

    opened: Opening
    closed: Opening
    expected: float
    motion: Motion
    grips: tuple[BlockGrip, ...]


@dataclass(frozen=True)
class RobotTrial:
    """What was found out about a robot.

    Attributes:
        gripper: About its fingers; None without.
        arm: About each joint of its arm.
        suction: About its suction cup; None without.
    """

    gripper: GripperTrial | None
    arm: tuple[JointTrial, ...]
    suction: SuctionTrial | None = None

    def as_data(self) -> dict[str, Any]:
        """The figures as JSON has them, in SI units; null for what is infinite."""
        return {
            "gripper": None if self.gripper is None else _gripper_data(self.gripper),
            "suction": None if self.suction is None else _suction_data(self.suction),
            "arm": [
                {
                    "joint": joint.joint,
                    "effort": joint.effort,
                    "needed": _number(joint.needed),
                    "sag": _number(joint.sag),
                    "lag": _number(joint.lag),
                }
                for joint in self.arm
            ],
        }


def try_robot(model: RobotModel, gripper: GripperTrial | None = None) -> RobotTrial:
    """Try a robot in physics: its gripper on blocks, and its arm under gravity.

    Args:
        model: The robot; its URDF must be known to load.
        gripper: What is known of its gripper already.
    """
    if gripper is None and model.spec.gripper is not None:
        gripper = try_gripper(model)
    suction = None
    if model.spec.suction is not None:
        with stand(model, rigid=True) as rigid:
            suction = try_cup(rigid, model.spec.suction)
    with stand(model) as own:
        return RobotTrial(gripper, try_arm(own), suction)


def try_gripper(model: RobotModel) -> GripperTrial:
    """Try the gripper of a robot, on an arm that gives way to nothing."""
    with stand(model, rigid=True) as rigid:
        opened, closed = widest(rigid), measure(rigid, 0.0)
        expected = _expected(rigid)
        motion = free_motion(rigid)
        free = math.isfinite(opened.width) and opened.width > 0.0
        tried = tuple(grips(rigid, opened)) if free else ()
    return GripperTrial(opened, closed, expected, motion, tried)


def _expected(tried: Stand) -> float:
    """The force of each finger, by the work of the motors: theirs is that of the fingers."""
    robot = tried.robot
    spec = robot.model.spec.gripper
    if spec is None or not isinstance(robot.gripper, Fingers):
        return 0.0
    low, high = 0.3, 0.7
    widths = [measure(tried, opening).width for opening in (low, high)]
    closing = abs(widths[1] - widths[0])
    driven = [
        abs(end.open - end.closed) * (high - low)
        for index, end in zip(robot.gripper.joints, spec.joints.values(), strict=True)
        if index in robot.gripper.driven
    ]
    if not math.isfinite(closing) or closing < 1e-6:
        return 0.0
    together = spec.force * sum(driven) / closing
    several = len(robot.gripper.tips)
    return together if several <= 2 else 2.0 * together / several


def _gripper_data(trial: GripperTrial) -> dict[str, Any]:
    return {
        "stroke": _number(trial.opened.width),
        "widest_at_tcp": _number(trial.opened.centered),
        "closed": _number(trial.closed.width),
        "closes_in_s": _number(trial.motion.seconds),
        "fastest": _number(trial.motion.fastest),
        "expected_force": _number(trial.expected),
        "grips": [_grip_data(grip) | {"force": _number(grip.force)} for grip in trial.grips],
    }


def _suction_data(trial: SuctionTrial) -> dict[str, Any]:
    return {
        "cup": _number(trial.width),
        "gap": _number(trial.gap),
        "grips": [_grip_data(grip) for grip in trial.grips],
    }


def _grip_data(grip: BlockGrip) -> dict[str, Any]:
    return {
        "width": _number(grip.width),
        "held": grip.held,
        "slip": _number(grip.slip),
        "load": _number(grip.load),
    }


def _number(value: float) -> float | None:
    return round(value, 6) + 0.0 if math.isfinite(value) else None
