"""Pictures of a world, in the light of the episode and with masks that name what they show."""

from __future__ import annotations

from taskbuilder.cameras import CameraView, Image
from taskbuilder.sim import pictures
from taskbuilder.world.world import World


def capture(
    world: World,
    view: CameraView,
    *,
    studio: bool = False,
    shadow: bool = False,
    supersample: int = 1,
) -> Image:
    """Take a picture of a world as it stands.

    Args:
        world: The world. Call its `move_markers` first, once for all pictures of a moment.
        view: Where the camera is, and what it takes in; see `World.camera`.
        studio: Whether there is always a backdrop, as in pictures for people.
        shadow: Whether things cast shadows; about twice the time.
        supersample: Draw this many times larger and average: smooth edges, for stills.

    Raises:
        SimulationError: The picture would be larger than 4096 pixels a side.
    """
    look = world.look
    return pictures.capture(
        world.client,
        view,
        world.segments,
        light=look.light,
        backdrop=look.studio if studio else look.backdrop,
        shadow=shadow,
        supersample=supersample,
    )
