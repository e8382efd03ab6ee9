"""`taskbuilder benchmark`: its table, its reports, and what it refuses."""

from __future__ import annotations

import json

import pytest
from made_benchmarks import write_benchmark, write_suite

from taskbuilder.benchmark.records import CellRecord, Method

pytest.importorskip("torch")

LONG = "carry_tray_of_balls"


def test_a_report_is_a_table_of_80_columns(run, tmp_path):
    failed = CellRecord(task=LONG, seed=12, status="failed", reason="no such key\nin a file")
    cells = {"handover": (10, 10, 10, 9, 10), LONG: (10, failed, 10, 10, 10)}
    write_benchmark(tmp_path / "bc", cells, tuning_runs=6)
    ran = run("benchmark", "--report", "bc")
    assert (ran.status, ran.err) == (1, "")
    assert (
        ran.out
        == """
made · imitation, version 2

task                 median seed, %      seed 11 12 13 14 15  safe   CPU min
handover *           100.0 (72.2–100.0)  100 100 100 90 100   100.0  1.0
carry_tray_of_balls  100.0 (72.2–100.0)  100 x 100 100 100    100.0  1.0
carry_tray_of_balls: no such key
*  a development task, on which methods may be tuned

bc
  IQM, %                     100.0 (81.7–100.0)
  without development tasks  100.0 (33.3–100.0)
  tasks                      2 of 2
  tuning runs                6

bc/README.md
bc/benchmark.png
bc/results.csv
bc/results.json
"""
    )
    assert max(map(len, ran.out.splitlines())) <= 80


def test_methods_are_reported_side_by_side(run, tmp_path):
    write_benchmark(tmp_path / "bc", {"a": (10, 9), "b": (3, 4)})
    zoo = Method(policy="zoo:{task}/cloned")
    write_benchmark(tmp_path / "zoo", {"a": (10, 10), "b": (7, 8)}, method=zoo)
    ran = run("benchmark", "--report", "bc", "zoo", "--out", "both")
    assert (ran.status, ran.err) == (0, "")
    table = ran.out.split("\n\n")[-3]
    assert table == (
        "task  bc                zoo:{task}/cloned\n"
        "a     90.0 (59.6–98.2)  100.0 (72.2–100.0)\n"
        "b     30.0 (10.8–60.3)  70.0 (39.7–89.2)"
    )
    assert (tmp_path / "both" / "README.md").read_text().startswith("# Benchmark: made, imitation")
    assert run("benchmark", "--report", "bc", "zoo", "--out", "both", "--json").data["files"]


def test_policies_that_exist_are_played_and_told_as_they_end(run, tmp_path):
    (tmp_path / "tasks").mkdir()
    write_suite(tmp_path / "tasks")
    words = ("benchmark", "few", "--track", "reinforcement", "--smoke", "--policy", "hold")
    ran = run(*words, "--out", "hold", "--task-path", "tasks", "--jobs", "1", "--only", "lonely")
    assert ran.status == 1
    assert ran.out.startswith("lonely, seed 11: ")
    assert "few · reinforcement, version 2, smoke version: not comparable" in ran.out
    assert "1 cell is missing; the same command without --only goes on" in ran.out
    about = json.loads((tmp_path / "hold" / "benchmark.json").read_text())
    assert about["command"].startswith("taskbuilder benchmark few --track reinforcement --smoke")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "which suite? name one, such as seed, or --report DIR"),
        (("seed",), "which track? give --track"),
        (("seed", "--track", "imitation"), "which folder? give --out"),
        (
            ("seed", "--track", "imitaton", "--algorithm", "bc", "--out", "x"),
            'no track "imitaton"; did you mean "imitation"?',
        ),
        (
            ("seed", "--track", "imitation", "--out", "x"),
            "name either an algorithm, which trains policies, or a policy; one of them",
        ),
        (("--report", "bc", "--jobs", "2"), "--report reports what is there; leave --jobs out"),
        (("seed", "--report", "bc"), "--report reports what is there; leave seed out"),
        (("--report", "."), "holds no benchmark"),
        (
            ("seed", "--track", "vision", "--ray", "--jobs", "2", "--out", "x"),
            "--jobs does not go with --ray",
        ),
    ],
)
def test_what_is_wrong_is_told_in_a_line(run, words, said):
    ran = run("benchmark", *words)
    assert (ran.status, ran.out) == (2, "")
    assert said in ran.err
    assert ran.err.count("\n") == 1
