"""The overlay below the pictures of a film: how far the episode is and what has been achieved."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import cv2
import numpy as np

from taskbuilder.rollout.record import Rollout
from taskbuilder.visual.capture import Frame
from taskbuilder.visual.still import GRAY, INK, PAPER, Pixels, text_width, write_text

GREEN, RED, PALE = (22, 128, 72), (186, 48, 40), (222, 218, 213)

_BAR, _LINE, _GAP = 4, 28, 8  # heights of the bar and of a line of words; between pictures
_SIZE = 13  # of letters
_DOT, _AFTER_DOT, _AFTER_NAME = 9, 5, 14  # widths
_EDGE = 10

LOST = "success lost"
"""Said of an episode that had reached success, while success does not hold."""


def compose(frame: Frame, rollout: Rollout) -> Pixels:
    """The pictures of a frame side by side, with the overlay below; width and height are even.

    Args:
        frame: What the cameras saw.
        rollout: The same episode.
    """
    several = len(frame.pictures) > 1
    height = max(picture.shape[0] for picture in frame.pictures.values())
    columns: list[Pixels] = []
    for camera, picture in frame.pictures.items():
        column = np.full((height, picture.shape[1] + _GAP * bool(columns), 3), PAPER, np.uint8)
        column[: picture.shape[0], -picture.shape[1] :] = picture
        if several:
            _name(column, camera, column.shape[1] - picture.shape[1])
        columns.append(column)
    pictures = np.hstack(columns)
    whole = np.vstack([pictures, overlay(rollout, frame, pictures.shape[1])])
    odd = [(0, length % 2) for length in whole.shape[:2]]
    return np.pad(whole, [*odd, (0, 0)], mode="edge").astype(np.uint8)


def overlay(rollout: Rollout, frame: Frame, width: int) -> Pixels:
    """A bar that fills as the episode passes, the stages, which light up, and the time."""
    word, color = _verdict(rollout, frame.step)
    length = rollout.seconds(rollout.horizon)
    right = width - _EDGE - text_width(f"{length:.1f} s", _SIZE, 400)
    room = right - _EDGE - _AFTER_NAME - text_width(LOST, _SIZE, 600)
    lines = _lines(rollout.stages, room)
    drawn = np.full((_BAR + _LINE * max(len(lines), 1), width, 3), PAPER, dtype=np.uint8)
    drawn[:_BAR] = PALE
    drawn[:_BAR, : ceil(width * min(1.0, frame.seconds / length))] = color
    number = 0
    for row, stages in enumerate(lines):
        left, base = _EDGE, _BAR + _LINE * row + 19
        for stage in stages:
            number += 1
            left = _stage(drawn, stage, (left, base), reached=number <= rollout.stage[frame.step])
    write_text(drawn, f"{frame.seconds:.1f} s", (right, _BAR + 19), _SIZE, GRAY, 400)
    if word:
        left = right - _AFTER_NAME - text_width(word, _SIZE, 600)
        write_text(drawn, word, (left, _BAR + 19), _SIZE, color, 600)
    return drawn


def _verdict(rollout: Rollout, step: int) -> tuple[str, tuple[int, int, int]]:
    """How the episode stands after a control step: a word, and its colour."""
    holds = bool(rollout.conditions["success"][step])
    if rollout.succeeded[step]:
        return ("success", GREEN) if holds else (LOST, RED)
    return ("failed", RED) if rollout.conditions["failure"][: step + 1].any() else ("", INK)


def _lines(stages: Sequence[str], room: int) -> list[list[str]]:
    """Stages in as many lines as they need."""
    lines: list[list[str]] = []
    for stage in stages:
        if not lines or sum(map(_width_of, [*lines[-1], stage])) > room:
            lines.append([])
        lines[-1].append(stage)
    return lines


def _width_of(stage: str) -> int:
    return _DOT + _AFTER_DOT + text_width(stage, _SIZE, 400) + _AFTER_NAME


def _stage(drawn: Pixels, stage: str, at: tuple[int, int], *, reached: bool) -> int:
    """Write a stage with its dot, and say where the next begins."""
    left, base = at
    center, radius = (left + _DOT // 2, base - 4), _DOT // 2
    if reached:
        cv2.circle(drawn, center, radius, GREEN, cv2.FILLED, cv2.LINE_AA)
    else:
        cv2.circle(drawn, center, radius, PALE, 2, cv2.LINE_AA)
    color = INK if reached else GRAY
    write_text(drawn, stage, (left + _DOT + _AFTER_DOT, base), _SIZE, color, 400)
    return left + _width_of(stage)


def _name(picture: Pixels, camera: str, left: int) -> None:
    """A camera's name on a paper label in a corner of its picture."""
    width = text_width(camera, _SIZE, 400)
    picture[:22, left : left + width + 16] = PAPER
    write_text(picture, camera, (left + 8, 16), _SIZE, GRAY, 400)
