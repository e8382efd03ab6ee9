"""The overlay below a film's pictures."""

from __future__ import annotations

import numpy as np
import pytest
from made_rollouts import made_rollout

from taskbuilder.visual.capture import Frame
from taskbuilder.visual.overlay import GREEN, PALE, RED, compose, overlay
from taskbuilder.visual.still import INK, PAPER


def frame(step=0, pictures=None):
    return Frame(step / 10, step, pictures or {"front": np.zeros((48, 480, 3), dtype=np.uint8)})


def count(pixels, color):
    return int((pixels == color).all(axis=2).sum())


def bar(drawn):
    """Fraction of the bar that is filled, and its colour."""
    row = drawn[0]
    filled = ~(row == PALE).all(axis=1)
    return filled.mean(), tuple(row[0].tolist())


def test_the_bar_fills_as_time_passes():
    rollout = made_rollout([0] * 11)
    shares = [bar(overlay(rollout, frame(step), 480))[0] for step in (0, 5, 10)]
    assert shares == pytest.approx([0.0, 0.5, 1.0])


def test_each_stage_lights_up_when_it_is_reached():
    rollout = made_rollout([0, 1, 1, 2, 3])
    lit = [count(overlay(rollout, frame(step), 480), GREEN) for step in range(5)]
    assert lit[0] == 0
    assert lit[1] == lit[2] > 0
    assert lit[3] == 2 * lit[1]
    assert lit[4] == 3 * lit[1]


def test_success_turns_the_bar_green_for_as_long_as_it_holds():
    rollout = made_rollout([0, 1, 2, 3, 3], success=[3])
    drawn = [overlay(rollout, frame(step), 480) for step in range(1, 5)]
    assert [bar(each)[1] for each in drawn] == [INK, INK, GREEN, RED]
    assert count(drawn[2][4:], GREEN) > count(drawn[1][4:], GREEN)  # it says so
    assert count(drawn[3][4:], RED) > 20


def test_failure_turns_it_red_and_success_afterwards_counts_no_more():
    rollout = made_rollout([0, 0, 0, 0], failure=[2], success=[3])
    assert bar(overlay(rollout, frame(1), 480))[1] == INK
    for step in (2, 3):
        drawn = overlay(rollout, frame(step), 480)
        assert bar(drawn)[1] == RED
        assert count(drawn[4:], RED) > 20


@pytest.mark.parametrize(("names", "lines"), [(2, 1), (9, 3), (0, 1)])
def test_stages_take_as_many_lines_as_they_need(names, lines):
    rollout = made_rollout([names], stages=("quite long",) * names)
    drawn = overlay(rollout, frame(), 480)
    assert drawn.shape == (4 + 28 * lines, 480, 3)


def test_it_fits_below_a_picture_of_any_width():
    for width in (16, 33, 2048):
        assert overlay(made_rollout([0, 3], success=[1]), frame(1), width).shape[1] == width


def test_pictures_stand_side_by_side_with_their_names():
    pictures = {
        "one": np.full((40, 100, 3), 10, dtype=np.uint8),
        "two": np.full((30, 60, 3), 20, dtype=np.uint8),
    }
    whole = compose(frame(pictures=pictures), made_rollout([0], stages=()))
    assert whole.shape == (40 + 32, 100 + 8 + 60, 3)
    assert whole[35, 50].tolist() == [10] * 3
    assert whole[25, 150].tolist() == [20] * 3
    assert whole[35, 150].tolist() == list(PAPER)
    assert whole[1, 1].tolist() == whole[1, 109].tolist() == list(PAPER)  # the names' labels


def test_a_single_picture_needs_no_name():
    picture = np.full((40, 100, 3), 10, dtype=np.uint8)
    whole = compose(frame(pictures={"one": picture}), made_rollout([0]))
    assert (whole[:40] == 10).all()


@pytest.mark.parametrize("shape", [(41, 101), (40, 101), (41, 100)])
def test_a_composed_frame_has_even_sides_as_video_wants_them(shape):
    picture = np.zeros((*shape, 3), dtype=np.uint8)
    height, width = compose(frame(pictures={"one": picture}), made_rollout([0])).shape[:2]
    assert (height % 2, width % 2) == (0, 0)
