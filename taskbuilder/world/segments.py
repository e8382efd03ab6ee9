"""The numbers and names in segmentation masks of a scene."""

from __future__ import annotations

from collections.abc import Mapping

from taskbuilder.sim.body import BASE, Body
from taskbuilder.sim.pictures import Segments
from taskbuilder.world.robot import Robot
from taskbuilder.world.scene_objects import SceneObject, Site

FLOOR = "world.floor"


def segments_of(
    robots: Mapping[str, Robot],
    objects: Mapping[str, SceneObject],
    sites: Mapping[str, Site],
    floor: Body | None,
) -> Segments:
    """The segments of a scene, such as ``left.wrist_3_link`` or ``tray.rim``.

    They follow from the task alone: the background, the floor, the links of the robots, the objects
    with their parts or links, and the markers of the sites, in the order of the files.
    """
    parts: list[tuple[str, int, int]] = []
    if floor is not None:
        parts.append((FLOOR, floor.id, BASE))
    for name, robot in robots.items():
        links = robot.body.links.items()
        parts += [(f"{name}.{link}", robot.body.id, index) for link, index in links]
    for name, thing in objects.items():
        whole = thing.spec.parts is None and thing.spec.urdf is None
        parts += [
            (name if whole else f"{name}.{link}", thing.body.id, index)
            for link, index in thing.body.links.items()
        ]
    parts += [(name, site.marker.id, BASE) for name, site in sites.items() if site.marker]
    return Segments(parts)
