"""Whether a task asks of each robot what its end effector can do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from taskbuilder.errors import Finding
from taskbuilder.schema.expert import ExpertStage, each_order, each_together
from taskbuilder.schema.order import Order
from taskbuilder.schema.robots import RobotModel
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.source import Path_, Source, dotted

_HOLDING = ("grasp", "close", "release", "bring", "turn", "slide")
"""Verbs of orders for which a robot takes hold of something, or lets go."""


def check_end_effectors(
    source: Source,
    stages: Sequence[ExpertStage],
    scene: SceneSpec,
    robots: Mapping[str, RobotModel],
) -> Iterator[Finding]:
    """Check that only robots with a gripper are ordered to grasp.

    Args:
        source: The task file.
        stages: Its expert.
        scene: Its scene.
        robots: The models of its robots.
    """
    handless = {name: model for name, model in robots.items() if not model.takes_hold}

    def finding(path: Path_, message: str) -> Finding:
        return Finding("TB216", message, dotted(path), source.locate(path, key=True))

    for name in handless:
        if name in scene.robots and "gripper" in scene.robots[name].action.model_fields_set:
            path: Path_ = ("scene", "robots", name, "action", "gripper")
            yield finding(path, f"{_lacks(name, handless)}; leave gripper out")
    for name, entry in scene.robots.items():
        sucks = name in robots and robots[name].spec.suction is not None
        if sucks and entry.action.gripper == "continuous":
            path = ("scene", "robots", name, "action", "gripper")
            message = f"the suction of {name} is on or off; write gripper: binary"
            yield Finding("TB216", message, dotted(path), source.locate(path))
    for name, entry in scene.robots.items():
        if entry.grasp is not None and name in robots and robots[name].spec.gripper is None:
            path = ("scene", "robots", name, "grasp")
            model = robots[name]
            has = "a suction cup" if model.takes_hold else "no gripper"
            message = f"{name} is a {model.name}, which has {has}, and grasp is for fingers"
            yield finding(path, f"{message}; leave it out")
    for path, robot, order in each_order(stages):
        if robot in handless and order.verb in _HOLDING:
            message = f"{_lacks(robot, handless)}, and cannot {order}; {_instead(order)}"
            yield finding((*path, order.verb), message)
    for path, stage in each_together(stages):
        for robot in stage.together:
            if robot in handless:
                advice = "only robots that hold the load can bring it together"
                message = f"{_lacks(robot, handless)}, and cannot {stage}; {advice}"
                yield finding((*path, "together"), message)


def _lacks(robot: str, handless: Mapping[str, RobotModel]) -> str:
    return f"{robot} is a {handless[robot].name}, which has no gripper"


def _instead(order: Order) -> str:
    """What to write in place of an order that takes a gripper."""
    if order.verb == "bring":
        return f"to move {order.bring}, write {{push: {order.bring}, to: ...}}"
    if order.verb == "grasp":
        thing = str(order.grasp).partition(".")[0]
        return f"to move {thing}, write {{push: {thing}, to: ...}}, or use a robot with a gripper"
    if order.verb in ("turn", "slide"):
        return "to move what it touches, write press, or reach with touching"
    return "leave it out"
