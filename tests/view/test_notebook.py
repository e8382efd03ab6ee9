"""Episodes in cells of a notebook, and the notebook of the examples."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path

import pytest

import taskbuilder
from taskbuilder.errors import UnknownNameError

NOTEBOOK = Path(__file__).resolve().parents[2] / "examples" / "first_hour.ipynb"


class Frame(HTMLParser):
    """The attributes of the frame in a cell."""

    def handle_starttag(self, tag, attrs):
        self.tag, self.attributes = tag, dict(attrs)


@pytest.fixture(scope="module")
def shown():
    return taskbuilder.show("reach", seed=2)


def test_a_cell_has_the_whole_page_in_a_frame(shown):
    cell = Frame()
    cell.feed(shown._repr_html_())
    assert cell.tag == "iframe"
    assert cell.attributes["srcdoc"] == shown.html
    assert cell.attributes["title"] == shown.title
    assert "success after" in shown.title
    assert len(repr(shown)) < 100


def test_a_page_is_saved(shown, tmp_path):
    shown.save(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == shown.html


def test_a_loaded_task_is_shown_as_its_name_is(shown):
    assert taskbuilder.show(taskbuilder.load_task("reach"), "hold").title != shown.title


def test_what_is_not_there_is_said():
    with pytest.raises(UnknownNameError, match='did you mean "reach"'):
        taskbuilder.show("reahc")


def test_the_notebook_runs_from_the_first_cell_to_the_last(tmp_path, monkeypatch, capsys):
    pytest.importorskip("torch")
    monkeypatch.chdir(tmp_path)
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    names: dict[str, object] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == []
            exec("".join(cell["source"]), names)  # as Jupyter does, without its packages
    printed = capsys.readouterr().out
    assert "error[TB103] expert[3].left" in printed
    assert printed.splitlines()[-1] == "1.0 1.0"
