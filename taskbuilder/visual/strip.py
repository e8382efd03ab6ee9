"""The film strip: an episode on one page."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from taskbuilder.cameras import LARGEST_SIDE
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.rollout.play import replay
from taskbuilder.rollout.record import Rollout
from taskbuilder.visual.keyframes import caption, keyframes
from taskbuilder.visual.overlay import GREEN
from taskbuilder.visual.still import (
    GRAY,
    INK,
    PAPER,
    SUPERSAMPLE,
    Pixels,
    page,
    take_still,
    text_width,
    write_text,
)

_COLUMNS = 4
_WIDTH, _WIDTH_OF_MANY = 400, 260
_CAPTION = 34
_SIZE = 14  # of letters


def shown_cameras(env: TaskEnv, cameras: Sequence[str]) -> list[str]:
    """The cameras that are asked for, each once; the first of the scene if none is."""
    return list(dict.fromkeys(cameras)) or [next(iter(env.episode.world.scene.cameras))]


def film_strip(
    env: TaskEnv,
    rollout: Rollout,
    cameras: Sequence[str],
    *,
    subtitle: str,
    size: tuple[int, int] | None = None,
) -> Pixels:
    """Replay an episode, and put its key moments on a page.

    Those of one camera in rows of four; of several, in a row for each.

    Args:
        env: As for `replay`.
        rollout: The episode.
        cameras: Of the scene, each once; by default the first.
        subtitle: Below the task's name.
        size: Width and height in which pictures are taken; by default as they are shown.

    Raises:
        UsageError: The environment is of another task.
        UnknownNameError: The scene has no such camera.
    """
    moments, cameras = keyframes(rollout), shown_cameras(env, cameras)
    columns = len(moments) if len(cameras) > 1 else min(_COLUMNS, len(moments))
    width = _WIDTH if columns <= _COLUMNS else _WIDTH_OF_MANY
    taken: dict[tuple[str, int], Pixels] = {}

    def take(played: TaskEnv) -> None:
        step = played.episode.steps
        if step in moments and not played.episode.exploded:
            world = played.episode.world
            for camera in cameras:
                shape = size or fitting(world.scene.cameras[camera].size, width)
                taken[camera, step] = take_still(world, camera, shape).image.rgb

    replay(env, rollout, take)
    rows = []
    for camera in cameras:
        tiles = []
        for step in moments:
            name = camera if len(cameras) > 1 and step == moments[0] else ""
            tiles.append(_tile(taken[camera, step], width, rollout, step, name))
        rows += [tiles[start : start + columns] for start in range(0, len(tiles), columns)]
    return page(env.task.name, subtitle, rows, width)


def fitting(size: tuple[int, int], width: int) -> tuple[int, int]:
    """A width, and the height that keeps a size's proportions as far as it can be drawn."""
    return width, min(max(1, round(width * size[1] / size[0])), LARGEST_SIDE // SUPERSAMPLE)


def _tile(picture: Pixels, width: int, rollout: Rollout, step: int, camera: str) -> Pixels:
    """A picture above the time, and what was achieved just then."""
    shape = fitting((picture.shape[1], picture.shape[0]), width)
    shown = cv2.resize(picture, shape, interpolation=cv2.INTER_AREA)
    below = np.full((_CAPTION, width, 3), PAPER, dtype=np.uint8)
    left = 0
    for text, color, weight in (
        (f"{rollout.seconds(step):.1f} s", GRAY, 400),
        *((said, GREEN if said == "success" else INK, 600) for said in caption(rollout, step)),
    ):
        write_text(below, text, (left, 20), _SIZE, color, weight)
        left += text_width(text, _SIZE, weight) + 10
    room = width - text_width(camera, _SIZE, 400)
    if camera and left <= room:
        write_text(below, camera, (room, 20), _SIZE, GRAY, 400)
    return np.vstack([shown, below]).astype(np.uint8)
