"""`taskbuilder validate`: how it reports."""

from __future__ import annotations

import io
import re
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

import taskbuilder
from taskbuilder.processes import cores
from taskbuilder.validate.formats import DOCUMENTS
from taskbuilder.validate.report import TaskReport

pytestmark = pytest.mark.in_process

PAGE = Path(__file__).resolve().parents[2] / "docs" / "validation.md"
TASK_KEYS = {"task", "ok", "making", "findings", "families", "skipped", "checks", "measures"}
TASK_KEYS |= {"probes", "tracebacks"}
FINDING_KEYS = {"code", "severity", "message", "file", "line", "column", "path", "fix"}
CHECK_KEYS = {"code", "family", "name", "ok", "value", "limit", "unit"}
STATIC = ("validate", "--level", "static", "--format", "json")


def undated(ran):
    """The tasks of a report in JSON, less when and how fast each was validated."""
    return [task | {"making": {}, "families": []} for task in ran.data["tasks"]]


class Terminal(io.StringIO):
    """Text that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def no_trial(monkeypatch):
    """Descriptions are not tried in a child process first, which takes a second each."""
    monkeypatch.setattr("taskbuilder.task.try_import", lambda _: None)


def test_a_table_says_what_was_measured(run, good):
    ran = run("validate", "good.yaml", "--quick", "--level", "build")
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
    assert set(one.data) == set(many.data) == {"version", "ok", "complete", "tasks"}
    assert (one.data["ok"], many.data["ok"]) == (True, False)
    assert one.data["complete"]
    assert many.data["complete"]
    assert undated(one) == undated(many)[:1]
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


@pytest.mark.parametrize("form", ["text", "json", "github", *DOCUMENTS])
def test_every_format_speaks_of_the_task_and_is_on_the_page(form, run, broken):
    ran = run("validate", "--level", "static", "--format", form, "broken.yaml")
    assert (ran.status, ran.err) == (1, "")
    assert "broken" in ran.out
    assert f"| `--format {form}`" in PAGE.read_text(encoding="utf-8")


def test_levels_add_families(run, good):
    def families(*words):
        checks = run("validate", "good.yaml", "--format", "json", *words).data["tasks"][0]["checks"]
        return list(dict.fromkeys(check["family"] for check in checks))

    assert families("--level", "static") == ["static"]
    assert families("--level", "build", "--quick") == ["static", "build", "reset"]


def test_some_families_only_are_run_and_named(run, good):
    words = ("validate", "good.yaml", "--level", "build", "--seeds", "2", "--only", "reset")
    ran, data = run(*words), run(*words, "--json").data["tasks"][0]
    assert list(dict.fromkeys(check["family"] for check in data["checks"])) == ["static", "reset"]
    assert data["making"]["only"] == ["reset"]
    assert data["making"]["command"].endswith("--level build --only reset --seeds 2")
    assert ran.out.splitlines()[-1].endswith(" s · only reset")


@pytest.mark.parametrize(
    ("words", "advice"),
    [
        (("--only", "solveable"), 'no family "solveable"; did you mean "solvable"?'),
        (("--only", "solvable", "--level", "build"), 'no family "solvable" at level build; there'),
    ],
)
def test_a_family_that_is_not_there_is_refused_before_anything_runs(words, advice, run, good):
    ran = run("validate", "good.yaml", *words)
    assert (ran.status, ran.out) == (2, "")
    assert advice in ran.err


@pytest.mark.slow
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
    ran = run("validate", "good.yaml", "--seeds", "800", "--level", "build", "--json")
    assert ran.data["ok"]
    assert "reset" in terminal.getvalue()


def test_elsewhere_progress_is_a_line_now_and_then(run, good, monkeypatch):
    words = ("validate", "good.yaml", "--seeds", "20", "--level", "build", "--json")
    assert run(*words).err == ""
    monkeypatch.setattr("taskbuilder.cli.output.LINE_EVERY_S", 0.0)
    told = r"^taskbuilder: .*reset.*: 7 of 20, about 0 s left$"
    assert re.search(told, run(*words).err, re.M)


@pytest.mark.slow  # a full proof; tests/validate/test_remaining.py has the figures
def test_a_proof_says_how_long_it_still_takes(run, good, monkeypatch):
    words = ("validate", "good.yaml", "--seeds", "1", "--jobs", "1")
    monkeypatch.setattr("taskbuilder.validate.remaining.SEEDS", 1)
    monkeypatch.setattr("taskbuilder.cli.validate_command.WORTH_TELLING_S", 1e6)
    assert "left" not in run(*words).err
    monkeypatch.setattr("taskbuilder.cli.validate_command.WORTH_TELLING_S", 0.0)
    told = re.findall(r"^good\.yaml: about [\d.]+ (?:s|min|h) left$", run(*words).err, re.M)
    assert len(told) == 2  # after the families that the rest is estimated by
    assert "left" not in run(*words, "--level", "build").err


def copies(good, bad=""):
    """Four copies of a task, one of which may raise an error."""
    text, module = good.read_text(), good.with_suffix(".py").read_text()
    names = [f"good_{number}" for number in range(4)]
    for name in names:
        (good.parent / f"{name}.yaml").write_text(text.replace("task: good", f"task: {name}"))
        ending = "\nraise ValueError\n" if name == bad else ""
        (good.parent / f"{name}.py").write_text(module + ending)
    return [f"{name}.yaml" for name in names]


@pytest.mark.slow
def test_the_time_of_many_tasks_is_that_of_the_clock(run, good):
    begun = time.perf_counter()
    ran = run("validate", *copies(good), "--level", "build", "--jobs", "2")
    took = time.perf_counter() - begun
    assert float(re.search(r"^ok in ([\d.]+) s$", ran.out, re.M)[1]) <= took + 0.5  # rounded


def test_many_tasks_are_validated_at_the_same_time_and_told_in_order(run, good):
    files = copies(good, bad="good_2")
    words = ("validate", *files, "--level", "build", "--seeds", "2", "--json")
    together, alone = (run(*words, "--jobs", jobs) for jobs in ("2", "1"))
    assert together.status == alone.status == 1
    assert [task["ok"] for task in together.data["tasks"]] == [True, True, False, True]
    told = [[report["task"], report["findings"]] for report in together.data["tasks"]]
    assert told == [[report["task"], report["findings"]] for report in alone.data["tasks"]]


def test_json_is_short_for_its_format(run, good):
    words = ("validate", "--level", "static", "good.yaml")
    assert undated(run(*words, "--json")) == undated(run(*words, "--format", "json"))


def test_json_says_how_it_was_made(run, good):
    words = ("validate", "good.yaml", "--level", "build", "--seeds", "3")
    making = run(*words, "--json").data["tasks"][0]["making"]
    assert (making["level"], making["seeds"]) == ("build", 3)
    assert making["command"] == f"taskbuilder {' '.join(words[:2])} --level build --seeds 3"
    assert making["versions"]["taskbuilder"] == taskbuilder.__version__


def test_json_says_of_which_files_it_is(run, good, tmp_path):
    words = ("validate", "good.yaml", "--level", "static", "--json")

    def checksum():
        return run(*words).data["tasks"][0]["making"]["checksum"]

    before = checksum()
    assert before == checksum() != ""
    file = tmp_path / "good.yaml"
    file.write_text(file.read_text() + "# changed\n")
    assert checksum() != before


def test_junit_is_xml_and_nothing_else(run, good, broken):
    ran = run("validate", "--level", "static", "--format", "junit", "good.yaml", "broken.yaml")
    assert (ran.status, ran.err) == (1, "")
    suites = ElementTree.fromstring(ran.out.encode())
    assert [suite.get("failures") for suite in suites] == ["0", "1"]


def test_github_gets_an_annotation_for_each_finding_and_a_closing_line(run, good, broken):
    ran = run("validate", "--level", "static", "--format", "github", "good.yaml", "broken.yaml")
    annotation, closing = ran.out.splitlines()
    assert (ran.status, ran.err) == (1, "")
    assert annotation.startswith("::error file=broken.yaml,line=7,col=52,title=TB103::scene.obj")
    assert closing.startswith("failed: broken.yaml: 1 error in ")


def test_the_environment_is_validated_with_the_options_that_are_given(run, good):
    options = ("--horizon", "20", "--control-hz", "20", "--frame", "base", "--reward", "local")
    ran = run("validate", "good.yaml", "--seeds", "2", "--only", "contract", "--only", "repeat",
              *options)  # fmt: skip
    assert (ran.status, ran.err) == (0, "")
    headline = ran.out.splitlines()[0]
    assert "20 steps at 20 Hz" in headline
    assert "reward local" in headline
    assert "frame base" in headline
    (task,) = run(*STATIC, "good.yaml", *options).data["tasks"]
    assert set(options) <= set(task["making"]["command"].split())


def test_an_option_that_does_not_fit_the_task_is_refused(run, good):
    ran = run(*STATIC, "good.yaml", "--control-hz", "7")
    assert ran.status == 2
    assert "control_hz 7 does not divide physics_hz" in ran.err


def test_what_was_not_run_is_listed_with_the_reason(run, good):
    good.write_text(good.read_text().replace("position: [0.5, 0, 0.02]", "position: [0.5, 0, 2]"))
    ran = run("validate", "good.yaml", "--quick", "--level", "build")
    assert ran.status == 1
    assert [" ".join(line.split()) for line in ran.out.splitlines()].count(
        "reset skip not run, as build failed"
    ) == 1


@pytest.fixture
def asked(monkeypatch):
    """What validations were asked for; none is carried out."""
    calls = []

    def note(reference, **options):
        calls.append({"reference": reference, **options})
        return TaskReport(reference, reference, ())

    monkeypatch.setattr("taskbuilder.cli.validate_command.validate_task", note)
    return calls


def test_as_many_processes_as_cores_unless_asked_otherwise(run, good, asked):
    run("validate", "good.yaml")
    run("validate", "good.yaml", "--jobs", "3")
    assert [call["jobs"] for call in asked] == [cores(), 3]


@pytest.mark.parametrize(
    ("words", "seeds"), [((), 40), (("--quick",), 5), (("--seeds", "7"), 7)], ids=str
)
def test_seeds_are_those_asked_for(words, seeds, run, good, asked):
    run("validate", "good.yaml", *words)
    assert asked[0]["seeds"] == seeds


def test_nothing_is_validated_for_a_command_that_cannot_be_carried_out(run, good, asked):
    assert run("validate", "good.yaml", "nowhere.yaml").status == 2
    assert run("validate", "good.yaml", "--report", "good.py").status == 2
    assert asked == []


@pytest.fixture
def small_pictures(monkeypatch):
    for name in ("LARGE", "SMALL"):
        monkeypatch.setattr(f"taskbuilder.validate.html.pictures.{name}", 32)


def test_a_report_is_one_whole_file_which_is_named_last(run, good, small_pictures):
    ran = run("validate", "good.yaml", "--quick", "--level", "build", "--report", "out/report")
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.splitlines()[-1].endswith(" s · pictures and probes: out/report/good.html")
    index, file = sorted(Path("out/report").iterdir(), reverse=True)
    assert 'href="good.html"' in index.read_text()
    assert "1 task, passed" in index.read_text()
    assert file.read_text().endswith("</html>\n")
    assert "data:image/jpeg;base64," in file.read_text()


def test_a_page_says_how_it_was_made(run, good):
    ran = run("validate", "good.yaml", "--seeds", "3", "--level", "build", "--report", "report")
    took = re.search(r"ok in (.*?) ·", ran.out)[1]
    page = Path("report/good.html").read_text()
    made = dict(re.findall(r"<dt>(\w+)</dt><dd>(.*?)</dd>", page.partition("How it was made")[2]))
    assert made["level"] == "build"
    assert made["seeds"] == "0 to 2"
    assert re.fullmatch(r"20\d\d-\d\d-\d\d \d\d:\d\d UTC", made["date"])
    assert made["time"] == took
    assert f" in {took}<" in page  # beside the verdict
    assert "taskbuilder" in made["versions"]
    assert "pybullet" in made["versions"]
    command = "taskbuilder validate good.yaml --level build --seeds 3"
    assert made["command"] == f"<code>{command}</code>"


def test_reports_of_several_tasks_have_an_index(run, good, broken):
    words = ("validate", "--level", "static", "good.yaml", "broken.yaml", "--report", "report")
    ran = run(*words)
    assert ran.status == 1
    assert ran.out.splitlines()[-1].endswith("pictures and probes: report/index.html")
    names = {"index.html", "good.html", "broken.html"}
    assert {file.name for file in Path("report").iterdir()} == names
    assert 'href="broken.html"' in Path("report/index.html").read_text()


def test_a_task_called_index_leaves_the_index_its_place(run, good, broken):
    broken.rename("index.yaml")
    run("validate", "--level", "static", "index.yaml", "good.yaml", "--report", "report")
    names = {"index.html", "index-2.html", "good.html"}
    assert {file.name for file in Path("report").iterdir()} == names
    assert 'href="index-2.html"' in Path("report/index.html").read_text()


@pytest.mark.parametrize("form", ["json", "junit"])
def test_machines_get_the_names_of_pages_beside_their_format(form, run, good):
    words = ("validate", "--level", "static", "good.yaml", "--report", ".")
    ran = run(*words, "--format", form)
    assert ran.err == "pictures and probes: good.html\n"
    assert "good.html" not in ran.out


def test_ctrl_c_keeps_the_pages_that_are_whole(run, good, broken, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    make = "taskbuilder.validate.html.page.take_pictures"
    monkeypatch.setattr(make, interrupted)
    words = ("validate", "broken.yaml", "good.yaml", "--quick", "--level", "build")
    ran = run(*words, "--report", "report")
    assert (ran.status, ran.err) == (130, "interrupted\n")
    (file,) = Path("report").iterdir()
    assert (file.name, file.read_text()[-8:]) == ("broken.html", "</html>\n")


def test_a_page_that_cannot_be_written_leaves_nothing_behind(run, good):
    Path("good.html").mkdir()
    ran = run("validate", "--level", "static", "good.yaml", "--report", ".")
    assert ran.status == 2
    assert "good.html: is a folder; name a file" in ran.err
    assert sorted(file.name for file in Path().iterdir()) == ["good.html", "good.py", "good.yaml"]


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


def test_two_tasks_of_one_name_fail_alone(run, good, tmp_path):
    (tmp_path / "mine").mkdir()
    for ending in (".yaml", ".py"):
        text = good.with_suffix(ending).read_text().replace("task: good", "task: reach")
        (tmp_path / "mine" / f"reach{ending}").write_text(text)
    ran = run("validate", "reach", "good.yaml", "--level", "static", "--task-path", "mine")
    assert ran.status == 1
    assert 'mine/reach.yaml: error[TB008] the task "reach" is also' in ran.out
    assert "good · 1 robot" in ran.out
    listed = run("list", "--task-path", "mine")
    assert listed.status == 0
    assert 'error[TB008] the task "reach"' in listed.err
