"""Shooting: pictures of an episode at an even rate, also between its control steps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.rollout.play import replaying
from taskbuilder.rollout.record import Rollout
from taskbuilder.visual.still import SUPERSAMPLE, Pixels
from taskbuilder.world.pictures import capture
from taskbuilder.world.world import World

FPS = 24

_CONTRAST = 12
"""Neighbouring pixels that differ by more, of 255, are an edge, and are smoothed."""


@dataclass(frozen=True)
class Frame:
    """A moment of an episode, as cameras see it.

    Attributes:
        seconds: Since the episode began.
        step: Control steps that had passed, the present one not counted.
        pictures: (height, width, 3) RGB of each camera.
    """

    seconds: float
    step: int
    pictures: Mapping[str, Pixels]


def capture_frames(
    env: TaskEnv,
    rollout: Rollout,
    cameras: Sequence[str],
    *,
    size: tuple[int, int] | None = None,
    fps: int = FPS,
) -> Iterator[Frame]:
    """Replay an episode, and take pictures on the way.

    The episode goes as it went, to the bit. The last frame is of its last moment, and may follow
    the one before sooner than the others.

    Args:
        env: As for `replay`.
        rollout: The episode.
        cameras: Of the scene.
        size: Width and height of each picture; by default each camera's own.
        fps: Frames a simulated second.

    Raises:
        UsageError: The environment is of another task, or has fewer physics steps than frames.
        UnknownNameError: The scene has no such camera.
    """
    steps = replaying(env, rollout)
    next(steps)  # the reset
    world = env.episode.world
    rate = world.spec.timing.physics_hz
    if not 1 <= fps <= rate:
        raise UsageError(f"fps is {fps}; from 1 to the {rate} physics steps a second")
    substeps = world.spec.timing.substeps
    taken: list[Frame] = []

    def look(steps: int) -> None:
        world.refresh()
        pictures = {camera: take_picture(world, camera, size) for camera in cameras}
        taken.append(Frame(steps / rate, steps // substeps, pictures))

    def looks() -> Iterator[None]:
        steps = 0
        while True:
            if steps * fps % rate < fps:  # the first physics step at or after the next frame
                look(steps)
            steps += 1
            yield

    world.onlooker = looks()
    try:
        for _ in steps:
            if env.episode.exploded:
                return
            yield from taken
            taken.clear()
    finally:
        world.onlooker = None
    look(rollout.steps * substeps)
    yield from taken


def take_picture(world: World, camera: str, size: tuple[int, int] | None = None) -> Pixels:
    """A picture for a film: lit, with shadows, and with smooth edges at little cost.

    Drawing at twice the size and averaging looks no better at the size of a film, and takes
    Bullet's own renderer four times as long; a graphics processor hardly notices.

    Args:
        world: The world as it stands, `refresh`ed.
        camera: A camera of the scene.
        size: Width and height in pixels; by default the camera's own.

    Raises:
        UnknownNameError: The scene has no such camera.
    """
    world.move_markers()
    fast = world.client.renderer == "egl"
    image = capture(
        world,
        world.camera(camera, size),
        studio=True,
        supersample=SUPERSAMPLE if fast else 1,
        shadow=world.scene.cameras[camera].mount is None,
    )
    return image.rgb if fast else _smoothed(image.rgb)


def _smoothed(picture: Pixels) -> Pixels:
    """The picture with its edges, and nothing else, slightly blurred."""
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    contrast = cv2.cvtColor(
        cv2.morphologyEx(picture, cv2.MORPH_GRADIENT, cross), cv2.COLOR_RGB2GRAY
    )
    edges = (contrast > _CONTRAST).astype(np.uint8)
    return cv2.copyTo(cv2.GaussianBlur(picture, (3, 3), 0.7), edges, picture.copy()).astype(
        np.uint8
    )
