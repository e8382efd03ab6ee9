"""Drawing over a finished picture: lines, areas and labels at points of the world.

All that is needed is the picture, its depth and the camera's matrices. What something in the
picture hides is drawn too, but faded.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from taskbuilder.visual.labels import Label, draw_labels, letter_size
from taskbuilder.visual.still import Pixels

Points = NDArray[np.float64]
Rgb = tuple[int, int, int]

FADED = 0.4
"""Opacity of a hidden line, as a fraction of a visible one's."""

TOLERANCE_M = 0.012
"""How far behind the picture's surface something may be and still count as visible."""

_BEHIND_M = 0.08  # a name is faded if its point is so far behind; inside an object it is not
_NEAR_M = 0.03  # nothing nearer to the camera is drawn
_PIECE_PX = 7.0  # lines are tested and faded in pieces of about this length
_PIECES = 160  # of a line, at most
_FINE = 2  # ink is drawn so many times larger, then averaged
_SHIFT = 4  # fractional bits of OpenCV's coordinates
_CASING: Rgb = (255, 255, 255)


@dataclass(frozen=True)
class Lens:
    """The camera that took a picture.

    Attributes:
        extrinsics: (4, 4) from the world to the camera (x right, y down, z forward).
        intrinsics: (3, 3) from the camera to pixels (column, row), times depth.
        depth: (height, width) metres along the camera's z.
    """

    extrinsics: Points
    intrinsics: Points
    depth: NDArray[np.float32]

    def to_camera(self, points: Points) -> Points:
        """(n, 3) points of the world in the camera's frame."""
        moved: Points = points @ self.extrinsics[:3, :3].T + self.extrinsics[:3, 3]
        return moved

    def to_pixels(self, in_camera: Points) -> Points:
        """(n, 2) columns and rows of points in front of the camera."""
        seen = in_camera @ self.intrinsics.T
        pixels: Points = seen[:, :2] / seen[:, 2:]
        return pixels

    def hides(
        self, pixels: Points, distance: Points, tolerance: float = TOLERANCE_M
    ) -> NDArray[np.bool_]:
        """(n,) whether something in the picture is before points at these depths, in metres."""
        height, width = self.depth.shape
        columns = np.clip(np.rint(pixels[:, 0]), 0, width - 1).astype(int)
        rows = np.clip(np.rint(pixels[:, 1]), 0, height - 1).astype(int)
        hidden: NDArray[np.bool_] = self.depth[rows, columns] < distance - tolerance
        return hidden


@dataclass(frozen=True)
class Stroke:
    """A line through points of the world.

    Attributes:
        points: (n, 3) m.
        color: Red, green, blue, 0 to 255.
        width: In pixels, in a picture of 800 x 600.
        closed: Whether the last point is joined to the first.
    """

    points: Points
    color: Rgb
    width: float = 1.6
    closed: bool = False


@dataclass(frozen=True)
class Patch:
    """A translucent area in a plane of the world.

    Attributes:
        rings: (n, 3) outlines; a ring inside another one is a hole.
        color: Red, green, blue, 0 to 255.
        opacity: From 0 to 1.
    """

    rings: tuple[Points, ...]
    color: Rgb
    opacity: float = 0.2


@dataclass(frozen=True)
class Tag:
    """A name at a point of the world.

    Attributes:
        text: The name.
        point: (3,) m.
        color: Of what it names.
    """

    text: str
    point: Points
    color: Rgb


@dataclass(frozen=True)
class Marks:
    """What is drawn over a picture: areas, then lines, then names."""

    patches: tuple[Patch, ...] = ()
    strokes: tuple[Stroke, ...] = ()
    tags: tuple[Tag, ...] = ()

    def __add__(self, other: Marks) -> Marks:
        """Both."""
        return Marks(
            self.patches + other.patches, self.strokes + other.strokes, self.tags + other.tags
        )


