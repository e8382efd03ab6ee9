"""What `list` says of tasks is what their files say, with an index or without."""

from __future__ import annotations

import json

import pytest

from taskbuilder._library import folder
from taskbuilder.schema import summaries
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.index import index_text
from taskbuilder.schema.load import read_task
from taskbuilder.schema.summaries import INDEX, TaskSummary, summarize

TASKS = folder("tasks")


def test_the_index_is_true():
    written = (TASKS / INDEX).read_text(encoding="utf-8")
    assert written == index_text(TASKS), "run `make docs`, which writes it anew"


@pytest.mark.parametrize("name", sorted(Catalogue().tasks))
def test_the_index_says_what_the_file_says(name, monkeypatch):
    catalogue = Catalogue()
    spec = read_task(catalogue.task(name), catalogue).spec
    monkeypatch.setattr(summaries, "read_summary", None)  # the index is enough
    summary = summarize(catalogue.task(name), catalogue)
    assert summary.summary == spec.summary
    assert summary.episode_steps == spec.timing.episode_steps
    assert summary.robots == {name: robot.model for name, robot in spec.scene.robots.items()}


@pytest.fixture
def copied(tmp_path) -> CatalogueEntry:
    """A packaged task with an index, which says something else than the file."""
    for suffix in (".yaml", ".py"):
        text = (TASKS / f"handover{suffix}").read_text(encoding="utf-8")
        (tmp_path / f"handover{suffix}").write_text(text, encoding="utf-8")
    index = json.loads((TASKS / INDEX).read_text(encoding="utf-8"))
    index["handover"]["summary"] = "As the index has it."
    (tmp_path / INDEX).write_text(json.dumps(index), encoding="utf-8")
    return CatalogueEntry("handover", tmp_path / "handover.yaml", "other.handover", trusted=True)


def test_a_file_that_has_changed_is_read(copied):
    assert summarize(copied, Catalogue()).summary == "As the index has it."
    text = copied.file.read_text(encoding="utf-8").replace("summary: ", "summary: Changed. ")
    copied.file.write_text(text, encoding="utf-8")
    assert summarize(copied, Catalogue()).summary.startswith("Changed. ")


def test_an_index_that_cannot_be_read_is_none(copied):
    (copied.root / INDEX).write_text("{", encoding="utf-8")
    assert summarize(copied, Catalogue()).summary.startswith("The left arm")


def test_a_task_with_errors_says_so(copied):
    copied.file.write_text("task: handover\n", encoding="utf-8")
    assert summarize(copied, Catalogue()) == TaskSummary()
