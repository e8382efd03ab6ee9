"""Pages are made in another process, which a description can end without harm."""

from __future__ import annotations

from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.validate.html.page import make_page
from taskbuilder.validate.html.templates import task_page
from taskbuilder.validate.runner import validate_task

DESCRIPTION = """
import os
from taskbuilder.description import Above, Bonus, Description
{body}

class Apart(Description):
    success = Above("cube", height=0.2)
    reward = (Bonus("done", success, 1.0),)
"""
TASK = """
task: apart
summary: One arm lifts a cube.
scene:
  robots: {arm: {model: ur5e, base: {position: [0, 0, 0]}}}
  objects: {cube: {shape: {box: [0.1, 0.1, 0.1]}, mass: 0.1, position: [0.5, 0, 0.05]}}
"""


def page_of(folder, body):
    file = folder / "apart.yaml"
    file.write_text(TASK)
    file.with_suffix(".py").write_text(DESCRIPTION.format(body=""))
    report = validate_task(file, level="static")
    file.with_suffix(".py").write_text(DESCRIPTION.format(body=body))
    return make_page(str(file), report, Catalogue.discover(), apart=True)


def test_a_page_comes_from_another_process(tmp_path):
    page = page_of(tmp_path, "")
    assert page.summary == "One arm lifts a cube."
    assert "One arm lifts a cube." in task_page(page)


def test_a_page_of_what_ends_its_process_is_a_page_without_pictures(tmp_path):
    page = page_of(tmp_path, "os._exit(0)")
    assert "The process that takes them ended with status 0." in task_page(page)
