"""The constants of a reward decide whether giving away pays; the validator finds it out."""

from __future__ import annotations

from pathlib import Path
from statistics import mean

import pytest

from taskbuilder.expert.baselines import EXPERT, Baseline, BaselineKind
from taskbuilder.validate.runner import validate_task

KEPT = Path(__file__).parent / "variants" / "handover_kept.yaml"


@pytest.fixture(scope="module")
def report():
    return validate_task(KEPT, seeds=2, only=("pays for success",))


@pytest.mark.slow
def test_a_handover_that_pays_less_than_holding_on_is_found_out(report):
    (finding,) = report.findings
    assert finding.code == "TB552"
    assert "stall" in finding.message
    assert "right: grasp stick.right_end" in finding.message
    assert finding.location.file == KEPT.with_suffix(".py")


def test_the_expert_is_seen_to_earn_less_than_one_who_never_lets_go(report):
    (family,) = (family for family in report.families if family.probes)
    probes = {probe.baseline: probe for probe in family.probes}
    assert mean(probes[Baseline(BaselineKind.STALL, stage=3)].returns) > mean(
        probes[EXPERT].returns
    )
