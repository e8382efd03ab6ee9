"""An episode in a cell of a notebook, in three dimensions."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from taskbuilder.errors import FileError
from taskbuilder.files import write_whole
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task
from taskbuilder.view.export import as_html
from taskbuilder.view.stage import Choice, Stage

HEIGHT = 480
"""Height of the view in a cell, in pixels."""


@dataclass(frozen=True)
class EpisodeView:
    """An episode that a notebook shows in three dimensions, and that needs no server.

    Attributes:
        title: Task, player and seed, and how the episode ended.
        html: The page.
    """

    title: str
    html: str = field(repr=False)

    def __repr__(self) -> str:
        return f"<EpisodeView {self.title}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: the page in a frame, so that the cell can be saved with it."""
        page, title = escape(self.html), escape(self.title)
        return f'<iframe srcdoc="{page}" title="{title}" width="100%" height="{HEIGHT}"></iframe>'

    def save(self, file: str | Path) -> None:
        """Write the page to a file, which any browser opens.

        Raises:
            OSError: The file cannot be written.
        """
        write_whole(Path(file), self.html.encode())


def show(
    task: str | Path | Task,
    policy: str = "expert",
    *,
    seed: int = 0,
    variation: int = 0,
    catalogue: Catalogue | None = None,
) -> EpisodeView:
    """Play an episode, and show it in three dimensions in a cell of a notebook.

    Args:
        task: Name or path of the task, or the task itself.
        policy: Who plays: ``expert``, ``random``, ``zoo:handover/cloned`` and so on; see
            `parse_policy`.
        seed: Seed of the episode.
        variation: Number of the variation.
        catalogue: Catalogue in which to look up names; by default the catalogue of this
            installation.

    Raises:
        UnknownNameError: There is no such task.
        UsageError: The extra ``view`` is not installed, or the policy does not fit the task.
        FileError: The files of the task have errors.
    """
    if isinstance(task, Task):
        catalogue, task = catalogue or task.file.catalogue, task.reference
    stage = Stage(str(task), catalogue or Catalogue.discover())
    if stage.task is None:
        raise FileError(stage.findings)
    choice = Choice(policy, seed, variation)
    recording = stage.play(choice, lambda _: None)
    with closing(stage.env(choice)) as env:
        html = as_html(env.episode.world, recording)
    title = f"{stage.task.name}: {policy}, seed {seed}: {recording.verdict()}"
    return EpisodeView(title, html)
