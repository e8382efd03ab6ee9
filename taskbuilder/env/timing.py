"""Another length of episodes, or another control rate, for a task file."""

from __future__ import annotations

from dataclasses import replace

from taskbuilder.errors import UsageError
from taskbuilder.schema.agents import RobotEntry
from taskbuilder.schema.load import TaskFile
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.values import frozen


def with_timing(file: TaskFile, horizon: int | None, control_hz: int | None) -> TaskFile:
    """Change the length of episodes and the control rate; the speeds of robots stay the same.

    Args:
        file: The task file.
        horizon: Length of an episode in control steps; None for that of the task file.
        control_hz: Control steps per second; None for those of the task file.

    Raises:
        UsageError: The control rate does not divide the physics rate.
    """
    timing = file.spec.timing
    changes = {"episode_steps": horizon, "control_hz": control_hz}
    wanted = {key: value for key, value in changes.items() if value is not None}
    changed = timing.model_copy(update=wanted)
    if changed.physics_hz % changed.control_hz:
        rates = [hz for hz in range(1, changed.physics_hz + 1) if changed.physics_hz % hz == 0]
        near = min(rates, key=lambda hz: abs(hz - changed.control_hz))
        raise UsageError(
            f"control_hz {changed.control_hz} does not divide physics_hz "
            f"{changed.physics_hz} of {file.entry.name}; {near} does"
        )
    share = timing.control_hz / changed.control_hz
    scenes = tuple(_paced(scene, share) for scene in file.scenes)
    update = {"timing": changed, "scene": scenes[0]}
    return replace(file, spec=file.spec.model_copy(update=update), scenes=scenes)


def _paced(scene: SceneSpec, share: float) -> SceneSpec:
    """Scale the action limits of a scene to another control rate, so that speeds stay the same.

    Args:
        scene: The scene of the task file.
        share: Duration of a control step, as a fraction of the task file's.
    """
    if share == 1.0:
        return scene

    def paced(robot: RobotEntry) -> RobotEntry:
        spec = robot.action
        limits = {"max_step": spec.max_step * share, "max_turn_deg": spec.max_turn_deg * share}
        return robot.model_copy(update={"action": spec.model_copy(update=limits)})

    robots = {name: paced(robot) for name, robot in scene.robots.items()}
    return scene.model_copy(update={"robots": frozen(robots)})
