"""What results say: by task, over the suite, side by side, and when something is wrong."""

from __future__ import annotations

import csv
import io
import json

import pytest
from made_benchmarks import made_cell, write_benchmark

from taskbuilder.benchmark.page import page, write_report
from taskbuilder.benchmark.records import CELL, CellRecord, Method, cell_folder
from taskbuilder.benchmark.results import as_csv, as_data, read_results, read_several
from taskbuilder.benchmark.tables import suite_table, task_table
from taskbuilder.benchmark.tracks import find_track
from taskbuilder.errors import UsageError


def test_the_median_seed_stands_for_the_method(folder):
    results = read_results(write_benchmark(folder, {"a": (9, 2, 5), "b": (1, 8, 3)}))
    assert [each.median.seed for each in results.tasks] == [13, 13]
    # Wilson, 5 of 10: 0.2366 to 0.7634; 3 of 10: 0.1078 to 0.6032.
    assert task_table(results)[1:] == [
        ["a", "50.0 (23.7–76.3)", "90 20 50", "50.0", "1.0"],
        ["b", "30.0 (10.8–60.3)", "10 80 30", "30.0", "1.0"],
    ]


def test_of_two_seeds_the_lower_stands_for_the_method(folder):
    results = read_results(write_benchmark(folder, {"a": (9, 2)}))
    assert results.tasks[0].median.successes_at_end == 2


def test_a_cell_that_failed_counts_as_none_and_says_why(folder):
    failed = CellRecord(task="a", seed=12, status="failed", reason="no such | key")
    results = read_results(write_benchmark(folder, {"a": (10, failed, 10), "b": (10, 10, 10)}))
    # 0 1 1 1 1 1 without the lowest and the highest.
    assert float(results.interquartile_mean().value) == 1.0
    assert results.scores() == [(1.0, 0.0, 1.0), (1.0, 1.0, 1.0)]
    assert task_table(results)[1][2] == "100 x 100"
    assert "- a: no such \\| key" in page([results])


def test_a_task_that_the_track_cannot_have_is_left_out(folder):
    no = [CellRecord(task="a", seed=s, status="impossible", reason="no expert") for s in (11, 12)]
    results = read_results(write_benchmark(folder, {"a": no, "b": (4, 6)}))
    assert results.scores() == [(0.4, 0.6)]
    assert suite_table([results])[1][3] == "1 of 2"
    assert task_table(results)[1][1] == "not possible"


def test_without_all_cells_there_is_no_figure_of_the_suite(folder):
    results = read_results(write_benchmark(folder, {"a": (10, None), "b": (10, 10)}))
    assert (results.missing, results.interquartile_mean(), results.profile()) == (1, None, None)
    assert "**Not complete**: cells of `bc` are missing, 1 in all." in page([results])


def test_development_tasks_are_marked_and_can_be_left_out(folder):
    results = read_results(write_benchmark(folder, {"reach": (10, 10), "b": (2, 4)}))
    assert task_table(results)[1][0] == "reach *"
    assert float(results.interquartile_mean(without_development=True).value) == pytest.approx(0.3)


def test_what_took_longer_than_the_track_allows_is_marked(folder):
    slow = made_cell("a", 11, 10, train_cpu_s=301.0)
    results = read_results(write_benchmark(folder, {"a": (slow,)}))
    assert task_table(results)[1][-1] == "5.0 !"


def test_safe_success_is_told_beside_success(folder):
    rough = made_cell("a", 11, 10, safe_successes=4)
    results = read_results(write_benchmark(folder, {"a": (rough,)}))
    assert task_table(results)[1][1:4] == ["100.0 (72.2–100.0)", "100", "40.0"]


def test_tuning_runs_are_as_declared(folder, tmp_path):
    results = read_results(write_benchmark(folder, {"a": (1,)}, tuning_runs=84))
    none = read_results(write_benchmark(tmp_path / "other", {"a": (1,)}))
    assert [each.tuning_runs for each in (results, none)] == ["84", "not declared"]
    assert next(csv.DictReader(io.StringIO(as_csv([results]))))["tuning_runs"] == "84"


