"""The chart of an episode's rewards, as PNG."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle, groupby, pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from taskbuilder.visual.still import Pixels, text_width, write_text

# Distinct to all kinds of eyes (Okabe and Ito); the yellow of that palette is too pale for paper.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
DASHES: tuple[tuple[float, ...], ...] = ((), (4, 1.5), (1, 1.2))
"""Lengths of a dash and of the gap after it, in widths of the line."""

INK, GRAY, PAPER, GREEN = "#2B2826", "#7A746E", "#FCFBFA", "#168048"
_GRID, _ZERO = "#E7E3DE", "#CFC9C2"

_TEAM = "team"
_WIDTH, _HEIGHT = 990, 550  # pixels, as all that follows
_LEFT, _RIGHT, _TOP, _BOTTOM = 69, 792, 126, 490  # of what is inside the axes
_ROOM = 18.6  # between two labels
_ROWS, _ROW = 3, 17  # of labels above the axes, and the height of one
_TICK = 5
_THIN, _LINE, _BOLD_LINE = 1.3, 2.0, 3.7  # widths
_SMALL, _NAME, _SUBTITLE, _TITLE = 14, 15, 15, 24  # sizes of letters
_PLAIN, _BOLD = 400, 700
_FINE = 4  # lines are drawn so many times larger, then averaged
_SHIFT = 4  # fractional bits of OpenCV's coordinates
_ACROSS, _UP = 6, 5  # most ticks of the axes
_AIR = 0.05  # share of the axis beyond the lowest and the highest reward

Points = NDArray[np.float64]


@dataclass(frozen=True)
class Mark:
    """Something that happened at a control step.

    Attributes:
        step: Control steps that had passed.
        label: What it was.
        good: Drawn in green.
    """

    step: int
    label: str
    good: bool = False


def reward_chart(
    title: str,
    subtitle: str,
    terms: Mapping[str, NDArray[np.float64]],
    team: NDArray[np.float64],
    marks: Sequence[Mark] = (),
) -> bytes:
    """What an episode paid at each control step: a thin line a term, and the team's in bold.

    Args:
        title: In large letters.
        subtitle: Below it.
        terms: (steps,) pay of each reward term by its label.
        team: (steps,) the team's reward.
        marks: What happened; upright lines with labels above.

    Returns:
        A PNG.
    """
    page = _Page(len(team), _range([*terms.values(), team]))
    page.grid()
    for mark in marks:
        at = page.across(mark.step)
        page.line(((at, _TOP), (at, _BOTTOM)), GREEN if mark.good else GRAY, 1.0)
    styles = ((color, dash) for dash in cycle(DASHES) for color in COLORS)
    ends = []
    for (label, pay), (color, dash) in zip(terms.items(), styles, strict=False):
        page.curve(pay, color, _LINE, dash)
        ends.append(_End(page.up(pay[-1] if len(pay) else 0.0), label, color, _PLAIN))
    page.curve(team, INK, _BOLD_LINE)
    ends.append(_End(page.up(team[-1] if len(team) else 0.0), _TEAM, INK, _BOLD))
    page.frame()
    page.name_ends(ends)
    page.name_marks(marks)
    page.write(title, (30, 38), INK, _TITLE, _BOLD)
    page.write(subtitle, (30, 63), GRAY, _SUBTITLE)
    return page.png()


@dataclass(frozen=True, order=True)
class _End:
    """The right end of a line: its row, and how it is named."""

    row: float
    label: str
    color: str
    weight: int


class _Page:
    """A picture: lines are drawn on it first, then letters."""

    def __init__(self, steps: int, rewards: tuple[float, float]) -> None:
        self._steps, self._rewards = max(steps, 1), rewards
        size = (_HEIGHT * _FINE, _WIDTH * _FINE, 3)
        self._lines = np.full(size, _rgb(PAPER), dtype=np.uint8)
        self._texts: list[tuple[str, tuple[int, int], int, str, int]] = []

    def across(self, step: float) -> float:
        """The column of a control step."""
        return _LEFT + (_RIGHT - _LEFT) * step / self._steps

    def up(self, reward: float) -> float:
        """The row of a reward; that of what is not finite is that of zero."""
        low, high = self._rewards
        share = ((reward if math.isfinite(reward) else 0.0) - low) / (high - low)
        return _BOTTOM - (_BOTTOM - _TOP) * share

    def line(
        self, points: Sequence[tuple[float, float]] | Points, color: str, width: float
    ) -> None:
        """A line through columns and rows; pixels are counted from their middles."""
        fine = np.rint((np.asarray(points) + 0.5) * _FINE * (1 << _SHIFT)).astype(np.int32)
        thick = max(round(width * _FINE), 1)
        cv2.polylines(self._lines, [fine], False, _rgb(color), thick, cv2.LINE_AA, _SHIFT)

    def curve(self, pay: Points, color: str, width: float, dash: tuple[float, ...] = ()) -> None:
        """The pay of all control steps; where it is not finite, the line is broken."""
        points = np.array([(self.across(n), self.up(paid)) for n, paid in enumerate(pay, 1)])
        for finite, group in groupby(range(len(pay)), key=lambda n: math.isfinite(pay[n])):
            if finite:
                for piece in _dashed(points[list(group)], width, dash):
                    self.line(piece, color, width)

    def write(
        self, text: str, at: tuple[float, float], color: str, size: int, weight: int = _PLAIN
    ) -> None:
        """Letters that begin at a column, on a row."""
        self._texts.append((text, (round(at[0]), round(at[1])), size, color, weight))

    def grid(self) -> None:
        """Pale lines at round rewards."""
        for reward in ticks(*self._rewards, _UP):
            row = self.up(reward)
            self.line(((_LEFT, row), (_RIGHT, row)), _GRID if reward else _ZERO, _THIN)

    def frame(self) -> None:
        """The axis of control steps, round numbers, and what they are."""
        self.line(((_LEFT, _BOTTOM), (_RIGHT, _BOTTOM)), GRAY, _THIN)
        for step in ticks(0.0, self._steps, _ACROSS, whole=True):
            column, word = self.across(step), f"{step:g}"
            self.line(((column, _BOTTOM), (column, _BOTTOM + _TICK)), GRAY, _THIN)
            self.write(word, (column - _wide(word) / 2, _BOTTOM + 20), GRAY, _SMALL)
        shown = ticks(*self._rewards, _UP)
        for reward, word in zip(shown, _in_words(shown), strict=True):
            row = self.up(reward)
            self.line(((_LEFT - _TICK, row), (_LEFT, row)), GRAY, _THIN)
            self.write(word, (_LEFT - 9 - _wide(word), row + 5), GRAY, _SMALL)
        name = "control step"
        self.write(name, ((_LEFT + _RIGHT - _wide(name)) / 2, _BOTTOM + 40), GRAY, _SMALL)

    def name_ends(self, ends: Sequence[_End]) -> None:
        """Names at the right ends of lines, moved apart where they would overlap."""
        ordered = sorted(ends)
        places = spread([end.row for end in ordered], _ROOM)
        for place, end in zip(places, ordered, strict=True):
            self.line(((_RIGHT, end.row), (_RIGHT + 20, place)), end.color, 1.0)
            self.write(end.label, (_RIGHT + 25, place + 5), end.color, _NAME, end.weight)

    def name_marks(self, marks: Sequence[Mark]) -> None:
        """Labels above upright lines, in as many rows as keep them apart."""
        ends: list[float] = []
        for step, group in groupby(sorted(marks, key=_step), key=_step):
            together = list(group)
            good = any(mark.good for mark in together)
            weight, label = (_BOLD if good else _PLAIN), " · ".join(m.label for m in together)
            left = self.across(step) + 3
            row = next((row for row, end in enumerate(ends) if end + 6 < left), len(ends)) % _ROWS
            ends[row : row + 1] = [left + _wide(label, weight)]
            place = (left, _TOP - 5 - _ROW * row)
            self.write(label, place, GREEN if good else GRAY, _SMALL, weight)

    def png(self) -> bytes:
        """The picture as a file."""
        picture = cv2.resize(self._lines, (_WIDTH, _HEIGHT), interpolation=cv2.INTER_AREA)
        pixels: Pixels = picture.astype(np.uint8)
        for text, at, size, color, weight in self._texts:
            write_text(pixels, text, at, size, _rgb(color), weight)
        _write_upward(pixels, "reward", (32, (_TOP + _BOTTOM) // 2))
        packed = [cv2.IMWRITE_PNG_COMPRESSION, 9]
        return cv2.imencode(".png", pixels[:, :, ::-1], packed)[1].tobytes()


def _write_upward(picture: Pixels, text: str, middle: tuple[int, int]) -> None:
    """Letters from below to above, around a column and a row; they end at the column."""
    width, height = _wide(text), _SMALL + 6
    line = np.full((height, width, 3), _rgb(PAPER), dtype=np.uint8)
    write_text(line, text, (0, _SMALL), _SMALL, _rgb(GRAY), _PLAIN)
    top, left = middle[1] - width // 2, middle[0] - _SMALL
    picture[top : top + width, left : left + height] = np.rot90(line)


def _wide(text: str, weight: int = _PLAIN) -> int:
    return text_width(text, _SMALL, weight)


def _rgb(color: str) -> tuple[int, int, int]:
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)


def _range(lines: Sequence[Points]) -> tuple[float, float]:
    """From below the lowest finite reward to above the highest, with zero between."""
    paid = np.concatenate([np.zeros(1), *lines])
    paid = paid[np.isfinite(paid)]
    low, high = float(paid.min()), float(paid.max())
    air = _AIR * (high - low) or _AIR
    return low - air, high + air


def ticks(low: float, high: float, most: int, *, whole: bool = False) -> list[float]:
    """Round numbers from low to high, about as many as are asked for.

    Args:
        low: No number is below it.
        high: No number is above it.
        most: Parts into which they divide it, at most.
        whole: Whether numbers without a fraction are wanted.
    """
    rough = max((high - low) / most, 1.0 if whole else 0.0)
    power = 10.0 ** math.floor(math.log10(rough))
    apart = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough)
    first, last = math.ceil(low / apart), math.floor(high / apart)
    return [round(number * apart, 12) for number in range(first, last + 1)]


def _in_words(numbers: Sequence[float]) -> list[str]:
    """Numbers with as many decimals as tell them apart, and a true minus."""
    apart = min((high - low for low, high in pairwise(numbers)), default=1.0)
    decimals = min(max(-math.floor(math.log10(apart * 1.001)), 0), 9)
    return [f"{number:,.{decimals}f}".replace("-", "\N{MINUS SIGN}") for number in numbers]


def _dashed(points: Points, width: float, dash: tuple[float, ...]) -> Iterator[Points]:
    """The dashes of a line; all of it without any.

    Ends of lines are round: each dash is shorter by half a width at either end.
    """
    if not dash or len(points) < 2:
        yield points
        return
    ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    length, apart = width * (dash[0] - 1.0), width * sum(dash)
    for start in np.arange(width / 2.0, ways[-1], apart):
        end = min(start + length, ways[-1])
        inside = ways[(ways > start) & (ways < end)]
        at = np.array([start, *inside, end])
        yield np.stack([np.interp(at, ways, axis) for axis in points.T], axis=1)


def spread(places: Sequence[float], room: float) -> list[float]:
    """Rising numbers moved as little as they must be to be at least so far apart."""
    groups: list[list[float]] = []
    for place in places:
        groups.append([place])
        # A group stands evenly around the middle of where its members would be.
        while len(groups) > 1 and _top(groups[-2], room) + room > _bottom(groups[-1], room):
            last = groups.pop()
            groups[-1] += last
    return [_bottom(group, room) + room * index for group in groups for index in range(len(group))]


def _bottom(group: Sequence[float], room: float) -> float:
    return sum(group) / len(group) - room * (len(group) - 1) / 2.0


def _top(group: Sequence[float], room: float) -> float:
    return sum(group) / len(group) + room * (len(group) - 1) / 2.0


def _step(mark: Mark) -> int:
    return mark.step
