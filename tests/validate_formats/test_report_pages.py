"""Reports as pages: whole, safe, and with all that there is to show."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from made_up import NASTY, played

from taskbuilder import load_task
from taskbuilder.errors import Location
from taskbuilder.rollout import Trouble
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.validate.html.files import write_index, write_page
from taskbuilder.validate.html.page import Page, make_page
from taskbuilder.validate.html.pictures import Pictures, take_pictures
from taskbuilder.validate.html.templates import index_page, task_page
from taskbuilder.validate.report import FamilyResult

pytestmark = pytest.mark.in_process

VOID = {"img", "meta", "br", "wbr"}


class Parsed(HTMLParser):
    """A page taken apart; refuses tags that do not close as they opened."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(page)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.text += data

    def all(self, tag, **wanted):
        return [a for t, a in self.tags if t == tag and wanted.items() <= a.items()]


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    """Pictures are taken small, to be quick."""
    for name in ("LARGE", "SMALL"):
        monkeypatch.setattr(f"taskbuilder.validate.html.pictures.{name}", 32)


@pytest.fixture(scope="module")
def task():
    return load_task("handover")


@pytest.fixture
def full(passed, probes):
    """A report with episodes and probes."""
    trouble = Trouble(2, "left: bring stick to meeting", "left", "no path", "left has no way", 2)
    solvable = FamilyResult(
        "solvable",
        (),
        (),
        "1/3",
        rollouts=(
            played(0, success=True),
            played(7, success=False, trouble=trouble),
            played(8, success=False),
        ),
    )
    needs = FamilyResult("needs", (), (), "", rollouts=(played(9, success=True),))
    pays = FamilyResult("pays", (), (), "", probes=probes)
    return replace(passed, families=(*passed.families, solvable, needs, pays))


def test_a_page_needs_nothing_but_itself(task, full):
    page = Parsed(task_page(Page(full, task, take_pictures(task, full))))
    for tag, attributes in page.tags:
        assert tag not in ("script", "link", "iframe", "base", "form", "a")
        assert not [name for name in attributes if name.startswith("on")]
        assert (attributes.get("src") or "data:image/jpeg;base64,").startswith("data:image/jpeg;")
    (policy,) = page.all("meta", **{"http-equiv": "Content-Security-Policy"})
    assert policy["content"].startswith("default-src 'none'")
    assert "url(" not in task_page(Page(full, task))


def test_what_comes_from_files_is_text(failed):
    text = task_page(Page(failed))
    page = Parsed(text)
    assert not page.all("script")
    assert not page.all("b", class_="")
    assert NASTY.replace("\x1b", "�").replace("\udc80", "�") in page.text
    assert text.encode()


SCRIPT = "<script>alert(1)</script>"


@pytest.mark.parametrize("where", ["task", "headline", "file", "path", "message", "summary"])
def test_a_script_is_text_wherever_it_comes_from(where, task, failed, tmp_path):
    (finding,) = failed.families[0].findings[:1]
    file = tmp_path / SCRIPT.replace("/", "") / "lift.yaml"
    report, summary = failed, "One arm lifts a cube."
    if where in ("task", "headline"):
        report = replace(failed, **{where: SCRIPT})
    elif where == "summary":
        summary = SCRIPT
    else:
        said = Location(file, 1, 1) if where == "file" else SCRIPT
        finding = replace(finding, **{"location" if where == "file" else where: said})
        report = replace(
            failed, families=(replace(failed.families[0], findings=(finding,)),), skipped=()
        )
    spec = task.file.spec.model_copy(update={"summary": summary})
    page = Page(report, replace(task, file=replace(task.file, spec=spec)))
    for text in (task_page(page), index_page([("lift.html", page)])):
        assert "<script" not in text
    shown = task_page(page)
    assert "&lt;script&gt;" in shown
    assert Parsed(shown).text.count("<script>")


def test_a_long_name_breaks_where_its_words_end(passed):
    text = task_page(Page(replace(passed, headline="left_&_right · 2 robots")))
    assert "<h1>left_<wbr>&amp;_<wbr>right</h1>" in text


def test_findings_show_their_lines_and_what_their_codes_mean(failed, source):
    page = Parsed(task_page(Page(failed)))
    assert "Failed: 2 errors, 1 warning" in page.text
    assert f"{source}:4:18" in page.text
    assert "cube: {mass: heavy, <b>: 3}" in page.text
    assert len(page.all("mark")) == 1
    assert "Wrong type" in page.text
    assert "not run, as static and build failed" in page.text


