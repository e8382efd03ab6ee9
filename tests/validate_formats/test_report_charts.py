"""The chart of what pays."""

from __future__ import annotations

import pytest

from taskbuilder.expert.baselines import EXPERT, Baseline, BaselineKind
from taskbuilder.validate.html.chart import Axis, charts, lines
from taskbuilder.validate.html.page import Page
from taskbuilder.validate.html.templates import task_page
from taskbuilder.validate.report import FamilyResult, Probe, TaskReport


def drawn(*probes):
    """The page of a report with nothing but these."""
    family = FamilyResult("pays for success", (), (), "", probes=probes)
    return task_page(Page(TaskReport("lift", "lift", (family,))))


def test_the_best_stands_on_top_and_what_beats_the_expert_is_told_apart(probes):
    listed = [(str(line.baseline), line.role) for line in lines(probes, discounted=False)]
    assert listed == [("stall after stage 2", "rival"), ("expert", "expert"), ("random", "other")]
    listed = [(str(line.baseline), line.role) for line in lines(probes, discounted=True)]
    assert listed == [("expert", "expert"), ("stall after stage 2", "other"), ("random", "other")]


def test_the_seeds_that_a_comparison_needed_are_told():
    stall = Probe(
        Baseline(BaselineKind.STALL, stage=1), (1.0, 2.0), (0.5, 1.0), 0, decided_after=20
    )
    assert "decided after 20 seeds" in drawn(Probe(EXPERT, (3.0,), (2.0,), 1), stall)
    assert "decided after" not in drawn(Probe(EXPERT, (3.0,), (2.0,), 1))


def test_what_is_not_finite_is_left_out(probes):
    random = lines(probes, discounted=False)[-1]
    assert (random.returns, random.mean, random.episodes) == ((-44.0,), -44.0, 2)
    wild = Probe(EXPERT, (float("inf"),), (0.0,), 0)
    (baseline,) = lines([wild], discounted=False)
    assert baseline.mean is None
    assert "not finite" in drawn(wild)


def test_without_an_expert_nothing_beats_it(probes):
    assert {line.role for line in lines(probes[1:], discounted=False)} == {"other"}


def test_every_episode_is_a_dot_until_there_are_too_many(probes):
    assert drawn(*probes).count("<circle") == 5 + 5
    many = Probe(EXPERT, tuple(map(float, range(1000))), (), 0)
    assert drawn(many).count("<circle") <= 60


@pytest.mark.parametrize(
    ("low", "high", "ticks"),
    [(-50.0, 70.0, [-50, 0, 50]), (0.0, 1.0, [0, 0.5, 1]), (-3.1, 0.2, [-3, -2, -1, 0])],
)
def test_ticks_are_round_and_on_the_axis(low, high, ticks):
    assert Axis(low, high).ticks() == ticks


@pytest.mark.parametrize(
    ("axis", "value", "text"),
    [
        (Axis(-100.0, 52.0), -32.0, "−32.0"),
        (Axis(0.0, 5.0), 1.234, "1.23"),
        (Axis(0.0, 0.5), 0.1, "0.100"),
        (Axis(0.0, 2e4), 12345.6, "12,346"),
        (Axis(-50.0, 50.0), -0.01, "0.0"),
    ],
)
def test_returns_are_as_precise_as_the_chart_is_long(axis, value, text):
    assert axis.tell(value) == text


@pytest.mark.parametrize("value", [0.0, 5.0, -1e-12, 1e12])
def test_returns_that_are_all_alike_have_an_axis(value):
    text = drawn(Probe(EXPERT, (value, value), (value,), 0))
    assert "nan" not in text
    assert 'cx="' in text


def test_where_nothing_was_played_there_is_no_chart():
    assert charts([]) == []
    assert "<svg" not in drawn()
