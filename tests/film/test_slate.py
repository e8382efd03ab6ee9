"""The slate below a film's pictures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from film_scenes import made_up

from taskbuilder.film.shooting import Frame
from taskbuilder.film.slate import GREEN, PALE, RED, compose, slate
from taskbuilder.render import INK, PAPER


def frame(step=0, pictures=None):
    return Frame(step / 10, step, pictures or {"front": np.zeros((48, 480, 3), dtype=np.uint8)})


def count(pixels, color):
    return int((pixels == color).all(axis=2).sum())


def bar(drawn):
    """Share of the bar that is filled, and its colour."""
    row = drawn[0]
    filled = ~(row == PALE).all(axis=1)
    return filled.mean(), tuple(row[0].tolist())


def test_the_bar_fills_as_time_passes():
    chronicle = made_up([0] * 11)
    shares = [bar(slate(chronicle, frame(step), 480))[0] for step in (0, 5, 10)]
    assert shares == pytest.approx([0.0, 0.5, 1.0])


def test_each_stage_lights_up_when_it_is_reached():
    chronicle = made_up([0, 1, 1, 2, 3])
    lit = [count(slate(chronicle, frame(step), 480), GREEN) for step in range(5)]
    assert lit[0] == 0
    assert lit[1] == lit[2] > 0
    assert lit[3] == 2 * lit[1]
    assert lit[4] == 3 * lit[1]


def test_success_turns_the_bar_green_and_stays():
    chronicle = made_up([0, 1, 2, 3, 3], success=3)
    colors = [bar(slate(chronicle, frame(step), 480))[1] for step in (1, 2, 3, 4)]
    assert colors == [INK, INK, GREEN, GREEN]
    lapsed = replace(
        chronicle, outcomes=(*chronicle.outcomes[:4], replace(chronicle.outcomes[4], success=False))
    )
    assert bar(slate(lapsed, frame(4), 480))[1] == GREEN


def test_failure_turns_it_red():
    chronicle = made_up([0, 0, 0])
    lost = replace(
        chronicle, outcomes=(*chronicle.outcomes[:2], replace(chronicle.outcomes[2], failure=True))
    )
    drawn = slate(lost, frame(2), 480)
    assert bar(drawn)[1] == RED
    assert count(drawn[4:], RED) > 20  # it says so


@pytest.mark.parametrize(("names", "lines"), [(2, 1), (9, 3), (0, 1)])
def test_stages_take_as_many_lines_as_they_need(names, lines):
    chronicle = made_up([names], names=("quite long",) * names)
    drawn = slate(chronicle, frame(), 480)
    assert drawn.shape == (4 + 28 * lines, 480, 3)


def test_it_fits_below_a_picture_of_any_width():
    for width in (16, 33, 2048):
        assert slate(made_up([0, 3], success=1), frame(1), width).shape[1] == width


def test_pictures_stand_side_by_side_with_their_names():
    pictures = {
        "one": np.full((40, 100, 3), 10, dtype=np.uint8),
        "two": np.full((30, 60, 3), 20, dtype=np.uint8),
    }
    whole = compose(frame(pictures=pictures), made_up([0], names=()))
    assert whole.shape == (40 + 32, 100 + 8 + 60, 3)
    assert whole[35, 50].tolist() == [10] * 3
    assert whole[25, 150].tolist() == [20] * 3
    assert whole[35, 150].tolist() == list(PAPER)
    assert whole[1, 1].tolist() == whole[1, 109].tolist() == list(PAPER)  # the names' labels


def test_a_single_picture_needs_no_name():
    picture = np.full((40, 100, 3), 10, dtype=np.uint8)
    whole = compose(frame(pictures={"one": picture}), made_up([0]))
    assert (whole[:40] == 10).all()


@pytest.mark.parametrize("shape", [(41, 101), (40, 101), (41, 100)])
def test_a_composed_frame_has_even_sides_as_video_wants_them(shape):
    picture = np.zeros((*shape, 3), dtype=np.uint8)
    height, width = compose(frame(pictures={"one": picture}), made_up([0])).shape[:2]
    assert (height % 2, width % 2) == (0, 0)
