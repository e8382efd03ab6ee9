"""Pictures of learning curves."""

from __future__ import annotations

import re

import cv2
import numpy as np
import pytest

from taskbuilder.visual.charts import COLORS, GREEN
from taskbuilder.visual.curves import Curve, Group, in_short, learning_curves

BLUE, RED = COLORS[:2]
NONE = "#DDD8D2"
STEPS = np.arange(1.0, 11.0) * 1_000


def curve(*ends, steps=STEPS):
    """Lines from 0 to each of these, and, of several, a bold one and a band that are made up."""
    lines = [(steps, np.linspace(0.0, end, len(steps))) for end in ends]
    if len(lines) < 2:
        return Curve(lines)
    values = np.array([line[1] for line in lines])
    return Curve(lines, (steps, values.mean(0), values.min(0), values.max(0)))


def shares(count, steps=STEPS):
    """From none to the last stage, evenly."""
    rows = np.zeros((count + 1, len(steps)))
    rows[0] = np.linspace(1.0, 0.0, len(steps))
    rows[-1] += 1.0 - rows[0] if count else 0.0
    return steps, rows


def made(label="one", ends=(1.0,), terms=("reach",), stages=2, steps=STEPS, at_end=()):
    drawn = curve(*ends, steps=steps)
    return Group(
        label,
        len(ends),
        success=drawn,
        at_end=curve(*at_end, steps=steps) if at_end else None,
        team_return=drawn,
        terms=dict.fromkeys(map(str, terms), drawn),
        stages=shares(stages, steps),
    )


def drawn(*groups, stages=("begun", "there"), title="task", at=lambda steps: steps / 50):
    png = learning_curves(title, ["below"], groups, stages, at)
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)[:, :, ::-1]


def where(picture, color):
    wanted = [int(color[start : start + 2], 16) for start in (1, 3, 5)]
    return abs(picture.astype(int) - wanted).max(axis=2) < 8


def count(picture, color):
    return int(where(picture, color).sum())


@pytest.fixture(scope="module")
def alone():
    """A single run, of a task with one term and two stages."""
    return drawn(made())


def test_each_group_has_a_colour_of_its_own_in_every_panel(alone):
    both = drawn(made("one"), made("two", ends=(0.5,)))
    assert count(alone, BLUE) > 1000
    assert count(alone, RED) == 0
    assert count(both, RED) > 1000
    but_the_small_one = drawn(made("one"), made("two", ends=(0.5,), terms=()))
    assert count(both, RED) > count(but_the_small_one, RED) > 0


def test_several_runs_are_faint_below_what_they_have_in_common(alone):
    several = drawn(made(ends=(0.2, 0.6, 1.0)))
    tinted = [(p[:, :, 2].astype(int) - p[:, :, 0] > 15).sum() for p in (alone, several)]
    assert tinted[1] > 1.5 * tinted[0]
    assert count(several, BLUE) == pytest.approx(count(alone, BLUE), rel=0.4)


def test_success_at_the_last_step_is_dashed_below_success(alone):
    with_ends = drawn(made(at_end=(0.4,)))
    rows, columns = (alone != with_ends).any(axis=2).nonzero()
    assert rows.max() < 0.5 * alone.shape[0]  # in the panel of success, and nowhere else
    assert columns.max() < 0.5 * alone.shape[1]
    assert count(with_ends, BLUE) > count(alone, BLUE) + 300
    titles = [svg_of(group).count("dashed") for group in (made(), made(at_end=(0.2, 0.4)))]
    assert titles == [0, 1]


def svg_of(*groups):
    return learning_curves("t", [], groups, (), lambda steps: steps, "svg").decode()


def height(*groups):
    """Of a picture, in points."""
    return float(re.search(r'height="([\d.]+)pt"', svg_of(*groups))[1])


def test_a_long_line_below_the_title_is_wrapped():
    words = " ".join(["reset_networks_after"] * 12)
    pictures = [
        learning_curves("t", [line], [made()], (), lambda steps: steps, "svg").decode()
        for line in ("short", words)
    ]
    assert [picture.count("reset_networks_after") for picture in pictures] == [0, 12]
    assert words not in pictures[1]


def test_every_term_has_a_panel_and_every_group_its_stages():
    one, two, three = (height(*(made(f"g{n}", terms=()) for n in range(m))) for m in (1, 2, 3))
    assert three - two > 150 > two - one > 0  # two stand side by side
    assert height(made(terms=range(5))) - one > 250  # two rows of four


def test_the_last_stage_is_green_and_lies_at_the_bottom():
    picture = drawn(made(terms=()))
    green, none = (where(picture, color).nonzero()[0] for color in (GREEN, NONE))
    assert min(len(green), len(none)) > 10_000
    assert green.mean() > none.mean()


@pytest.mark.parametrize("groups", [1, 2])
@pytest.mark.parametrize(
    "name", ["lower cube on the mark", "a name that is far too long for it " * 3]
)
def test_a_long_name_of_a_stage_ends_before_the_edge(name, groups):
    picture = drawn(*(made(str(number)) for number in range(groups)), stages=("begun", name))
    paper = picture[0, 0]
    assert (picture[:, -10:] == paper).all()


def test_the_upper_axis_says_how_many_episodes_there_were(alone):
    others = drawn(made(), at=lambda steps: steps / 40)
    differ = (alone != others).any(axis=2).nonzero()
    assert len(differ[0]) > 0
    assert differ[0].max() < 0.35 * len(alone)  # above the large panels, and nowhere else


def test_the_same_runs_make_the_same_picture(alone):
    assert np.array_equal(drawn(made()), alone)
    arguments = ("t", ["s"], [made(terms=())], ("begun",), lambda steps: steps, "svg")
    first, second = (learning_curves(*arguments) for _ in range(2))
    assert first == second
    assert b"<dc:date>" not in first


@pytest.mark.parametrize(("terms", "stages", "last"), [(0, 0, 0), (0, 1, 10_000), (1, 9, 10_000)])
def test_any_number_of_terms_and_stages_can_be_drawn(terms, stages, last):
    picture = drawn(made(terms=range(terms), stages=stages), stages=("only one has a name",))
    assert picture.shape[1] == 1210
    assert last <= count(picture, GREEN) <= 100 * last


def test_a_run_that_has_just_begun_can_be_drawn():
    picture = drawn(made(steps=STEPS[:1]))
    assert count(picture, BLUE) > 20
    assert count(picture, NONE) > 10_000


def test_what_never_changes_is_not_looked_at_through_a_lens():
    still = made(ends=(0.0,), stages=0)
    assert svg_of(still).count("<!-- 0.8 -->") == 2  # of return and of the term


def test_what_is_missing_is_left_out():
    nothing = (np.zeros(0), np.zeros((3, 0)))
    other = Group("two", 1, curve(1.0), None, Curve([]), {}, nothing)
    picture = drawn(made("one"), other)
    assert count(picture, RED) > 300
    assert count(picture, GREEN) > 10_000


@pytest.mark.parametrize(
    ("number", "text"),
    [(0.0, "0"), (0.5, "0.5"), (250.0, "250"), (2_500.0, "2.5k"), (1e5, "100k"), (1.5e6, "1.5M")],
)
def test_numbers_are_in_short(number, text):
    assert in_short(number) == text
