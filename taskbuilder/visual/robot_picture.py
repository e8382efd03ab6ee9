"""A picture of a robot, or of any URDF, alone."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

from taskbuilder.assets.model import Urdf
from taskbuilder.assets.urdf import resolved_text
from taskbuilder.cameras import STUDIO, CameraView
from taskbuilder.geometry import Pose, add, norm, scale
from taskbuilder.quiet import captured
from taskbuilder.sim.bodies import load_urdf
from taskbuilder.sim.client import Client
from taskbuilder.sim.engine_output import warnings
from taskbuilder.sim.pictures import capture
from taskbuilder.sim.probe import probe
from taskbuilder.visual.ink import Lens, Marks, drawn_over
from taskbuilder.visual.still import Pixels

_FROM = (0.72, -0.62, 0.32)  # from front right and above; robots look along +x
_FROM_ABOVE = (0.42, -0.62, 0.66)
_SIZE = (480, 480)


def take_robot_picture(
    urdf: Urdf,
    joints: Mapping[str, float],
    *,
    trusted: bool,
    marks: Marks | None = None,
    room_m: float = 0.0,
) -> tuple[Pixels, tuple[str, ...]]:
    """Load a URDF, pose it and take its picture.

    Args:
        urdf: A description that has been checked.
        joints: Joint positions in rad or m; the others stay at zero.
        trusted: Do without the probe in a child process.
        marks: What to draw over it.
        room_m: Show so much around the base, from higher up, in metres; by default the robot alone.

    Returns:
        The picture, (480, 480, 3) uint8 RGB, and what the engine warned of.

    Raises:
        AssetError: The engine dies of the asset, or refuses it.
        SimulationError: The asset cannot be loaded.
    """
    with (
        tempfile.TemporaryDirectory(prefix="taskbuilder-") as folder,
        Client(physics_hz=120) as client,
    ):
        copy = Path(folder) / urdf.path.name
        copy.write_text(resolved_text(urdf), encoding="utf-8")
        if not trusted:
            probe(copy, kind="urdf")
        with captured() as printed:
            body = load_urdf(client, copy, name=urdf.name, pose=Pose(), fixed_base=True)
        body.put_joints(joints)
        extent = body.occupied()
        center, away = extent.center, _FROM
        distance = max(2.9 * norm(extent.half), 0.05)
        if room_m:
            center, away, distance = (0.0, 0.0, 0.15 * room_m), _FROM_ABOVE, 2.2 * room_m
        eye = add(center, scale(away, distance))
        view = CameraView(
            eye, center, fov_deg=42, width=_SIZE[0], height=_SIZE[1], far=20 + 2 * distance
        )
        picture = capture(client, view, supersample=2, shadow=True, backdrop=STUDIO)
    if marks is not None:
        lens = Lens(view.extrinsics, picture.intrinsics, picture.depth)
        return drawn_over(picture.rgb, lens, marks), warnings(printed.text)
    return picture.rgb, warnings(printed.text)
