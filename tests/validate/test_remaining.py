"""The estimate of how long a proof still takes, against the proofs of the library."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from taskbuilder.validate.remaining import MEASURED, RATIOS, remaining_s
from taskbuilder.validate.report import Check, FamilyResult, TaskReport
from taskbuilder.validate.runner import SEEDS

PROOFS = Path(__file__).resolve().parents[2] / "benchmarks" / "results" / "proofs"


def report_of(seconds: dict[str, float]) -> TaskReport:
    families = (FamilyResult(name, (), (), "", each) for name, each in seconds.items())
    return TaskReport("task", "task", tuple(families))


def proofs() -> list[dict[str, float]]:
    """The duration of each family in every proof that is kept."""
    found = [json.loads(file.read_text())["families"] for file in sorted(PROOFS.glob("*.json"))]
    return [{family["name"]: family["seconds"] for family in families} for families in found]


@pytest.mark.parametrize("last", MEASURED)
def test_the_estimate_is_within_a_factor_of_two_of_nearly_all_proofs(last):
    near, all_proofs = 0, proofs()
    for seconds in all_proofs:
        order = [*RATIOS]
        done = {name: seconds[name] for name in order[: order.index(last) + 1]}
        rest = sum(seconds[name] for name in order if name not in done)
        estimate = remaining_s(report_of(done), RATIOS, SEEDS, jobs=1)
        near += 0.5 <= estimate / rest <= 2.0
    assert len(all_proofs) >= 52
    assert near >= 0.9 * len(all_proofs)


def test_more_seeds_take_longer_and_more_processes_less():
    report = report_of({"repeat": 10.0})
    full = remaining_s(report, RATIOS, 40, 1)
    assert remaining_s(report, RATIOS, 40, 2) < 0.6 * full
    assert remaining_s(report, RATIOS, 80, 1) > 1.5 * full
    assert remaining_s(report, RATIOS, 5, 1) is None
    assert remaining_s(report, ["repeat", "cost"], 40, 1) == pytest.approx(2.0)
    later = report_of({"repeat": 10.0, "solvable": 100.0})
    twice = report_of({"repeat": 10.0, "solvable": 200.0})
    assert remaining_s(twice, RATIOS, 40, 1) == 2.0 * remaining_s(later, RATIOS, 40, 1)


def test_nothing_is_told_before_there_is_a_measure_or_after_a_failure():
    assert remaining_s(report_of({"build": 1.0}), RATIOS, 40, 1) is None
    report = report_of({"build": 1.0, "repeat": 10.0})
    wrong = Check("TB502", "the same twice", ok=False, value=1, limit=0, unit="episodes")
    first, second = report.families
    failed = replace(report, families=(replace(first, checks=(wrong,)), second))
    assert remaining_s(failed, RATIOS, 40, 1) is None
