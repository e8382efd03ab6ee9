"""The README's example is a sound task, and its error output is real."""

from __future__ import annotations

import json
import re
import textwrap
from pathlib import Path

import pytest

from taskbuilder import validate_task

README = Path(__file__).resolve().parents[2] / "README.md"


def blocks(language: str) -> list[str]:
    text = README.read_text(encoding="utf-8")
    found = re.findall(rf"^( *)```{language}\n(.*?)^ *```$", text, re.MULTILINE | re.DOTALL)
    return [textwrap.dedent(block) for _, block in found]


@pytest.fixture
def task(tmp_path: Path) -> Path:
    """The example's task file, with its description beside it."""
    (scene,), (description, _) = blocks("yaml"), blocks("python")
    name = re.match(r"task: (\w+)", scene)[1]
    (tmp_path / f"{name}.py").write_text(description)
    (tmp_path / f"{name}.yaml").write_text(scene)
    return tmp_path / f"{name}.yaml"


@pytest.mark.parametrize("only", [("solvable",), pytest.param(None, marks=pytest.mark.slow)])
def test_the_example_is_sound(only, task):
    report = validate_task(task, seeds=2, only=only)
    assert report.ok
    assert report.findings == ()


def test_the_error_output_is_real(task, monkeypatch):
    monkeypatch.chdir(task.parent)
    (shown,) = blocks("text")
    slips = (
        (task, "left: {model:", "left: {modle:"),
        (task.with_suffix(".py"), '~Held("stick"', '~Held("stik"'),
    )
    for file, right, wrong in slips:
        file.write_text(file.read_text().replace(right, wrong, 1))
    found = validate_task(task.name, level="static").findings
    assert [str(finding) for finding in found] == shown.splitlines()


@pytest.mark.slow
def test_its_lines_of_python_demonstrate_train_and_evaluate(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    _, lines = blocks("python")
    assert len(lines.strip().splitlines()) <= 10
    exec(lines, {})  # the README's own
    shown = capsys.readouterr().out.split()
    assert shown[0] == "True"
    assert all(0.0 <= float(rate) <= 1.0 for rate in shown[-2:])
    assert (tmp_path / "runs" / "tried" / "policy.npz").exists()


def test_it_has_the_two_blocks_that_are_run_as_they_are():
    main, tests = blocks("(?:sh|bash|shell)")
    assert "validate --suite seed" in main
    assert "demo handover --video --out demos" in main
    assert "pytest" in tests


def test_its_links_lead_somewhere():
    targets = re.findall(r"\]\((?!https?:)([^)#]+)", README.read_text(encoding="utf-8"))
    assert targets
    assert [target for target in targets if not (README.parent / target).exists()] == []


def test_it_tells_how_many_proved_tasks_the_library_has():
    told = re.search(r"library of (\d+) proved tasks", README.read_text(encoding="utf-8"))
    proofs = json.loads((README.parent / "tasks" / "proofs.json").read_text(encoding="utf-8"))
    assert told
    assert int(told[1]) == len(proofs)
