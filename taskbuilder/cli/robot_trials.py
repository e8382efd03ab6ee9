"""Trying a robot for `robots check` and `robots import`, and showing what came of it."""

from __future__ import annotations

import math
from functools import partial

from taskbuilder.assets import codes
from taskbuilder.cli.output import print_table
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.jobs import LostError, worker_processes
from taskbuilder.schema.robots import RobotModel
from taskbuilder.trials.arm import JointTrial
from taskbuilder.trials.findings import judge
from taskbuilder.trials.gripping import MOST_PULL_N, BlockGrip
from taskbuilder.trials.robot_trial import GripperTrial, RobotTrial, try_gripper, try_robot

LIMIT_S = 120.0
"""Time that the trial of a robot may take."""


def tried(
    model: RobotModel, gripper: GripperTrial | None = None
) -> tuple[RobotTrial | None, tuple[Finding, ...]]:
    """Try a robot, in a process of its own unless it is one of the library.

    Args:
        model: The robot.
        gripper: What is known of its gripper already.

    Returns:
        What was measured, None if the process was lost, and what is wrong.
    """
    if model.entry.trusted:
        trial = try_robot(model, gripper)
        return trial, judge(trial, model)
    try:
        with worker_processes([{}], limit_s=LIMIT_S, prepared=try_robot.__module__) as spread:
            (trial,) = spread(partial(try_robot, gripper=gripper), [model])
    except LostError as error:
        return None, (_lost(model, error),)
    return trial, judge(trial, model)


def tried_gripper(model: RobotModel) -> GripperTrial:
    """Try the gripper of a robot in a process of its own.

    Raises:
        FileError: The process was lost.
    """
    try:
        with worker_processes([{}], limit_s=LIMIT_S, prepared=try_robot.__module__) as spread:
            (trial,) = spread(try_gripper, [model])
    except LostError as error:
        raise FileError([_lost(model, error)]) from error
    found: GripperTrial = trial
    return found


def _lost(model: RobotModel, error: LostError) -> Finding:
    message = (
        f"the physics engine was lost when the robot was tried: {error.fault.cause}; correct "
        "masses, inertias and damping, or leave the trial out with --quick"
    )
    return Finding(codes.CRASHED, message, "", Location(model.urdf.path))


def print_trial(trial: RobotTrial) -> None:
    """Print the figures of a trial, in two tables."""
    rows = [["arm", "gravity", "of effort", "sag", "lag"]]
    rows += [_joint_row(joint) for joint in trial.arm]
    print_table(rows, indent="  ")
    print()
    if trial.suction is not None:
        rows = [["suction", "held", "slip", "load"]]
        rows += [_cup_row(grip) for grip in trial.suction.grips]
        print_table(rows, indent="  ")
        print()
    if trial.gripper is None:
        return
    if trial.gripper.grips:
        rows = [["gripper", "held", "force", "slip", "load"]]
        rows += [_grip_row(grip) for grip in trial.gripper.grips]
        print_table(rows, indent="  ")
        print()
    for line in _opening_lines(trial.gripper):
        print(f"  {line}")
    print()


def _joint_row(joint: JointTrial) -> list[str]:
    unit = "N" if joint.slides else "Nm"

    def way(value: float) -> str:
        if not math.isfinite(value):
            return "flies"
        return f"{value * 1000:.1f} mm" if joint.slides else f"{math.degrees(value):.1f}°"

    needed = f"{joint.needed:.1f}" if joint.needed < 100 else f"{joint.needed:.0f}"
    effort = f"{joint.effort:.3g} {unit}"
    return [joint.joint, f"{needed} {unit}", effort, way(joint.sag), way(joint.lag)]


def _cup_row(grip: BlockGrip) -> list[str]:
    name = f"plate of {_mm(grip.width)}"
    if not grip.held:
        return [name, "falls" if grip.fits else "is in the cup", "", ""]
    load = f"{grip.load:.0f} N" if math.isfinite(grip.load) else "not pulled off"
    return [name, "yes", f"{grip.slip * 1000:.1f} mm", load]


def _grip_row(grip: BlockGrip) -> list[str]:
    name = f"block of {_mm(grip.width)}"
    if not grip.fits:
        return [name, "does not fit", "", "", ""]
    force = f"{grip.force:.1f} N"
    if not grip.held:
        return [name, "falls", force, "", ""]
    load = f"{grip.load:.0f} N" if math.isfinite(grip.load) else f"over {MOST_PULL_N:.0f} N"
    return [name, "yes", force, f"{grip.slip * 1000:.1f} mm", load]


def _opening_lines(trial: GripperTrial) -> list[str]:
    opened, closed, motion = trial.opened, trial.closed, trial.motion
    if not math.isfinite(opened.width):
        return []
    words = f"opens {_mm(opened.width)}"
    if opened.centered < 0.9 * opened.width:
        words += f" (objects in the middle of the tcp: {_mm(opened.centered)})"
    words += f", closes to {_mm(closed.width)}" if math.isfinite(closed.width) else ""
    words += f" in {motion.seconds:.1f} s" if math.isfinite(motion.seconds) else ""
    return [words]


def _mm(metres: float) -> str:
    return f"{metres * 1000:.0f} mm"
