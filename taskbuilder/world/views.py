"""What the cameras of a scene look at, fixed or on their mounts."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from taskbuilder.errors import UnknownNameError
from taskbuilder.geometry import Pose, dot, norm, subtract
from taskbuilder.schema.scene import CameraSpec
from taskbuilder.sim.cameras import CameraView
from taskbuilder.wording import suggestion


def view_of(
    cameras: Mapping[str, CameraSpec],
    name: str,
    pose: Callable[[str], Pose],
    size: tuple[int, int] | None = None,
) -> CameraView:
    """The current view of a named camera.

    Args:
        cameras: The cameras of the scene.
        name: One of them.
        pose: Gives the pose of a named frame in the world.
        size: Width and height in pixels; by default its own.

    Raises:
        UnknownNameError: The scene has no such camera.
    """
    if name not in cameras:
        help_ = suggestion(name, cameras, what="there are")
        raise UnknownNameError(f'no camera "{name}"; {help_}')
    spec = cameras[name]
    mount = pose(spec.mount) if spec.mount else Pose()
    width, height = size or spec.size
    eye, aim = mount.apply(spec.eye), mount.apply(spec.aim)
    up = mount.axis(2)
    sight = subtract(aim, eye)
    if abs(dot(sight, up)) > 0.999 * norm(sight):  # straight along z
        up = mount.axis(0 if spec.mount else 1)
    return CameraView(eye, aim, up, spec.fov_deg, width, height)
