"""Every task of the library: sound, readable, and proved as it is."""

from __future__ import annotations

import json
from datetime import date
from pathlib import Path

import pytest

from taskbuilder import catalogue, load_task, validate_task
from taskbuilder.schema.proofs import proof_of
from taskbuilder.schema.suites import find_suites
from taskbuilder.versions import content_digest, history, read_versions

pytestmark = pytest.mark.in_process

ENTRIES = {name: entry for name, entry in catalogue().tasks.items() if entry.trusted}
TASKS = sorted(ENTRIES)
VERSIONS = read_versions(ENTRIES["handover"].root)
SUITES = find_suites(catalogue())
BY_SIZE = {1: "single", 2: "pairs", 3: "trios", 4: "quads"}

PROVED = Path(__file__).parents[2] / "benchmarks" / "results" / "proofs"


@pytest.mark.parametrize("name", TASKS)
def test_it_is_sound(name):
    report = validate_task(name, level="static")  # its committed proof has all levels
    assert report.findings == ()
    assert report.headline.startswith(f"{name} · ")


@pytest.mark.parametrize("name", TASKS)
def test_it_has_all_that_a_task_of_the_library_has(name):
    task = load_task(name)
    spec, description = task.file.spec, task.description
    assert len(task.file.scenes) >= 3
    assert len(set(spec.instructions)) == len(spec.instructions) >= 5
    assert len(spec.scene.cameras) >= 2
    assert spec.expert
    for part in ("failure", "progress", "setback"):
        assert getattr(description, part) is not None, part


@pytest.mark.parametrize("name", sorted(set(TASKS) - set(SUITES["seed"].tasks)))
def test_a_newcomer_can_read_it(name):
    entry = ENTRIES[name]
    assert len(entry.file.read_text(encoding="utf-8").splitlines()) <= 90
    assert len(entry.description_file.read_text(encoding="utf-8").splitlines()) <= 80


@pytest.mark.parametrize("name", TASKS)
def test_it_is_in_the_suite_of_its_number_of_robots(name):
    robots = len(load_task(name).agents)
    assert [suite for suite in BY_SIZE.values() if name in SUITES[suite].tasks] == [BY_SIZE[robots]]


@pytest.mark.parametrize("name", TASKS)
def test_it_has_been_proved_as_it_is(name):
    proof = proof_of(ENTRIES[name])
    assert proof, "run `python benchmarks/proofs.py`"
    assert proof.current, "its files have changed: run `python benchmarks/proofs.py`"
    measured = json.loads((PROVED / f"{name}.json").read_text(encoding="utf-8"))
    assert measured["ok"]
    assert measured["checksum"] == proof.checksum
    assert measured["making"]["level"] == "full"
    assert measured["making"]["seeds"] == proof.seeds >= 40
    (succeeded,) = (check for check in measured["checks"] if check["code"] == "TB531")
    assert succeeded["value"] >= 0.98


@pytest.mark.parametrize("name", TASKS)
def test_a_changed_task_has_a_new_version(name):
    file = load_task(name).file
    recorded = VERSIONS.get(name, {}).get(str(file.spec.version))
    assert recorded, "a new version: run `make docs`"
    assert recorded["content"] == content_digest(file), (
        "its scene, reward or success has changed: write the next version in the task file, "
        "then run `make docs`"
    )


@pytest.mark.parametrize("name", TASKS)
def test_the_last_version_of_a_task_is_that_of_today(name):
    numbers = [number for number, _ in history(VERSIONS, name)]
    assert numbers == [*range(1, load_task(name).version + 1)]
    days = [date.fromisoformat(version["since"]) for _, version in history(VERSIONS, name)]
    assert days == sorted(days)


@pytest.mark.parametrize("suite", sorted(SUITES))
def test_a_suite_tests_on_what_it_does_not_train_on(suite):
    found = SUITES[suite]
    train, test = set(found.train.variations), set(found.test.variations)
    assert not train & test
    for name in found.tasks:
        assert max(train | test) < len(load_task(name).file.scenes)
