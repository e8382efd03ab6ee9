"""Where a camera of the scene is, and what it takes in."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from taskbuilder.errors import UnknownNameError
from taskbuilder.geometry import Pose, add, dot, norm, subtract
from taskbuilder.schema.camera import CameraSpec
from taskbuilder.sim.cameras import CameraView
from taskbuilder.wording import suggestion
from taskbuilder.world.looks import CameraChange, Look

WIDEST_DEG = 150.0


def camera_view(
    cameras: Mapping[str, CameraSpec],
    name: str,
    pose: Callable[[str], Pose],
    look: Look,
    size: tuple[int, int] | None = None,
) -> CameraView:
    """The view of a camera.

    Args:
        cameras: The cameras of the scene.
        name: One of them.
        pose: Gives the pose of a named frame in the world.
        look: The look of the episode.
        size: Width and height in pixels; by default the camera's own.

    Raises:
        UnknownNameError: The scene has no such camera.
    """
    if name not in cameras:
        help_ = suggestion(name, cameras, what="there are")
        raise UnknownNameError(f'no camera "{name}"; {help_}')
    spec, change = cameras[name], look.cameras.get(name, CameraChange())
    mount = pose(spec.mount) if spec.mount else Pose()
    width, height = size or spec.size
    eye, aim = mount.apply(add(spec.eye, change.eye)), mount.apply(add(spec.aim, change.aim))
    up = mount.axis(2)
    sight = subtract(aim, eye)
    if abs(dot(sight, up)) > 0.999 * norm(sight):  # straight along z
        up = mount.axis(0 if spec.mount else 1)
    fov_deg = min(spec.fov_deg * change.zoom, WIDEST_DEG)
    return CameraView(eye, aim, up, fov_deg, width, height)
