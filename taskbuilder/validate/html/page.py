"""What the page of a task is made of, and how that is gathered."""

from __future__ import annotations

import traceback
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from taskbuilder.description.description import Description
from taskbuilder.env.loading import load_with
from taskbuilder.env.options import Options
from taskbuilder.errors import FileError
from taskbuilder.jobs import LostError, worker_processes
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.expert import ExpertStage
from taskbuilder.task import Task
from taskbuilder.validate.html.pictures import Picture, Pictures, take_pictures
from taskbuilder.validate.report import TaskReport

PICTURES_LIMIT_S = 300.0
"""How long the pictures of a task may take."""


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
    def stages(self) -> Sequence[ExpertStage]:
        """What the expert does, as far as that is known."""
        return self.task.file.spec.expert if self.task else ()

    @property
    def first(self) -> Picture | None:
        """The picture that stands for the task."""
        return next(iter(self.pictures.scene), None)


def make_page(
    reference: str,
    report: TaskReport,
    catalogue: Catalogue,
    *,
    apart: bool = True,
    options: Options | None = None,
) -> Page:
    """Gather what a page shows; pictures are taken here, unless no physics was asked for.

    Args:
        reference: What the task was asked for by.
        report: Its validation.
        catalogue: Where it was looked up.
        apart: Load the task and take its pictures in another process; see `validate_task`.
        options: Options of the environments that were validated.
    """
    asked = (reference, report, catalogue, options or Options())
    if not apart:
        return _made(*asked)
    try:
        with worker_processes([{}], limit_s=PICTURES_LIMIT_S) as spread:
            (page,) = spread(_made_apart, [asked])
    except LostError as error:
        lost = f"The process that takes them {error.fault.cause}."
        return Page(report, pictures=Pictures(trouble=lost))
    except Exception as error:  # a page without pictures is better than no page
        said = traceback.format_exception_only(error)[-1].strip()
        return Page(report, pictures=Pictures(trouble=f"Taking them failed: {said}"))
    found: Page = page
    return found


def _made_apart(asked: tuple[str, TaskReport, Catalogue, Options]) -> Page:
    """A page, without the description, which only the process that imported it knows."""
    page = _made(*asked)
    return replace(page, task=page.task and replace(page.task, declared=Description))


def _made(reference: str, report: TaskReport, catalogue: Catalogue, options: Options) -> Page:
    try:
        task = load_with(options, reference, catalogue=catalogue)
    except FileError:
        return Page(report)  # its findings say why
    if len(report.families) < 2:
        return Page(report, task)
    return Page(report, task, take_pictures(task, report))
