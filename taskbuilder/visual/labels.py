"""Names on a picture, placed so that they can be read: none over another, or over the edge."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from taskbuilder.visual.still import INK, Pixels, text_width, write_text

_PAPER = (255, 255, 255)
_OPACITY = 0.86
_GAP = 2  # pixels between two labels
_DISTANCES = (9, 18, 30, 44, 60, 80, 104, 132)  # from a point to its label, in pixels at size 12
_FINE = 3  # outlines are drawn so many times larger, then averaged


@dataclass(frozen=True)
class Label:
    """A name for a point of a picture.

    Attributes:
        text: The name.
        point: Column and row.
        color: Of what it names, RGB.
        faded: Whether what it names is hidden.
    """

    text: str
    point: tuple[float, float]
    color: tuple[int, int, int]
    faded: bool = False


@dataclass(frozen=True)
class LabelBox:
    """The pixels of a label."""

    left: int
    top: int
    width: int
    height: int

    def overlap(self, other: LabelBox) -> int:
        """How many pixels two boxes share, with a gap around them."""
        across = min(self.left + self.width, other.left + other.width) - max(self.left, other.left)
        down = min(self.top + self.height, other.top + other.height) - max(self.top, other.top)
        return max(0, across + _GAP) * max(0, down + _GAP)

    def holds(self, point: tuple[float, float], margin: float) -> bool:
        """Whether a point is inside, or nearer than a margin."""
        x, y = point[0] - self.left, point[1] - self.top
        return -margin < x < self.width + margin and -margin < y < self.height + margin


def letter_size(shape: Sequence[int]) -> int:
    """The size of letters in a picture of (height, width, ...) pixels."""
    return max(9, min(26, round(min(shape[0], shape[1] * 0.75) / 40)))


def place_labels(labels: Sequence[Label], shape: Sequence[int]) -> list[LabelBox]:
    """A place for each label near its point, inside the picture, over no other where there is room.

    Args:
        labels: What to place.
        shape: Of the picture: height and width.
    """
    size = letter_size(shape)
    points = [label.point for label in labels]
    boxes: dict[int, LabelBox] = {}
    # From the top down: labels of crowded points then fan out instead of leaping over each other.
    for index in sorted(range(len(labels)), key=lambda i: (points[i][1], points[i][0])):
        others = points[:index] + points[index + 1 :]
        costs = [
            (_cost(box, points[index], others, boxes.values()), number, box)
            for number, box in enumerate(_candidates(labels[index], size, shape))
        ]
        boxes[index] = min(costs, key=lambda cost: cost[:2])[2]
    return [boxes[index] for index in range(len(labels))]


def _cost(
    box: LabelBox,
    point: tuple[float, float],
    others: Iterable[tuple[float, float]],
    placed: Iterable[LabelBox],
) -> float:
    """How bad a place is: over other labels, over other points, or far from its own."""
    clash = sum(box.overlap(other) for other in placed)
    covered = sum(box.holds(other, 3.0) for other in others)
    return 50.0 * clash + 60.0 * covered + _reach(box, point)


def draw_labels(picture: Pixels, labels: Sequence[Label]) -> None:
    """Write names on a picture, each with a thin line to its point where it is not beside it."""
    placed = list(zip(labels, place_labels(labels, picture.shape), strict=True))
    size = letter_size(picture.shape)
    for label, box in placed:
        _lead(picture, label, box)
    for label, box in placed:
        _plate(picture, box, label)
        bar = _bar(size)
        baseline = box.top + round(0.5 * box.height + 0.34 * size)
        ink = tuple(round(0.5 * part + 0.5 * 130) for part in INK) if label.faded else INK
        write_text(picture, label.text, (box.left + 2 * bar + 2, baseline), size, ink, 400)


def _bar(size: int) -> int:
    """Width of the coloured bar at the left of a label."""
    return max(2, round(size / 4))


def _candidates(label: Label, size: int, shape: Sequence[int]) -> Iterator[LabelBox]:
    width = text_width(label.text, size, 400) + 3 * _bar(size) + 3
    height = round(1.45 * size)
    column, row = label.point
    for distance in _DISTANCES:
        away = distance * size / 12
        for turn in range(16):
            angle = math.radians(-45 + 22.5 * turn)  # first to the upper right
            x, y = column + away * math.cos(angle), row + away * math.sin(angle)
            left = x - (0.5 - 0.5 * math.cos(angle)) * width
            top = y - (0.5 - 0.5 * math.sin(angle)) * height
            yield LabelBox(
                round(min(max(left, 2), max(2, shape[1] - width - 2))),
                round(min(max(top, 2), max(2, shape[0] - height - 2))),
                width,
                height,
            )


def _reach(box: LabelBox, point: tuple[float, float]) -> float:
    """Distance from a point to a box; less for a box above and to the right, where eyes look."""
    x, y = _nearest(box, point)
    side = 2.0 * (x < point[0]) + 2.0 * (y > point[1])
    inside = 40.0 * box.holds(point, 2.0)
    return math.hypot(x - point[0], y - point[1]) + side + inside


def _nearest(box: LabelBox, point: tuple[float, float]) -> tuple[float, float]:
    return (
        min(max(point[0], box.left), box.left + box.width - 1),
        min(max(point[1], box.top), box.top + box.height - 1),
    )


def _lead(picture: Pixels, label: Label, box: LabelBox) -> None:
    """A thin line from a label to its point, and a dot there."""
    target = _nearest(box, label.point)
    ends = np.array([target, label.point])

    def draw(mask: NDArray[np.uint8], fine: NDArray[np.int32]) -> None:
        cv2.line(mask, fine[0].tolist(), fine[1].tolist(), 255, _FINE, cv2.LINE_AA)
        cv2.circle(mask, fine[1].tolist(), round(1.8 * _FINE), 255, cv2.FILLED, cv2.LINE_AA)

    _blend(picture, ends, draw, label.color, 0.5 if label.faded else 0.9)


def _plate(picture: Pixels, box: LabelBox, label: Label) -> None:
    """A rounded plate of paper with a coloured bar."""
    corners = np.array([(box.left, box.top), (box.left + box.width, box.top + box.height)])
    radius = 3 * _FINE

    def plate(mask: NDArray[np.uint8], fine: NDArray[np.int32]) -> None:
        low, high = fine[0] + radius, fine[1] - radius
        cv2.rectangle(mask, low.tolist(), high.tolist(), 255, cv2.FILLED)
        cv2.rectangle(mask, low.tolist(), high.tolist(), 255, 2 * radius, cv2.LINE_AA)

    _blend(picture, corners, plate, _PAPER, 0.72 if label.faded else _OPACITY)
    bar = _bar(round(box.height / 1.45))
    ends = np.array([(box.left + bar, box.top + 4), (box.left + bar, box.top + box.height - 4)])

    def line(mask: NDArray[np.uint8], fine: NDArray[np.int32]) -> None:
        cv2.line(mask, fine[0].tolist(), fine[1].tolist(), 255, bar * _FINE, cv2.LINE_AA)

    _blend(picture, ends, line, label.color, 0.6 if label.faded else 1.0)


def _blend(
    picture: Pixels,
    points: NDArray[np.float64],
    draw: Callable[[NDArray[np.uint8], NDArray[np.int32]], None],
    color: tuple[int, int, int],
    opacity: float,
) -> None:
    """Draw something around points, smoothly, in a window of the picture."""
    margin = 8
    low = np.maximum(np.floor(points.min(axis=0)).astype(int) - margin, 0)
    high = np.minimum(
        np.ceil(points.max(axis=0)).astype(int) + margin, (picture.shape[1], picture.shape[0])
    )
    if (high <= low).any():
        return
    size = high - low
    mask = np.zeros((size[1] * _FINE, size[0] * _FINE), np.uint8)
    draw(mask, np.rint((points - low) * _FINE).astype(np.int32))
    share = cv2.resize(mask, size.tolist(), interpolation=cv2.INTER_AREA)[:, :, None]
    share = share * (opacity / 255.0)
    window = picture[low[1] : high[1], low[0] : high[0]]
    window[:] = np.rint(window * (1.0 - share) + np.array(color) * share)
