"""Following the quickstart leads to a sound task."""

from __future__ import annotations

import re
import textwrap

import pytest
from written_pages import written

from taskbuilder import validate_task
from taskbuilder.cli import main

PAGE = written("quickstart.md")


@pytest.mark.slow
def test_the_change_that_the_page_proposes_is_sound(tmp_path):
    ((addition, expert), (at_goal, _)) = (
        re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.M | re.S)
        for language in ("yaml", "python")
    )
    assert main(["new", "stack_cubes", "--dir", str(tmp_path)]) == 0
    scene, description = tmp_path / "stack_cubes.yaml", tmp_path / "stack_cubes.py"
    changed = re.sub(r"(  objects:.*\n)", rf"\1{addition}", scene.read_text())
    scene.write_text(re.sub(r"^expert:.*\n(  - .*\n)+", expert, changed, flags=re.M))
    changed = re.sub(r"    at_goal = .*\n", at_goal, description.read_text())
    description.write_text(changed)
    report = validate_task(scene, seeds=3)
    assert report.findings == ()
    assert textwrap.dedent(at_goal) in textwrap.dedent(changed).replace("\n    ", "\n")


def test_the_loop_that_the_page_shows_runs(tmp_path, monkeypatch):
    loop = re.findall(r"^```python\n(.*?)^```$", PAGE, re.M | re.S)[-1]
    assert main(["new", "stack_cubes", "--dir", str(tmp_path)]) == 0
    monkeypatch.chdir(tmp_path)
    scope: dict[str, object] = {}
    exec(loop, scope)
    assert set(scope["rewards"]) == {"left", "right"}