def drawn_over(picture: Pixels, lens: Lens, marks: Marks) -> Pixels:
    """A copy of a picture with marks drawn over it.

    Args:
        picture: (height, width, 3) RGB.
        lens: The camera that took it.
        marks: What to draw.
    """
    sheet = _Sheet(picture)
    scale = letter_size(picture.shape) / 15  # lines are as wide as letters are large
    for patch in marks.patches:
        _fill(sheet, lens, patch)
    visible: list[tuple[NDArray[np.int64], Stroke]] = []
    for faded in (True, False):  # what is visible is drawn last, over all that is hidden
        for stroke in marks.strokes:
            for line, hidden in _pieces(lens, stroke):
                if hidden and faded:
                    sheet.line(line, stroke.color, scale * stroke.width, FADED)
                elif not hidden and not faded:
                    sheet.line(line, _CASING, scale * stroke.width + 1.4, 0.5)
                    visible.append((line, stroke))
    for line, stroke in visible:
        sheet.line(line, stroke.color, scale * stroke.width, 1.0)
    done = sheet.finished()
    draw_labels(done, _labels(lens, marks.tags))
    return done


class _Sheet:
    """Ink over a picture, drawn finer than the picture and then averaged."""

    def __init__(self, picture: Pixels) -> None:
        self._picture = picture.astype(np.float32)
        height, width = picture.shape[:2]
        self._ink = np.zeros((height * _FINE, width * _FINE, 3), np.float32)  # times opacity
        self._opacity = np.zeros((height * _FINE, width * _FINE), np.float32)

    def line(self, pixels: NDArray[np.int64], color: Rgb, width: float, opacity: float) -> None:
        """Draw a line through (n, 2) pixels of the finer sheet, in 1/16."""
        broad = max(1, round(width * _FINE))
        ink = tuple(opacity * part for part in color)
        for sheet, value in ((self._ink, ink), (self._opacity, (opacity,))):
            cv2.polylines(sheet, [pixels.astype(np.int32)], False, value, broad, shift=_SHIFT)

    def area(self, mask: NDArray[np.float32], color: Rgb) -> None:
        """Add a translucent area; the mask has the picture's size and values from 0 to 1."""
        mask = mask[:, :, None]
        self._picture = self._picture * (1.0 - mask) + mask * np.array(color, np.float32)

    def finished(self) -> Pixels:
        """The picture under the ink."""
        size = (self._picture.shape[1], self._picture.shape[0])
        ink = cv2.resize(self._ink, size, interpolation=cv2.INTER_AREA)
        opacity = cv2.resize(self._opacity, size, interpolation=cv2.INTER_AREA)
        mixed = self._picture * (1.0 - opacity[:, :, None]) + ink
        return np.clip(np.rint(mixed), 0, 255).astype(np.uint8)


def _fine(pixels: Points) -> NDArray[np.int64]:
    """Pixels of the picture as those of the finer sheet, in 1/16."""
    fine = (pixels + 0.5) * _FINE - 0.5
    numbers: NDArray[np.int64] = np.rint(np.clip(fine, -30_000, 30_000) * 2**_SHIFT).astype(
        np.int64
    )
    return numbers


def _pieces(lens: Lens, stroke: Stroke) -> Iterator[tuple[NDArray[np.int64], bool]]:
    """Parts of a line that are visible or hidden throughout: their pixels, and whether hidden."""
    points = lens.to_camera(np.asarray(stroke.points, dtype=np.float64))
    if stroke.closed:
        points = np.vstack([points, points[:1]])
    run: list[Points] = []
    was_hidden = False
    for start, end in pairwise(points):
        pixels, hidden = _sampled(lens, start, end)
        for index, one in enumerate(hidden):
            if run and bool(one) != was_hidden:
                yield _fine(np.array(run)), was_hidden
                run = []
            was_hidden = bool(one)
            run = run or [pixels[index]]
            run.append(pixels[index + 1])
        if not len(hidden) and run:  # behind the camera
            yield _fine(np.array(run)), was_hidden
            run = []
    if run:
        yield _fine(np.array(run)), was_hidden