def test_a_report_has_a_page_a_picture_and_all_numbers(folder):
    results = read_results(write_benchmark(folder, {"a": (9, 2, 5), "reach": (1, 8, 3)}))
    files = write_report([results], folder)
    assert [file.name for file in files] == [
        *("README.md", "benchmark.png", "results.csv", "results.json")
    ]
    said = files[0].read_text()
    assert "taskbuilder benchmark made --track imitation --algorithm bc --seeds 11 12 13" in said
    assert "with\n  seeds from 3100000 on" in said
    assert "| a | 20 of 20 | 5.00 | – | – |" in said
    assert files[1].read_bytes().startswith(b"\x89PNG")
    rows = list(csv.DictReader(io.StringIO(files[2].read_text())))
    assert [row["success_at_end"] for row in rows] == ["0.9", "0.2", "0.5", "0.1", "0.8", "0.3"]
    data = json.loads(files[3].read_text())
    assert data["methods"][0]["tasks"][0]["median_seed"] == 13
    before = [file.read_bytes() for file in files]
    assert [file.read_bytes() for file in write_report([results], folder)] == before


def test_methods_stand_side_by_side(tmp_path):
    one = write_benchmark(tmp_path / "one", {"a": (9, 2), "b": (1, 8)})
    two = write_benchmark(tmp_path / "two", {"a": (10, 10), "b": (9, 9)})
    other = Method(algorithm="bc", settings=("noise=0.1",))
    three = write_benchmark(tmp_path / "three", {"a": (0, 0), "b": (0, 0)}, method=other)
    several = read_several([one, two, three, one])
    assert [each.name for each in several] == ["bc (one)", "bc (two)", "bc noise=0.1"]
    said = page(several)
    assert "| a | 20.0 (5.7–51.0) | 100.0 (72.2–100.0) | 0.0 (0.0–27.8) |" in said
    assert len(as_data(several)["methods"]) == 3


def test_the_page_says_that_policies_may_have_been_trained_in_any_way(folder):
    zoo = Method(policy="zoo:{task}/cloned")
    said = page([read_results(write_benchmark(folder, {"a": (10,)}, method=zoo))])
    assert "how they were trained is not known" in said
    assert "--policy 'zoo:{task}/cloned' --out repeated" in said


def test_different_tracks_are_not_comparable(tmp_path):
    one = write_benchmark(tmp_path / "one", {"a": (9,)})
    two = write_benchmark(tmp_path / "two", {"a": (9,)}, track=find_track("imitation", smoke=True))
    with pytest.raises(UsageError, match=r"is of made \(imitation, version 2\), and .* smoke"):
        read_several([one, two])


def test_different_tasks_are_not_comparable(tmp_path):
    one = write_benchmark(tmp_path / "one", {"a": (9,)})
    two = write_benchmark(tmp_path / "two", {"b": (9,)})
    with pytest.raises(UsageError, match="their tasks, variations or budgets differ"):
        read_several([one, two])


def test_a_smoke_version_is_marked_everywhere(folder):
    short = find_track("imitation", smoke=True)
    results = read_results(write_benchmark(folder, {"a": (9,)}, track=short))
    assert "not comparable" in page([results]).splitlines()[2]
    assert as_data([results])["comparable"] is False
    assert next(csv.DictReader(io.StringIO(as_csv([results]))))["comparable"] == "False"


def test_a_folder_without_a_benchmark_is_refused(tmp_path):
    with pytest.raises(UsageError, match="holds no benchmark; taskbuilder benchmark SUITE"):
        read_results(tmp_path)


def test_a_folder_of_another_version_is_refused(folder):
    write_benchmark(folder, {"a": (9,)})
    file = folder / "benchmark.json"
    file.write_text(file.read_text().replace('"taskbuilder": "', '"taskbuilder": "9.'))
    with pytest.raises(UsageError, match=r"was made by taskbuilder 9\..*not comparable"):
        read_results(folder)


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        ('"episodes": 10', '"episodes": 3', "it has more successes than episodes"),
        ('"episodes": 10', '"episodes": -3', "greater than or equal to 0"),
        ('"episodes": 10', '"episodes": "ten"', "episodes: Input should be a valid integer"),
        ('"seed": 11', '"seed": 12', "is of a, seed 12, and not of a, seed 11"),
        ("{", "", "is damaged"),
    ],
)
def test_a_damaged_cell_is_refused(folder, was, now, said):
    file = cell_folder(write_benchmark(folder, {"a": (9,)}), "a", 11) / CELL
    file.write_text(file.read_text().replace(was, now, 1))
    with pytest.raises(UsageError, match=said):
        read_results(folder)


@pytest.mark.parametrize("content", ["", "[]", '{"taskbuilder": 3}', '{"format": 2}'])
def test_a_damaged_folder_is_refused(folder, content):
    (write_benchmark(folder, {"a": (9,)}) / "benchmark.json").write_text(content)
    with pytest.raises(UsageError, match=r"benchmark.json is damaged|was made by taskbuilder 3"):
        read_results(folder)
