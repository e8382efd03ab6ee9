"""The report as a page that holds all that it shows, and the page that lists several."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from taskbuilder.task import Task
from taskbuilder.validate.formats.chart import chart
from taskbuilder.validate.formats.episodes import camera, cameras, expert, failures, image
from taskbuilder.validate.formats.findings import findings_list
from taskbuilder.validate.formats.markup import Content, Html, element
from taskbuilder.validate.formats.parts import (
    families,
    footer,
    header,
    made,
    measures,
    section,
    verdict,
)
from taskbuilder.validate.formats.pictures import Picture, Pictures
from taskbuilder.validate.formats.style import STYLE
from taskbuilder.validate.report import TaskReport

_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"


@dataclass(frozen=True)
class Page:
    """What a page is made of.

    Attributes:
        report: The validation.
        task: The task, or None if it does not load.
        pictures: What was taken of it.
    """

    report: TaskReport
    task: Task | None = None
    pictures: Pictures = field(default_factory=Pictures)

    @property
    def summary(self) -> str:
        """What the task is, in a sentence, as far as that is known."""
        return self.task.file.spec.summary if self.task else ""

    @property
    def first(self) -> Picture | None:
        """The picture that stands for the task."""
        return next(iter(self.pictures.scene), None)


def task_page(page: Page) -> str:
    """The report of one task as an HTML document."""
    report = page.report
    first = camera(page.first) if page.first else None
    body = element("main", header(report, page.summary, first), list(_sections(page)))
    return _document(report.task, body)


def _sections(page: Page) -> Iterator[Html]:
    report, pictures = page.report, page.pictures
    if report.findings:
        yield section("Findings", findings_list(report.findings))
    if pictures.failures:
        note = "The scene when it showed."
        yield section("Episodes that went wrong", failures(pictures.failures), note=note)
    yield section("Checks", families(report), note="Open a line to see its figures.")
    stages = page.task.file.spec.expert if page.task else ()
    if stages:
        yield section("The expert", expert(stages, pictures), note=_played(pictures))
    yield from _earned(report)
    if len(pictures.scene) > 1:
        yield section("More views", cameras(pictures.scene[1:]))
    if report.measures:
        yield section("Measured", measures(report.measures))
    if pictures.trouble:
        yield section("Without pictures", element("p", pictures.trouble))
    if report.making:
        yield section("How it was made", made(report.making))


def _played(pictures: Pictures) -> str:
    demo = pictures.shown
    if demo is None or demo.first_success is None:
        return "What each robot does."
    last = pictures.strip[-1]
    solved = demo.first_success * (last.seconds / last.step if last.step else 0.0)
    time = f"{solved:.1f}\N{NO-BREAK SPACE}s"
    return f"Seed {demo.seed}: each picture is the end of a stage. Solved after {time}."


def _earned(report: TaskReport) -> Iterator[Html]:
    probes = [probe for family in report.families for probe in family.probes]
    if not probes:
        return
    note = (
        "A dot is an episode, an upright its mean over them. What stands level with the expert, "
        "or to the right of it, pays as well as solving the task."
    )
    figures = (
        chart("Undiscounted", probes, discounted=False),
        chart("Discounted by 0.95 a step", probes, discounted=True),
    )
    yield section("What pays", element("div", figures, class_="charts"), note=note)


def index_page(pages: Sequence[tuple[str, Page]]) -> str:
    """A page that lists the reports of several tasks, by the names of their files."""
    wrong = sum(not page.report.ok for _, page in pages)
    count = f"{len(pages)} task{'s' * (len(pages) != 1)}"
    every = "all " * (len(pages) != 1)
    title = f"{count}, {wrong} failed" if wrong else f"{count}, {every}passed"
    listed = [element("li", _entry(file, page)) for file, page in pages]
    return _document(
        title, element("main", element("h1", title), element("ul", listed, class_="index"))
    )


def _entry(file: str, page: Page) -> Html:
    picture = image(page.first, "") if page.first else None
    words: tuple[Content, ...] = (
        element("h2", page.report.task),
        element("p", page.summary) if page.summary else None,
        verdict(page.report),
    )
    return element("a", picture, element("div", words), href=file)


def _document(title: str, body: Html) -> str:
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", http_equiv="Content-Security-Policy", content=_POLICY),
        element("meta", name="color-scheme", content="light dark"),
        element("title", title),
        element("style", Html(STYLE)),
    )
    page = element("html", head, element("body", body, footer()), lang="en")
    return f"<!DOCTYPE html>\n{page.text}\n"
