"""How the robots of a scene hold objects: by the friction of fingers, or by attaching them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import get_args

from taskbuilder.errors import UsageError
from taskbuilder.schema.agents import RobotEntry
from taskbuilder.schema.choices import GraspChoice
from taskbuilder.schema.load import TaskFile
from taskbuilder.schema.robot import GraspRule, GraspSpec
from taskbuilder.schema.robots import RobotModel
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.values import frozen
from taskbuilder.wording import suggestion

DISTANCE_M = 0.04
"""Default distance from the tcp to a surface that a closing gripper takes, in metres."""


@dataclass(frozen=True)
class Grasping:
    """How a gripper with fingers holds objects, with the defaults filled in; see `GraspSpec`.

    Attributes:
        rule: ``friction`` or ``attach``.
        distance: Maximum distance from the tcp to the surface of what it takes, in metres.
        force: Force in newtons above which an object comes off; None for no limit.
    """

    rule: GraspRule = "friction"
    distance: float = DISTANCE_M
    force: float | None = None


def grasping(entry: RobotEntry, model: RobotModel) -> Grasping | None:
    """How a robot of a scene holds objects; None for a robot without fingers.

    What the scene does not say of the robot is as in its robot file.
    """
    gripper = model.spec.gripper
    if gripper is None:
        return None
    written = [spec for spec in (gripper.grasp, entry.grasp) if spec is not None]
    given = {
        name: value
        for spec in written
        for name in GraspSpec.model_fields
        if (value := getattr(spec, name)) is not None
    }
    return Grasping(**given)


def grasp_rules(file: TaskFile, grasp: str = "task") -> Mapping[str, GraspRule]:
    """The rule of each robot with fingers of a task, for a choice of the option ``grasp``.

    Raises:
        UsageError: As `with_grasp`.
    """
    return rules_of(with_grasp(file, grasp).spec.scene, file.robots)


def rules_of(scene: SceneSpec, models: Mapping[str, RobotModel]) -> Mapping[str, GraspRule]:
    """The rule of each robot with fingers of a scene."""
    held = {name: grasping(entry, models[name]) for name, entry in scene.robots.items()}
    return {name: how.rule for name, how in held.items() if how is not None}


def with_grasp(file: TaskFile, grasp: str) -> TaskFile:
    """Choose how all grippers with fingers hold objects, in the task and in its variations.

    The distance and the force stay as they are. Suction cups and tools stay what they are.

    Args:
        file: The task file.
        grasp: ``task`` for the task file as it is, or the rule.

    Raises:
        UsageError: There is no such rule, or no robot of the task has fingers.
    """
    choices = get_args(GraspChoice)
    if grasp not in choices:
        raise UsageError(f'grasp "{grasp}": {suggestion(str(grasp), choices, what="one of")}')
    if grasp == "task":
        return file
    fingered = {name for name, model in file.robots.items() if model.spec.gripper is not None}
    if not fingered:
        ends = ", ".join(f"{name} is a {model.name}" for name, model in file.robots.items())
        raise UsageError(
            f"no robot of {file.entry.name} has fingers to hold objects by ({ends}); leave grasp "
            "out, or choose another robot"
        )

    def changed(scene: SceneSpec) -> SceneSpec:
        robots = {
            name: _ruled(entry, grasp) if name in fingered else entry
            for name, entry in scene.robots.items()
        }
        return scene.model_copy(update={"robots": frozen(robots)})

    spec, written = (
        each.model_copy(update={"scene": changed(each.scene)}) for each in (file.spec, file.written)
    )
    return replace(file, spec=spec, written=written, scenes=tuple(map(changed, file.scenes)))


def _ruled(entry: RobotEntry, rule: str) -> RobotEntry:
    spec = (entry.grasp or GraspSpec()).model_copy(update={"rule": rule})
    return entry.model_copy(update={"grasp": spec})
