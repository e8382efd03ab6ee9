"""Frames, grasp points, sites, regions and reach, as lines and labels in the page's scene."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from taskbuilder.visual.annotations import SHOWN
from taskbuilder.visual.ink import Marks, Stroke
from taskbuilder.world.world import World

WORDS = tuple(word for word in SHOWN if word != "cameras")
"""What can be switched on and off, apart from cameras."""


def marks_of(world: World, word: str) -> Marks:
    """What one word of `WORDS` draws of a world as it stands.

    Frames are drawn for a camera, whose own mount is left out; the page has no camera of its own,
    so those of the first that is not mounted on a robot are taken.
    """
    cameras = world.scene.cameras
    free = next((name for name, camera in cameras.items() if not camera.mount), next(iter(cameras)))
    return SHOWN[word](world, free)


def segments(marks: Marks) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """The strokes of marks as (n, 2, 3) line segments in metres, and their (n, 2, 3) colours."""
    lines, colors = [], []
    for stroke in marks.strokes:
        for pair in _pairs(stroke):
            lines.append(pair)
            colors.append((stroke.color, stroke.color))
    return (
        np.array(lines, np.float32).reshape(-1, 2, 3),
        np.array(colors, np.uint8).reshape(-1, 2, 3),
    )


def _pairs(stroke: Stroke) -> Iterator[NDArray[np.float64]]:
    points = np.vstack([stroke.points, stroke.points[:1]]) if stroke.closed else stroke.points
    yield from map(np.array, pairwise(points))
