"""Reports as a whole: over the catalogue, by level, twice."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path

import pytest

from taskbuilder import catalogue, validate_task
from taskbuilder.description.load import try_import
from taskbuilder.errors import UnknownNameError
from taskbuilder.validate.report import as_data

pytestmark = pytest.mark.in_process


def test_a_family_is_not_run_where_the_fault_of_another_would_show_again(validate):
    def families(report):
        return [family.name for family in report.families], report.skipped

    assert families(validate(("mass: 0.1", "mass: heavy"))) == (["static"], ())
    in_the_air = validate(("[0.5, 0, 0.0205]", "[0.5, 0, 2]"))
    assert families(in_the_air) == (["static", "build"], ("reset",))
    assert families(validate()) == (["static", "build", "reset"], ())


def test_a_level_goes_no_further_than_asked(write):
    file = write()
    assert len(validate_task(file, level="static", seeds=1).families) == 1
    assert len(validate_task(file, level="build", seeds=1).families) == 3


def test_what_was_measured_is_reported(validate):
    report = validate()
    assert report.measures["build_s"] > 0
    assert report.measures["reset_ms"] > 0
    assert all(family.seconds >= 0 for family in report.families)


def test_the_same_task_gets_the_same_verdict_and_figures():
    one, two = (
        as_data([validate_task("handover", seeds=5, level="build")])["tasks"][0] for _ in range(2)
    )
    assert one["checks"] == two["checks"]
    assert one["findings"] == two["findings"]
    assert one["measures"].keys() == two["measures"].keys()


def test_a_task_is_found_by_name_and_by_path():
    by_name = validate_task("handover", level="static")
    by_path = validate_task(Path(catalogue().task("handover").file), level="static")
    assert (by_name.task, by_name.headline) == (by_path.task, by_path.headline)


def test_a_task_that_is_not_there_cannot_be_asked_about():
    with pytest.raises(UnknownNameError, match="did you mean"):
        validate_task("handovr")


def test_a_task_that_does_not_load_is_reported_by_what_was_asked_for(validate, write):
    report = validate(("mass: 0.1", "mass: heavy"))
    assert report.task == report.headline == str(write())
    assert report.families[0].summary == "1 error"


def test_progress_is_told_of_every_seed(write):
    told = []

    def progress(items, label):
        for item in items:
            told.append((label, item))
            yield item

    file = write(add="variations:\n  - {cube.color: green}\n")
    validate_task(file, seeds=2, level="build", progress=progress)
    assert [item for item in told if item[0].startswith("reset")] == [
        ("reset", 0),
        ("reset", 1),
        ("reset, variation 1", 0),
        ("reset, variation 1", 1),
    ]


def test_a_description_that_hangs_is_given_up(write, monkeypatch):
    file = write(("class Small", "while True:\n    pass\n\n\nclass Small"))
    monkeypatch.setattr("taskbuilder.task.try_import", partial(try_import, limit_s=1.5))
    started = time.monotonic()
    report = validate_task(file, level="static")
    (finding,) = [f for f in report.findings if f.code == "TB213"]
    assert str(finding.location.file).endswith("small.py")
    assert "did not end within 1.5 s" in finding.message
    assert time.monotonic() - started < 120
