"""Smooth outlines of what an arm reaches."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from taskbuilder.world.reach import ReachMap

_FINER = 6  # how many times finer the outline is than the points that were tried


def outlines(found: ReachMap) -> tuple[NDArray[np.float64], ...]:
    """Smooth (n, 3) outlines of what is reached; one inside another one is a hole."""
    padded = np.pad(found.reached.astype(np.float32), 1, mode="edge")
    rows, columns = (side * _FINER for side in padded.shape)
    fine = cv2.resize(padded, (columns, rows), interpolation=cv2.INTER_CUBIC)
    fine = cv2.GaussianBlur(fine, (0, 0), 0.9 * _FINER)
    # Of the padding, nothing is kept: the rectangle ends at its outermost points.
    cut = round(1.5 * _FINER)
    inside = np.pad((fine[cut:-cut, cut:-cut] > 0.5).astype(np.uint8), 1)
    contours, _ = cv2.findContours(inside, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    step = np.array(found.spacing) / _FINER
    rings = []
    for contour in contours:
        if len(contour) < 3 * _FINER:
            continue
        at = (_smoothed(contour[:, 0, :].astype(np.float64)) - 0.5) * step
        rings.append(np.column_stack([at + found.low[:2], np.full(len(at), found.low[2])]))
    return tuple(rings)


def _smoothed(ring: NDArray[np.float64]) -> NDArray[np.float64]:
    """A closed (n, 2) outline without the stairs of pixels, with fewer points."""
    width = 2 * _FINER + 1
    weights = np.hanning(width + 2)[1:-1]
    weights /= weights.sum()
    around = np.pad(ring, ((_FINER, _FINER), (0, 0)), mode="wrap")
    smooth = np.column_stack([np.convolve(around[:, i], weights, mode="valid") for i in (0, 1)])
    return smooth[:: max(1, _FINER // 3)]
