"""The chart of an episode's rewards."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from taskbuilder.visual.charts import Mark, reward_chart, spread, ticks


def drawn(terms, marks=(), steps=20):
    pays = {label: np.linspace(-1.0, number, steps) for number, label in enumerate(terms)}
    team = sum(pays.values(), np.zeros(steps))
    png = reward_chart("task", "seed 0", pays, team, marks)
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)[:, :, ::-1]


def count(picture, color):
    wanted = [int(color[start : start + 2], 16) for start in (1, 3, 5)]
    return int((abs(picture.astype(int) - wanted).max(axis=2) < 8).sum())


def test_every_term_has_a_line_of_its_own_colour():
    blue, red, green = "#0072B2", "#D55E00", "#009E73"
    two = drawn(["one", "two"])
    assert count(two, blue) > 200
    assert count(two, red) > 200
    assert count(two, green) < 20
    assert count(drawn(["one", "two", "three"]), green) > 200


def test_marks_are_drawn_and_success_is_green():
    plain, marked, won = (
        drawn(["one"], marks)
        for marks in ((), (Mark(5, "taken"),), (Mark(5, "taken"), Mark(9, "success", good=True)))
    )
    assert not np.array_equal(plain, marked)
    # Thin lines blend with the paper: green is where green outshines red.
    greens = [(p[:, :, 1].astype(int) - p[:, :, 0] > 40).sum() for p in (plain, marked, won)]
    assert greens[0] == greens[1]
    assert greens[2] > greens[1] + 200


def test_the_same_episode_makes_the_same_bytes():
    pays = {"one": np.arange(5.0)}
    first, second = (reward_chart("t", "s", pays, pays["one"], [Mark(2, "x")]) for _ in range(2))
    assert first == second
    assert b"Software" not in first


@pytest.mark.parametrize("steps", [0, 1, 300])
@pytest.mark.parametrize("terms", [0, 1, 14])
def test_any_number_of_terms_and_steps_can_be_drawn(terms, steps):
    marks = [Mark(step, "a stage with a long name") for step in range(min(steps, 9))]
    assert drawn([f"term {n}" for n in range(terms)], marks, steps).shape == (550, 990, 3)


def test_what_is_not_finite_breaks_a_line_and_no_more():
    pay = np.linspace(-1.0, 1.0, 20)
    broken = np.where(np.arange(20) == 10, np.nan, pay)
    whole, gap = (reward_chart("t", "s", {}, team) for team in (pay, broken))
    assert whole != gap


@pytest.mark.parametrize(
    ("low", "high", "whole", "found"),
    [
        (-1.6, 2.7, False, [-1.0, 0.0, 1.0, 2.0]),
        (0.0, 0.35, False, [0.0, 0.1, 0.2, 0.3]),
        (0.0, 1.0, True, [0.0, 1.0]),
        (0.0, 500.0, True, [0.0, 100.0, 200.0, 300.0, 400.0, 500.0]),
    ],
)
def test_ticks_are_round_numbers(low, high, whole, found):
    assert ticks(low, high, 5, whole=whole) == found


@pytest.mark.parametrize(
    ("places", "moved"),
    [
        ([], []),
        ([0.5], [0.5]),
        ([0.1, 0.5], [0.1, 0.5]),
        ([0.5, 0.5], [0.45, 0.55]),
        ([0.5, 0.5, 0.5], [0.4, 0.5, 0.6]),
        ([0.3, 0.5, 0.5], [0.3, 0.45, 0.55]),
        ([0.4, 0.5, 0.5], [0.3667, 0.4667, 0.5667]),
    ],
)
def test_labels_move_apart_as_little_as_they_must(places, moved):
    assert spread(places, 0.1) == pytest.approx(moved, abs=1e-3)


def test_labels_never_overlap():
    rng = np.random.default_rng(0)
    for _ in range(50):
        places = spread(sorted(rng.uniform(0, 1, 12).tolist()), 0.1)
        assert (np.diff(places) >= 0.1 - 1e-9).all()