def _sampled(lens: Lens, start: Points, end: Points) -> tuple[Points, NDArray[np.bool_]]:
    """A straight line in pieces: (k + 1, 2) their ends, and (k,) whether each is hidden."""
    nothing = np.zeros((0, 2)), np.zeros(0, dtype=bool)
    clipped = _in_front(start, end)
    if clipped is None:
        return nothing
    ends = np.array(clipped)
    first, last = lens.to_pixels(ends)
    length = float(np.hypot(*(last - first)))
    count = int(np.clip(np.ceil(length / _PIECE_PX), 1, _PIECES))
    # Even in the picture: along a line, 1/z changes evenly.
    share = np.linspace(0.0, 1.0, 2 * count + 1)
    near, far = 1.0 / ends[0, 2], 1.0 / ends[1, 2]
    pixels = first + share[:, None] * (last - first)
    distance = 1.0 / (near + share * (far - near))
    return pixels[::2], lens.hides(pixels[1::2], distance[1::2])


def _in_front(start: Points, end: Points) -> tuple[Points, Points] | None:
    """The part of a line that is in front of the camera, or None."""
    if start[2] < _NEAR_M and end[2] < _NEAR_M:
        return None
    if min(start[2], end[2]) < _NEAR_M:
        share = (_NEAR_M - start[2]) / (end[2] - start[2])
        cut = start + share * (end - start)
        return (cut, end) if start[2] < _NEAR_M else (start, cut)
    return start, end


def _fill(sheet: _Sheet, lens: Lens, patch: Patch) -> None:
    """Tint the pixels of an area, less where it is hidden."""
    rings = [_clipped(lens.to_camera(ring)) for ring in patch.rings]
    outlines = [lens.to_pixels(ring) for ring in rings if len(ring) > 2]
    if not outlines:
        return
    height, width = lens.depth.shape
    mask = np.zeros((height, width), np.uint8)
    scaled = [np.clip(o * 2**_SHIFT, -(2**20), 2**20).astype(np.int32) for o in outlines]
    cv2.fillPoly(mask, scaled, 255, cv2.LINE_AA, _SHIFT)
    distance = _depth_of_plane(lens, rings[0])
    hidden = lens.depth < distance - TOLERANCE_M
    share = cv2.GaussianBlur(np.where(hidden, FADED, 1.0).astype(np.float32), (3, 3), 0.8)
    tint = share * (mask / 255.0) * patch.opacity
    sheet.area(tint.astype(np.float32), patch.color)


def _clipped(ring: Points) -> Points:
    """The part of an outline that is in front of the camera."""
    kept: list[Points] = []
    for start, end in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        part = _in_front(start, end)
        if part is not None:
            kept += part
    return np.array(kept).reshape(-1, 3)


def _depth_of_plane(lens: Lens, ring: Points) -> NDArray[np.float32]:
    """(height, width) depth of the plane through a ring, given in the camera's frame."""
    center = ring.mean(axis=0)
    normal = np.linalg.svd(ring - center)[2][-1]
    height, width = lens.depth.shape
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    rays = np.stack([columns, rows, np.ones_like(rows)], axis=-1) @ np.linalg.inv(lens.intrinsics).T
    facing = rays @ normal
    facing = np.where(np.abs(facing) < 1e-9, 1e-9, facing)
    depth: NDArray[np.float32] = (float(center @ normal) / facing).astype(np.float32)
    return depth


def _labels(lens: Lens, tags: Sequence[Tag]) -> list[Label]:
    """The names whose points are in the picture."""
    if not tags:
        return []
    height, width = lens.depth.shape
    labels = []
    for tag, point in zip(tags, lens.to_camera(np.array([t.point for t in tags])), strict=True):
        if point[2] < _NEAR_M:
            continue
        pixels = lens.to_pixels(point[None])
        column, row = pixels[0].tolist()
        if 0 <= column < width and 0 <= row < height:
            hidden = bool(lens.hides(pixels, point[2:], _BEHIND_M)[0])
            labels.append(Label(tag.text, (column, row), tag.color, faded=hidden))
    return labels