def test_a_code_is_explained_once(failed):
    static = failed.families[0]
    wrong = static.findings[0]
    twice = replace(static, findings=(wrong, replace(wrong, message="is the text again")))
    page = Parsed(task_page(Page(replace(failed, families=(twice,)))))
    assert len(page.all("p", **{"class": "meaning"})) == 1
    assert page.text.count("Wrong type") == 2


def test_code_words_in_a_meaning_are_marked_as_code(failed):
    static = failed.families[0]
    progress = replace(static.findings[0], code="TB556")
    page = task_page(Page(replace(failed, families=(replace(static, findings=(progress,)),))))
    (meaning,) = re.findall(r'<p class="meaning">.*?</p>', page, re.DOTALL)
    assert "<code>progress</code>" in meaning
    assert "`" not in meaning


def test_the_expert_is_shown_stage_by_stage(task, full):
    pictures = take_pictures(task, full)
    assert [(m.step, m.stages) for m in pictures.strip] == [(0, ()), (1, (1,)), (2, (2,)), (3, ())]
    text = Parsed(task_page(Page(full, task, pictures))).text
    assert "left grasp stick.left_end" in text
    assert (
        "Seed 0: each picture is the end of a stage. Solved after 0.3\N{NO-BREAK SPACE}s." in text
    )


def test_episodes_that_went_wrong_are_shown_at_the_moment_that_decided(task, full):
    pictures = take_pictures(task, full)
    shown = [(f.family, f.rollout.seed, f.moment.step) for f in pictures.failures]
    assert shown == [("solvable", 7, 2), ("solvable", 8, 4), ("needs", 9, 3)]
    text = Parsed(task_page(Page(full, task, pictures))).text
    assert "left: bring stick to meeting: no path" in text
    assert "left has no way." in text
    assert "Every stage was played, yet the task was not solved" in text
    assert "Solved, though it should not have been." in text


def test_every_camera_has_its_picture(task, passed):
    pictures = take_pictures(task, passed)
    assert [picture.name for picture in pictures.scene] == list(task.file.spec.scene.cameras)
    page = Parsed(task_page(Page(passed, task, pictures)))
    assert len(page.all("img")) == 4
    assert all(int(image["width"]) == 32 and image["alt"] for image in page.all("img"))


def test_without_pictures_the_stages_are_listed(task, passed):
    page = Parsed(task_page(Page(passed, task)))
    assert not page.all("img")
    assert "right reach stick.right_end, 6 cm above" in page.text


def test_a_scene_that_cannot_be_shown_is_no_reason_to_show_nothing(task, full, monkeypatch):
    from taskbuilder.errors import SimulationError

    def fail(*_):
        raise SimulationError("the engine gave up")

    monkeypatch.setattr("taskbuilder.validate.html.pictures.build_world", fail)
    pictures = take_pictures(task, full)
    assert pictures == Pictures(trouble="The scene cannot be shown: the engine gave up")
    assert "the engine gave up" in Parsed(task_page(Page(full, task, pictures))).text


def test_a_report_of_files_alone_takes_no_pictures(passed, failed):
    catalogue = Catalogue.discover()
    static = replace(passed, families=passed.families[:1])
    assert make_page("handover", static, catalogue).pictures == Pictures()
    assert make_page("handover", static, catalogue).task is not None


def test_files_are_named_after_tasks_and_never_shared(tmp_path, task, passed, failed):
    odd = replace(passed, task="../x/a b&c.yaml")
    for page, taken, name in (
        (Page(passed, task), (), "handover.html"),
        (Page(passed, task), ("handover.html", "handover-2.html"), "handover-3.html"),
        (Page(replace(passed, task="mine/lift"), task), (), "mine-lift.html"),
        (Page(odd), (), "a-b-c.html"),
        (Page(replace(passed, task="/.."), task), (), "task.html"),
    ):
        file = write_page(tmp_path, page, taken)
        assert (file.parent, file.name) == (tmp_path, name)
        assert file.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_an_index_leads_to_every_page(tmp_path, task, passed, failed):
    pages = [("handover.html", Page(passed, task)), ("lift.html", Page(failed))]
    page = Parsed(write_index(tmp_path, pages).read_text(encoding="utf-8"))
    assert [link["href"] for link in page.all("a")] == ["handover.html", "lift.html"]
    assert "2 tasks, 1 failed" in page.text
    assert "2 tasks, all passed" in index_page(pages[:1] * 2)
