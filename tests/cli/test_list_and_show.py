"""`taskbuilder list`, `show` and `schema`."""

from __future__ import annotations

import functools
import json
import shutil
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest
import yaml

from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.load import read_task
from taskbuilder.schema.source import read_source

TASKS = sorted(Catalogue.discover().tasks)


def test_list_shows_every_task_of_the_catalogue(run):
    ran = run("list")
    assert (ran.status, ran.err) == (0, "")
    head, *rows = ran.out.splitlines()
    assert head.split() == ["task", "robots", "steps", "proved", "summary"]
    assert [row.split()[0] for row in rows] == TASKS


def test_list_as_json_has_the_documented_shape(run):
    (handover,) = [
        task for task in run("list", "--json").data["tasks"] if task["name"] == "handover"
    ]
    assert set(handover) == {
        *("name", "version", "path", "robots", "objects", "episode_steps", "summary"),
        *("proof", "suites"),
    }
    assert handover["objects"] == ["table", "stick", "obstacle"]
    assert handover["suites"] == ["seed", "pairs"]
    assert handover["proof"]["seeds"] == 40
    assert handover["robots"] == {"left": "ur5e", "right": "ur5e"}
    assert handover["episode_steps"] == 50
    assert Path(handover["path"]).name == "handover.yaml"


def test_list_shows_the_tasks_of_a_suite(run):
    _, *rows = run("list", "--suite", "seed").out.splitlines()
    assert [row.split()[0] for row in rows] == ["pick_push_place", "collaborative_lift", "handover"]
    assert run("list", "--suite", "seed", "--json").data["suite"]["train"]["variations"] == [0, 1]
    assert run("list", "--suite", "sed").err.endswith('no suite "sed"; did you mean "seed"?\n')


def test_list_says_which_tasks_have_changed_since_their_proof(run, monkeypatch):
    monkeypatch.setattr("taskbuilder.schema.proofs.checksum", lambda _: "")
    rows = run("list", "--suite", "seed").out
    assert rows.count("before a change") == 3


def test_list_names_what_is_broken_and_goes_on(run, broken):
    listed = run("list", "--json", "--task-path", ".").data["tasks"]
    assert {task["name"] for task in listed} == {*TASKS, "broken"}
    (entry,) = [task for task in listed if task["name"] == "broken"]
    assert (entry["robots"], entry["episode_steps"]) == ({}, None)
    ran = run("list", "--task-path", ".")
    assert ran.status == 0
    *_, row, _, hint = ran.out.splitlines()
    assert row.split() == ["broken", "-", "-", "-", "(has", "errors)"]
    assert hint == "to see what is wrong: taskbuilder validate broken"


@pytest.mark.parametrize("variable", [True, False], ids=["variable", "option"])
def test_a_folder_of_tasks_is_searched(variable, run, good, monkeypatch):
    if variable:
        monkeypatch.setenv("TASKBUILDER_PATH", str(good.parent))
    words = () if variable else ("--task-path", ".")
    assert "One arm lifts a cube." in run("list", *words).out
    assert run("show", "good", *words).out.startswith("task: good\n")


@pytest.mark.parametrize("task", TASKS)
def test_what_show_prints_is_the_same_task(task, run, tmp_path):
    catalogue = Catalogue.discover()
    shutil.copytree(catalogue.task(task).root / "objects", tmp_path / "objects")  # what it names
    shown = tmp_path / f"{task}.yaml"
    shown.write_text(run("show", task).out)
    again = read_task(CatalogueEntry(task, shown), catalogue)
    plain = read_task(catalogue.task(task), catalogue)
    observe = again.spec.observe
    assert again.spec == plain.spec.model_copy(update={"observe": observe})
    assert plain.spec.observe in (None, observe)
    assert again.scenes == plain.scenes
    assert run("show", str(shown)).out == shown.read_text()


def test_show_fills_in_the_defaults(run, good):
    shown = yaml.safe_load(run("show", "good.yaml").out)
    assert shown["timing"]["episode_steps"] == 50
    assert shown["scene"]["objects"]["cube"]["friction"] == 0.8
    assert "time_left" in shown["observe"]["arm"]


@pytest.mark.parametrize("task", TASKS)
def test_the_schema_takes_every_task(task):
    data = read_source(Catalogue.discover().task(task).file).data
    listed = yaml.safe_load(yaml.safe_dump(_plain(data)))
    printed_schema("task").validate(listed)


def test_the_schema_of_robots_takes_every_robot():
    for entry in Catalogue.discover().robots.values():
        data = _plain(read_source(entry.file).data)
        printed_schema("robot").validate(data)


@functools.cache  # checking the schema takes longer than checking a file
def printed_schema(sort: str) -> jsonschema.Draft202012Validator:
    words = [sys.executable, "-P", "-m", "taskbuilder", "schema", sort]
    schema = json.loads(subprocess.run(words, capture_output=True, check=True).stdout)
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def _plain(data):
    if isinstance(data, dict):
        return {key: _plain(value) for key, value in data.items()}
    return [_plain(item) for item in data] if isinstance(data, tuple) else data
