"""Where a camera of the scene is, and what it takes in."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from taskbuilder.cameras import CameraView
from taskbuilder.errors import UnknownNameError
from taskbuilder.geometry import Pose, Vec3, add, norm, rotate, subtract, turn_onto
from taskbuilder.schema.camera import CameraSpec
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
    eye, aim = add(spec.eye, change.eye), add(spec.aim, change.aim)
    turn = turn_onto(subtract(spec.aim, spec.eye), subtract(aim, eye))
    up = rotate(mount.quaternion, rotate(turn, _up(spec)))
    fov_deg = min(spec.fov_deg * change.zoom, WIDEST_DEG)
    return CameraView(
        mount.apply(eye), mount.apply(aim), up, fov_deg, width, height, spec.near, spec.far_plane
    )


def _up(spec: CameraSpec) -> Vec3:
    """What points up in the pictures of a camera, in its frame.

    It is chosen for the camera as written. A randomised camera turns no further than its line of
    sight does; if up were chosen again, a camera that looks nearly straight down could turn about
    its line of sight by any angle.
    """
    sight = subtract(spec.aim, spec.eye)
    if abs(sight[2]) <= 0.999 * norm(sight):
        return (0.0, 0.0, 1.0)
    return (1.0, 0.0, 0.0) if spec.mount else (0.0, 1.0, 0.0)
