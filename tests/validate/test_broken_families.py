"""A family of checks that an unexpected error ends is one failed family; the rest is reported."""

from __future__ import annotations

import json
import operator
import re
from xml.etree import ElementTree

import pytest

from taskbuilder import task, validate_task
from taskbuilder.cli import main, validate_command
from taskbuilder.errors import SimulationError
from taskbuilder.validate.checks import reset
from taskbuilder.validate.report import as_data

pytestmark = pytest.mark.in_process

# Functions of taskbuilder that something replaces by one that cannot take its arguments. No line
# of the description runs when it fails, so the description is not to blame.
DEFECT = """

import operator
from taskbuilder.validate.checks import {module}
{module}.{function} = operator.{by}
"""


@pytest.fixture
def broken(write, monkeypatch):
    """The small task, where the family `reset` has a defect."""
    monkeypatch.setattr(reset, "_Tally", operator.truediv)
    return write()


def the_finding(report):
    (finding,) = report.findings
    assert finding.code == "TB317"
    assert (finding.location.file.name, finding.location.line) == ("small.yaml", 1)
    return finding


def test_one_family_fails_and_the_others_are_there(broken):
    report = validate_task(broken, level="build", seeds=2)
    assert [(family.name, family.ok) for family in report.families] == [
        ("static", True),
        ("build", True),
        ("reset", False),
    ]
    message = the_finding(report).message
    assert message.startswith("the check itself failed: TypeError: truediv expected 2 arguments")
    assert message.endswith(
        "a defect of taskbuilder, not of the task: please report it, with the traceback that "
        "--debug shows"
    )
    assert re.match(r"Traceback(.|\n)*reset.py", report.families[-1].trace)


@pytest.mark.parametrize("jobs", [1, 2])
def test_so_it_is_in_other_processes(jobs, write_pair):
    text = DEFECT.format(module="necessity", function="play_random", by="truediv")
    file = write_pair(("class Pair", text + "\n\nclass Pair"))
    only = ("needs its robots", "cost")
    report = validate_task(file, seeds=2, jobs=jobs, only=only, apart=True)
    assert {family.name: family.ok for family in report.families} == {
        "static": True,
        "needs its robots": False,
        "cost": True,
    }
    (finding,) = report.findings
    assert "truediv() takes no keyword arguments" in finding.message
    assert "necessity.py" in report.families[1].trace


def test_a_defect_in_reading_is_a_finding_and_other_tasks_are_validated(
    write, tmp_path, capfd, monkeypatch
):
    file = write()
    other = tmp_path / "other.yaml"
    other.write_text(file.read_text().replace("task: small", "task: other"))
    other.with_suffix(".py").write_text(file.with_suffix(".py").read_text())
    check = task.check_description

    def checked(description, *rest):
        if description.__module__.startswith("taskbuilder_task_small"):
            raise ZeroDivisionError("division by zero")
        return check(description, *rest)

    monkeypatch.setattr(task, "check_description", checked)
    words = ["validate", str(file), str(other), "--level", "static", "--jobs", "1"]
    assert main(words) == 1
    printed = capfd.readouterr().out
    assert "error[TB317] the check itself failed: ZeroDivisionError: division by zero" in printed
    assert "other · 1 robot" in printed


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (
            OSError(28, "No space left on device"),
            "the check could not be made: OSError: [Errno 28]",
        ),
        (MemoryError(), "the check could not be made: MemoryError; run it again"),
        (SimulationError("the renderer is gone"), "the check could not be made: the renderer is"),
    ],
)
def test_what_is_no_defect_is_not_called_one(error, message, write, monkeypatch):
    def fails(*_):
        raise error

    monkeypatch.setattr(reset, "_Tally", fails)
    finding = the_finding(validate_task(write(), level="build", seeds=2))
    assert finding.message.startswith(message)
    assert "defect" not in finding.message


class TestFormats:
    """Each format of reports shows what failed, and what did not."""

    def run(self, broken, capfd, *more):
        status = main(["validate", str(broken), "--level", "build", "--quick", *more])
        assert status == 1
        return capfd.readouterr()

    def test_text(self, broken, capfd):
        printed = self.run(broken, capfd)
        lines = printed.out.splitlines()
        assert any(line.split()[:2] == ["build", "ok"] for line in lines)
        assert any(line.split()[:2] == ["reset", "FAIL"] for line in lines)
        assert "small.yaml:1:1: error[TB317] the check itself failed" in printed.out
        assert "Traceback" not in printed.out + printed.err

    def test_text_with_debug(self, broken, capfd):
        printed = self.run(broken, capfd, "--debug")
        assert "error[TB317]" in printed.out
        assert "small: reset:\nTraceback (most recent call last):" in printed.err

    def test_json(self, broken, capfd):
        data = json.loads(self.run(broken, capfd, "--format", "json").out)
        assert (data["complete"], data["ok"]) == (True, False)
        (task,) = data["tasks"]
        assert [finding["code"] for finding in task["findings"]] == ["TB317"]
        assert {check["family"] for check in task["checks"]} >= {"static", "build", "reset"}
        assert task["measures"]["build_s"] > 0
        assert list(task["tracebacks"]) == ["reset"]

    def test_junit(self, broken, capfd):
        top = ElementTree.fromstring(self.run(broken, capfd, "--format", "junit").out)
        assert (top.get("errors"), top.get("failures")) == ("1", "0")
        (error,) = top.iter("error")
        assert error.get("type") == "TB317"
        assert error.text.startswith("Traceback")

    def test_github(self, broken, capfd):
        printed = self.run(broken, capfd, "--format", "github").out
        assert "title=TB317::the check itself failed: TypeError" in printed

    def test_a_page(self, broken, tmp_path, capfd):
        self.run(broken, capfd, "--report", str(tmp_path / "pages"))
        page = (tmp_path / "pages" / "small.html").read_text()
        assert "The check itself failed" in page
        assert "Traceback (most recent call last)" in page
        assert "data:image/jpeg" in page


def test_a_page_that_cannot_be_written_costs_no_result(write, tmp_path, capfd, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device", "small.html")

    monkeypatch.setattr("taskbuilder.validate.html.files.write_whole", full)
    words = ["validate", str(write()), "--level", "static", "--format", "json"]
    assert main([*words, "--report", str(tmp_path / "pages")]) == 2
    printed = capfd.readouterr()
    assert json.loads(printed.out)["ok"]
    assert printed.err.endswith("taskbuilder: small.html: No space left on device\n")


@pytest.mark.parametrize("form", ["json", "junit"])
def test_an_interrupted_validation_reports_the_tasks_that_are_done(
    form, write, tmp_path, capfd, monkeypatch
):
    file = write()
    validate = validate_command.validate_task

    def interrupted(name, **options):
        if name != str(file):
            raise KeyboardInterrupt
        return validate(name, **options)

    monkeypatch.setattr(validate_command, "validate_task", interrupted)
    words = ["validate", str(file), "reach", "--level", "static", "--jobs", "1", "--format", form]
    assert main(words) == 130
    printed = capfd.readouterr().out
    if form == "json":
        data = json.loads(printed)
        assert (data["complete"], data["ok"]) == (False, False)
        assert [task["task"] for task in data["tasks"]] == ["small"]
    else:
        (suite,) = ElementTree.fromstring(printed)
        assert suite.get("name") == "small"


def test_data_of_all_reports_is_complete(validate):
    data = as_data([validate(level="static")])
    assert (data["complete"], data["ok"], data["tasks"][0]["tracebacks"]) == (True, True, {})
