"""`taskbuilder validate`: how it reports."""

from __future__ import annotations

import io
import sys

import pytest

TASK_KEYS = {"task", "ok", "findings", "checks", "measures"}
FINDING_KEYS = {"code", "severity", "message", "file", "line", "column", "path"}
CHECK_KEYS = {"code", "family", "name", "ok", "value", "limit", "unit"}
STATIC = ("validate", "--level", "static", "--format", "json")


class Terminal(io.StringIO):
    """Text that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_a_table_says_what_was_measured(run, good):
    ran = run("validate", "good.yaml", "--quick")
    assert (ran.status, ran.err) == (0, "")
    lines = ran.out.splitlines()
    assert lines[0] == "good · 1 robot · 1 object · 50 steps at 10 Hz · good.yaml"
    families = [line.split()[:2] for line in lines if line.startswith("  ")]
    assert families[:3] == [["static", "ok"], ["build", "ok"], ["reset", "ok"]]
    assert lines[-1].startswith("ok in ")


def test_json_has_one_shape_for_one_task_and_for_many(run, good, broken):
    one = run(*STATIC, "good.yaml")
    many = run(*STATIC, "good.yaml", "broken.yaml")
    assert (one.status, many.status) == (0, 1)
    assert (one.err, many.err) == ("", "")
    assert set(one.data) == set(many.data) == {"version", "ok", "tasks"}
    assert (one.data["ok"], many.data["ok"]) == (True, False)
    assert one.data["tasks"] == many.data["tasks"][:1]
    for task in many.data["tasks"]:
        assert set(task) == TASK_KEYS
        assert all(set(check) == CHECK_KEYS for check in task["checks"])


def test_a_finding_in_json_is_placed(run, broken):
    (finding,) = run(*STATIC, "broken.yaml").data["tasks"][0]["findings"]
    assert set(finding) == FINDING_KEYS
    assert finding["file"] == "broken.yaml"
    assert (finding["line"], finding["column"]) == (7, 52)
    assert (finding["code"], finding["severity"]) == ("TB103", "error")
    assert finding["path"] == "scene.objects.cube.mass"


def test_levels_add_families(run, good):
    def families(*words):
        checks = run("validate", "good.yaml", "--format", "json", *words).data["tasks"][0]["checks"]
        return list(dict.fromkeys(check["family"] for check in checks))

    assert families("--level", "static") == ["static"]
    assert families("--level", "build", "--quick") == ["static", "build", "reset"]


def test_all_is_every_task_of_the_catalogue(run):
    ran = run(*STATIC, "--all")
    listed = run("list", "--json").data["tasks"]
    assert [task["task"] for task in ran.data["tasks"]] == [task["name"] for task in listed]
    assert ran.status == 0


def test_a_task_named_twice_is_validated_once(run, good):
    assert len(run(*STATIC, "good.yaml", "good.yaml").data["tasks"]) == 1


def test_what_a_description_prints_stays_out_of_json(run, good):
    file = good.with_suffix(".py")
    printing = "import os\n\nprint('from Python')\nos.write(1, b'from C')\nimport pybullet\n"
    file.write_text(printing + file.read_text())
    ran = run(*STATIC, "good.yaml")
    assert ran.data["ok"]
    assert "from Python" in ran.err
    assert "from C" in ran.err


def test_colour_is_for_terminals_that_want_it(run, good, monkeypatch):
    def text(**environment):
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        with monkeypatch.context() as patch:
            terminal = Terminal()
            patch.setattr(sys, "stdout", terminal)
            run("validate", "good.yaml", "--level", "static")
        return terminal.getvalue()

    monkeypatch.delenv("NO_COLOR", raising=False)
    assert "\x1b[" in text()
    assert "\x1b[" in text(NO_COLOR="")
    assert "\x1b[" not in text(NO_COLOR="1")
    assert "\x1b[" not in run("validate", "good.yaml", "--level", "static").out


def test_progress_is_for_terminals(run, good, monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    ran = run("validate", "good.yaml", "--seeds", "800", "--format", "json")
    assert ran.data["ok"]
    assert "reset" in terminal.getvalue()


@pytest.mark.parametrize("debug", [True, False])
def test_a_defect_asks_to_be_reported_and_shows_where_on_request(debug, run, good, monkeypatch):
    def fail(*_, **__):
        raise ZeroDivisionError("all is lost")

    monkeypatch.setattr("taskbuilder.cli.validate_command.validate_task", fail)
    if debug:
        with pytest.raises(ZeroDivisionError):
            run("validate", "good.yaml", "--debug")
        return
    ran = run("validate", "good.yaml")
    assert ran.status == 70
    assert "a defect of taskbuilder itself: ZeroDivisionError: all is lost" in ran.err
    assert "--debug" in ran.err
