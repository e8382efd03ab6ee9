"""What a training run wrote is read again, as far as it has come, or refused by its line."""

from __future__ import annotations

import gzip
import json
import sys

import numpy as np
import pytest
from made_runs import write_run

from taskbuilder.errors import UsageError
from taskbuilder.learn.logger import RunLogger
from taskbuilder.learn.logs import LogError, read_run
from taskbuilder.learn.plan import Plan, save_plan


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return write_run(tmp_path / "run", seed=4, demos=50)


def test_a_run_is_read_whole(run):
    found = read_run(run)
    assert (found.folder, found.stages) == (run, ("begun", "there"))
    assert (found.plan.task, found.plan.seed, found.plan.demos) == ("sideways", 4, 50)
    assert found.episodes["step"].tolist() == list(range(20, 20_001, 20))
    assert list(found.episodes)[-2:] == ["term/reach/arm", "term/there"]
    assert found.evaluations["step"].tolist() == list(range(2_000, 20_001, 2_000))
    counts = [found.evaluations[f"stage/{stage}"] for stage in range(3)]
    assert (sum(counts) == 20.0).all()
    assert np.isnan(found.updates["actor"]).all()  # a learner that diverged is no damage


def test_what_training_writes_is_read(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)  # TensorBoard is not needed here
    save_plan(tmp_path, Plan("sideways"), {"stages": ["begun"]})
    journal = RunLogger(tmp_path, {}, 0)
    row = {"episode": 3, "episodes": 20, "success_rate": 0.35, "stage/0": 13, "stage/1": 7}
    journal.add("evaluations", 1_000, row)
    journal.add("evaluations", 2_000, {**row, "success_rate": 1 / 3})
    journal.close()
    found = read_run(tmp_path).evaluations
    assert found["step"].tolist() == [1_000, 2_000]
    assert found["success_rate"] == pytest.approx([0.35, 1 / 3], abs=1e-6)


def test_tables_that_are_not_there_yet_have_no_rows(run):
    for name in ("episodes", "evaluations", "updates"):
        (run / f"{name}.csv").unlink()
    found = read_run(run)
    assert [len(t["step"]) for t in (found.episodes, found.evaluations, found.updates)] == [0] * 3
    (run / "episodes.csv").write_text("")
    (run / "evaluations.csv").write_text("step,epi")
    assert len(read_run(run).episodes["team_return"]) == 0


def test_a_line_that_is_still_being_written_is_left_out(run):
    whole = (run / "episodes.csv").read_text()
    expected = read_run(run).episodes["team_return"]
    for cut in (1, 2, 9):  # the end of the line; a digit, so that a number would be another
        (run / "episodes.csv").write_text(whole[:-cut])
        assert read_run(run).episodes["team_return"].tolist() == expected[:-1].tolist()


def changed(line, change):
    """A change of one line, counted from 1."""

    def apply(text):
        lines = text.split("\n")
        lines[line - 1] = change(lines[line - 1])
        return "\n".join(lines)

    return apply


@pytest.mark.parametrize(
    ("table", "change", "message"),
    [
        (
            "episodes",
            changed(17, lambda line: line.replace("320,", "three,", 1)),
            'run/episodes.csv:17: step is "three", which is no number',
        ),
        (
            "episodes",
            changed(5, lambda line: line.rpartition(",")[0]),
            "run/episodes.csv:5: has 8 values for 9 columns",
        ),
        (
            "episodes",
            changed(5, lambda line: ""),
            "run/episodes.csv:5: has 0 values for 9 columns",
        ),
        (
            "episodes",
            changed(1001, lambda line: line.rpartition(",")[0] + ",nan"),
            'run/episodes.csv:1001: term/there is "nan", which is no number',
        ),
        (
            "episodes",
            changed(9, lambda line: "40" + line[3:]),
            "run/episodes.csv:9: step 40 comes after 140",
        ),
        (
            "evaluations",
            changed(1, lambda line: line.replace("success_rate", "success")),
            "run/evaluations.csv:1: has no column success_rate; the columns are step, episode, "
            "episodes, success, team_return, steps_to_success, stage/0, stage/1, stage/2",
        ),
        (
            "updates",
            changed(2, lambda line: "?" + line),
            'run/updates.csv:2: step is "?1000", which is no number',
        ),
        (
            "evaluations",
            changed(3, lambda line: line + "," + "9" * 200_000),
            "run/evaluations.csv:3: field larger than field limit (131072)",
        ),
    ],
)
def test_damage_is_told_by_its_line(table, change, message, run):
    path = run / f"{table}.csv"
    path.write_text(change(path.read_text()))
    with pytest.raises(LogError) as error:
        read_run(run)
    assert str(error.value) == message


def test_bytes_that_are_no_text_are_told_by_their_line(run):
    content = (run / "episodes.csv").read_bytes().split(b"\n")
    content[41] = b"\xff\xfe" + content[41]
    (run / "episodes.csv").write_bytes(b"\n".join(content))
    with pytest.raises(LogError, match=r"^run/episodes\.csv:42: is no text$"):
        read_run(run)


def test_what_is_no_run_is_refused(run, tmp_path):
    with pytest.raises(UsageError, match="nowhere is no training run"):
        read_run(tmp_path / "nowhere")
    about = json.loads((run / "run.json").read_text())
    (run / "run.json").write_text(json.dumps({**about, "format": 2}))
    with pytest.raises(UsageError, match="run is a run of format 2; this version reads 1"):
        read_run(run)


def test_a_table_may_be_compressed(run):
    before = read_run(run).episodes
    file = run / "episodes.csv"
    packed = gzip.compress(file.read_bytes())
    file.unlink()
    (run / "episodes.csv.gz").write_bytes(packed)
    after = read_run(run).episodes
    assert list(after) == list(before)
    assert all(np.array_equal(after[name], before[name]) for name in before)
    for damaged in (packed[:-20], b"no gzip", packed[:40] + b"x" * 40 + packed[80:]):
        (run / "episodes.csv.gz").write_bytes(damaged)
        with pytest.raises(LogError, match=r"episodes\.csv\.gz is damaged"):
            read_run(run)
