"""The training runs that are kept beside the results can be found again on another machine."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

RESULTS = Path(__file__).resolve().parents[2] / "benchmarks" / "results"
PLANS = sorted(RESULTS.rglob("run.json"))


@pytest.mark.parametrize("file", PLANS, ids=lambda file: file.parent.name)
def test_a_plan_names_no_place_of_the_machine_it_ran_on(file):
    plan = json.loads(file.read_text())
    places = (plan["task"], plan.get("data", ""), plan.get("init", ""), *plan["command"].split())
    assert not [place for place in places if Path(place).is_absolute()]
