"""The training runs that are kept beside the results can be found again on another machine."""

from __future__ import annotations

import gzip
import json
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))

import kept_runs  # noqa: E402

GROUPS = sorted(file.name.partition(".")[0] for file in kept_runs.RESULTS.glob("*.tar.xz"))


def placed(plan):
    """The places of the machine that a plan names."""
    places = (plan["task"], plan.get("data", ""), plan.get("init", ""), *plan["command"].split())
    return [place for place in places if Path(place).is_absolute()]


@pytest.mark.parametrize("group", GROUPS)
def test_a_plan_names_no_place_of_the_machine_it_ran_on(group):
    with kept_runs.unpacked(group) as runs:
        plans = {file: json.loads(file.read_text()) for file in runs.glob("*/run.json")}
        assert len(plans) == len([*runs.iterdir()]) > 5
    assert not [file for file, plan in plans.items() if placed(plan)]
    for file in kept_runs.RESULTS.rglob("run.json"):
        assert not placed(json.loads(file.read_text()))


def test_a_run_that_is_kept_is_read_again_and_the_others_stay(tmp_path, monkeypatch):
    monkeypatch.setattr(kept_runs, "RESULTS", tmp_path)
    with kept_runs.changed("group") as runs:
        (runs / "one").mkdir()
        (runs / "one" / "run.json").write_text("{}")
        (runs / "one" / "episodes.csv.gz").write_bytes(gzip.compress(b"step\n1\n"))
    first = (tmp_path / "group.tar.xz").read_bytes()
    with kept_runs.changed("group") as runs:
        pass
    assert (tmp_path / "group.tar.xz").read_bytes() == first
    with kept_runs.changed("group") as runs:
        (runs / "two").mkdir()
        (runs / "two" / "run.json").write_text("{}")
    with kept_runs.unpacked("group") as runs:
        assert sorted(path.name for path in runs.iterdir()) == ["one", "two"]
        assert (runs / "one" / "episodes.csv").read_text() == "step\n1\n"
    assert [file.name for file in tmp_path.iterdir()] == ["group.tar.xz"]


def test_a_run_is_put_into_a_group_with_fewer_digits(tmp_path, monkeypatch):
    monkeypatch.setattr(kept_runs, "RESULTS", tmp_path)
    run = tmp_path / "run"
    run.mkdir()
    for name in ("run.json", "policy.npz"):
        (run / name).write_text("{}")
    for name in ("evaluations.csv", "updates.csv"):
        (run / name).write_text("step,how\n")
    (run / "episodes.csv").write_text("step,return,how\n123456,-73.08481,nan\n200000,0.5,a\n2000")
    kept_runs.keep("group", run, "one")
    kept_runs.keep("group", run, "two")
    with kept_runs.unpacked("group") as runs:
        assert sorted(path.name for path in runs.iterdir()) == ["one", "two"]
        table = (runs / "one" / "episodes.csv").read_text()
    assert table == "step,return,how\n123456,-73.08,nan\n200000,0.5,a\n"
