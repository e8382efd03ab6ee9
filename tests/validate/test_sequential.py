"""Comparisons that stop when they are decided: the looks, their error, and what is played."""

from __future__ import annotations

import json

import numpy as np
import pytest
from proof_tasks import DESCRIPTION, PAIR

from taskbuilder import validate_task
from taskbuilder.expert.baselines import EXPERT, BaselineKind
from taskbuilder.intervals import PairedDifference, student
from taskbuilder.validate.checks.rivals import LEAST_PAIRS
from taskbuilder.validate.report import as_data
from taskbuilder.validate.sequential import ENOUGH, ERROR, looks

pytestmark = pytest.mark.in_process

PAYS = "pays for success"


@pytest.mark.parametrize(
    ("df", "tail", "quantile"),
    [  # as in tables of Student's t
        (1, 0.025, 12.706),
        (2, 0.05, 2.920),
        (4, 0.0005, 8.610),
        (9, 0.005, 3.250),
        (30, 0.025, 2.042),
        (39, 0.025, 2.023),
        (120, 0.001, 3.160),
        (7, 0.5, 0.0),
    ],
)
def test_quantiles_are_those_of_tables(df, tail, quantile):
    assert student(df, tail) == pytest.approx(quantile, abs=6e-4)


def test_an_interval_is_as_wide_as_it_is_asked_to_be_sure():
    ours, theirs = [3.0, 5.0, 4.0, 6.0, 7.0], [1.0, 2.0, 3.0, 1.0, 4.0]
    usual = PairedDifference.of(ours, theirs)
    assert PairedDifference.of(ours, theirs, 0.025).low == pytest.approx(usual.low, abs=1e-3)
    sure = PairedDifference.of(ours, theirs, 0.0005)
    assert sure.half_width / usual.half_width == pytest.approx(8.610 / 2.776, abs=1e-3)
    assert (sure.low, sure.high) == (sure.mean - sure.half_width, sure.mean + sure.half_width)


def test_looks_double_and_spend_the_whole_error():
    plan = looks(ENOUGH)
    assert [look.seeds for look in plan.listed] == [5, 10, 20, 40]
    tails = [look.tail for look in plan.listed]
    assert tails == sorted(tails)
    assert sum(tails) == pytest.approx(ERROR)
    assert [look.seeds for look in looks(100).listed] == [5, 10, 20, 40, 80, 100]


@pytest.mark.parametrize("variations", [1, 2, 3, 4, 6, 30])
def test_the_first_look_has_every_variation_twice_if_there_are_seeds_enough(variations):
    plan = looks(ENOUGH, variations)
    assert plan.first >= min(2 * variations, ENOUGH)
    assert plan.listed[-1].seeds == ENOUGH
    assert sum(look.tail for look in plan.listed) == pytest.approx(ERROR)


def test_few_seeds_are_judged_by_the_usual_interval_and_doubled():
    plan = looks(5)
    assert [(look.seeds, look.tail) for look in plan.listed] == [
        (5, ERROR),
        (10, ERROR),
        (20, ERROR),
        (40, ERROR),
    ]
    assert [look.seeds for look in looks(1).listed] == [1, 2, 4, 8, 16, 32, 40]


def test_the_error_over_all_looks_is_what_is_claimed():
    """Normal differences without a lead: the share of trials in which some look finds one."""
    trials = 20_000
    drawn = np.random.default_rng(0).normal(size=(trials, ENOUGH))
    wrong = np.zeros(trials, bool)
    for look in looks(ENOUGH).listed:
        seen = drawn[:, : look.seeds]
        half = student(look.seeds - 1, look.tail) * seen.std(axis=1, ddof=1) / look.seeds**0.5
        wrong |= seen.mean(axis=1) > half
    rate = wrong.mean()
    assert 0.8 * ERROR < rate < ERROR + 3 * (ERROR / trials) ** 0.5


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pair")
    (folder / "pair.yaml").write_text(PAIR)
    (folder / "pair.py").write_text(DESCRIPTION)
    return validate_task(folder / "pair.yaml", seeds=ENOUGH, only=(PAYS,))


class TestProbes:
    def test_what_is_decided_is_not_played_on(self, report):
        assert report.ok
        (pays,) = (family for family in report.families if family.probes)
        expert, *others = pays.probes
        assert expert.baseline == EXPERT
        assert expert.decided_after is None
        compared = [probe for probe in others if probe.decided_after]
        assert {probe.decided_after for probe in compared} <= {5, 10, 20, 40}
        assert min(probe.decided_after for probe in compared) < ENOUGH
        for probe in compared:
            assert probe.seeds == tuple(range(probe.decided_after))
        for probe in others:
            if probe not in compared:  # as it succeeds itself
                assert probe.successes > ENOUGH - LEAST_PAIRS
        assert "; decided by number of seeds: " in pays.summary

    def test_the_return_of_every_seed_is_kept(self, report):
        (pays,) = (family for family in report.families if family.probes)
        data = json.loads(json.dumps(as_data([report])))
        for told, probe in zip(data["tasks"][0]["probes"], pays.probes, strict=True):
            by_seed = told["by_seed"]
            assert by_seed["seed"] == list(probe.seeds)
            assert by_seed["return"] == pytest.approx(list(probe.returns), rel=1e-6)
            assert by_seed["discounted_return"] == pytest.approx(list(probe.discounted), rel=1e-6)
            assert sum(by_seed["succeeded"]) == probe.successes
            assert told["decided_after"] == probe.decided_after


def test_a_probe_that_surely_earns_more_is_not_played_on(prove):
    """The description pays for holding the cube: stalling after the grasp earns far more."""
    paid = (
        '        Distance("carry", "cube", "goal"),\n',
        '        Bonus("low", Held("cube") & Below("cube", height=0.1), 50.0),\n',
    )
    report = prove(paid, only=(PAYS,), seeds=ENOUGH)
    (finding,) = report.findings
    assert finding.code == "TB552"
    (pays,) = (family for family in report.families if family.probes)
    (stall,) = (probe for probe in pays.probes if probe.baseline.kind is BaselineKind.STALL)
    assert stall.decided_after < ENOUGH
