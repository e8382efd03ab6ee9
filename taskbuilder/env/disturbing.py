"""Disturbances of an environment: what a task can have, and the layout of one that has it."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from taskbuilder.env.actions import can_be_planned
from taskbuilder.errors import UsageError
from taskbuilder.schema.disturbances import AXES, Disturbances
from taskbuilder.schema.load import TaskFile
from taskbuilder.schema.placing import Place, Placed
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.values import frozen
from taskbuilder.sim.renderers import Request, choose

_Placed = TypeVar("_Placed", bound=Placed)


def with_disturbances(file: TaskFile, disturbances: Disturbances, renderer: Request) -> TaskFile:
    """Check that a task can have disturbances, and change what they change in its file: the layout.

    Raises:
        UsageError: It cannot have one of them.
    """
    for name, _ in disturbances:
        if why := inapplicable(name, file, renderer):
            raise UsageError(f"the disturbance {name} does not apply: {why}")
    level = dict(disturbances).get("layout", 0.0)
    if not level:
        return file
    scenes = tuple(_wider(scene, 1.0 + level) for scene in file.scenes)
    spec = file.spec.model_copy(update={"scene": scenes[0]})
    return replace(file, spec=spec, scenes=scenes)


def inapplicable(axis: str, file: TaskFile, renderer: Request = "auto") -> str:
    """Why a task cannot have a disturbance, or "" if it can.

    Args:
        axis: Name of the disturbance.
        file: The task file.
        renderer: Renderer of the pictures that policies observe.
    """
    scene, name = file.spec.scene, file.entry.name
    if axis == "layout" and not any(
        map(_is_random, (*scene.objects.values(), *scene.sites.values()))
    ):
        return f"{name} places nothing at random"
    if axis in ("mass", "friction") and all(each.fixed for each in scene.objects.values()):
        return f"{name} has no movable object"
    if axis == "gains" and not any(can_be_planned(robot.action) for robot in scene.robots.values()):
        return f"the arms of {name} are commanded by torques, which have no gains"
    if axis == "instruction" and not file.spec.instructions:
        return f"{name} has no instructions"
    if AXES[axis].reads in ("pictures", "colours") and not scene.cameras:
        return f"{name} has no camera"
    if axis == "distractors" and choose(renderer) != "raster":
        return f"the renderer {choose(renderer)} draws no distractors; raster does"
    return ""


def _is_random(placed: Placed) -> bool:
    place = placed.place
    return place is not None and (any(place.size) or place.yaw_deg[0] < place.yaw_deg[1])


def _wider(scene: SceneSpec, factor: float) -> SceneSpec:
    """A scene whose regions are larger about their centres."""
    objects = {name: _placed_wider(each, factor) for name, each in scene.objects.items()}
    sites = {name: _placed_wider(each, factor) for name, each in scene.sites.items()}
    return scene.model_copy(update={"objects": frozen(objects), "sites": frozen(sites)})


def _placed_wider(placed: _Placed, factor: float) -> _Placed:
    if placed.place is None:
        return placed
    return placed.model_copy(update={"place": _widened(placed.place, factor)})


def _widened(place: Place, factor: float) -> Place:
    low, high = place.yaw_deg
    middle, half = (low + high) / 2.0, (high - low) / 2.0 * factor
    update = {
        "size": tuple(factor * side for side in place.size),
        "yaw_deg": (middle - half, middle + half),
    }
    return place.model_copy(update=update)
