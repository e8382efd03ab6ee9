"""A quick look at a task again and again: what is wrong with it, and a picture of it.

The look is taken in a child process, which stays from one look to the next and has everything
loaded. A description that hangs or crashes takes that process with it, and nothing else.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from taskbuilder.errors import FileError, TaskbuilderError
from taskbuilder.jobs import DONE, RAISED, LostError, Worker, packed, wait_for
from taskbuilder.jobs import say as tell
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import load_task
from taskbuilder.validate.apart import CHECK, Begun, ValidationConfig
from taskbuilder.validate.checks.static import static_failure
from taskbuilder.validate.losses import finding_of_loss, lost_family, refused_import
from taskbuilder.validate.report import TaskReport
from taskbuilder.validate.runner import validate_in_child
from taskbuilder.visual.annotations import Annotator
from taskbuilder.visual.still import save_image, take_still
from taskbuilder.world.building import build_world

HUNG_S = 2.0
"""A look that has said nothing for so long is given up for a new one, if there is to be one."""

LIMIT_S = 20.0
"""A look that has said nothing for so long is given up."""

LONGEST_SIDE = 480
"""Of a picture whose size is not given, in pixels; larger ones take longer than a look should."""

_POLL_S = 0.05
_BUILD = "build"


@dataclass(frozen=True)
class LookOrder:
    """What to look at.

    Attributes:
        task: Name of the task, or path of its YAML file.
        catalogue: The catalogue that names are looked up in.
        picture: The file of the picture.
        camera: The camera that takes it; "" for the scene's first.
        size: Width and height in pixels; by default those of the camera, or `LONGEST_SIDE`.
        seed: Of the episode that is shown.
        show: What is drawn over it; see `Annotator`.
    """

    task: str
    catalogue: Catalogue
    picture: Path
    camera: str = ""
    size: tuple[int, int] | None = None
    seed: int = 0
    show: tuple[str, ...] = ()


@dataclass(frozen=True)
class Seen:
    """What is known of a task so far.

    Attributes:
        report: The report on the families that have run.
        picture: The picture that was written, or None.
        problem: Why there is no picture, or "".
        done: Nothing more will come of this look.
    """

    report: TaskReport | None
    picture: Path | None = None
    problem: str = ""
    done: bool = False


class Looker:
    """Takes looks, one after the other, in a child process."""

    def __init__(self) -> None:
        self._worker = Worker({}, prepared=__name__)

    def close(self) -> None:
        """End the child process."""
        self._worker.end()

    def look(
        self,
        order: LookOrder,
        seen: Callable[[Seen], None],
        interrupted: Callable[[], bool] = lambda: False,
    ) -> None:
        """Take a look.

        Args:
            order: What to look at.
            seen: Called with what is known, as soon as there is more; the last time with all.
            interrupted: Asked now and then whether there is to be another look; one that hangs
                is then given up.
        """
        begun, report = Begun("", LIMIT_S), None
        self._worker.give(packed(take_look, order))
        try:
            while True:
                ready = wait_for([self._worker], _POLL_S)
                for kind, value in self._worker.hear() if ready else ():
                    if kind == RAISED:
                        seen(Seen(report, problem=_said(value), done=True))
                        return
                    if kind == DONE:
                        seen(value)
                        return
                    if isinstance(value, Begun):
                        begun = value
                    elif isinstance(value, Seen):
                        report = value.report
                        seen(value)
                silent = time.monotonic() - (self._worker.since or time.monotonic())
                if silent > HUNG_S and interrupted():
                    self._worker.start()
                    return
                self._worker.check(LIMIT_S)
        except LostError as lost:
            seen(Seen(_lost(order, begun, report, lost), done=True))


def _said(error: Exception) -> str:
    if isinstance(error, TaskbuilderError | OSError):
        return str(error)
    return f"a defect of taskbuilder itself: {type(error).__name__}: {error}"


def _lost(order: LookOrder, begun: Begun, report: TaskReport | None, lost: LostError) -> TaskReport:
    """The report where the child process was lost."""
    entry = order.catalogue.task(order.task)
    if report is None:
        finding = refused_import(lost.fault, entry, looked_over=begun.part == CHECK)
        return TaskReport(order.task, order.task, (static_failure((finding,)),))
    family = lost_family(_BUILD, finding_of_loss(lost.fault, entry))
    return TaskReport(report.task, report.headline, (*report.families, family))


# --- in the child process


def take_look(order: LookOrder) -> Seen:
    """Check a task, take its picture and build all of its variations.

    The owner is told of each step. The picture comes before the last, which takes longer.
    """
    static = ValidationConfig(order.task, "static", 1, order.catalogue, 1, None)
    report = validate_in_child(static)
    tell(Seen(report))
    if not report.ok:
        return Seen(report, done=True)
    tell(Begun(_BUILD, LIMIT_S))
    pictured = _pictured(order, report)
    tell(pictured)
    report = validate_in_child(replace(static, level="build", only=(_BUILD,)))
    return replace(pictured, report=report, done=True)


def _pictured(order: LookOrder, report: TaskReport) -> Seen:
    """Take the picture; what keeps the scene from being built is found with the build."""
    task = load_task(order.task, catalogue=order.catalogue)
    try:
        world = build_world(task.file)
    except FileError:
        return Seen(report)
    try:
        world.reset(order.seed)
        camera = order.camera or next(iter(world.scene.cameras))
        view = world.camera(camera)
        size = order.size or _small(view.width, view.height)
        still = take_still(world, camera, size)
        pixels = Annotator(world, order.show).annotated(still, size).image.rgb
        save_image(order.picture, pixels)
    except (TaskbuilderError, OSError) as error:
        return Seen(report, problem=str(error))
    finally:
        world.close()
    return Seen(report, order.picture)


def _small(width: int, height: int) -> tuple[int, int]:
    """The size of a picture that is not to take long, of the camera's shape."""
    share = min(1.0, LONGEST_SIDE / max(width, height))
    return max(1, round(share * width)), max(1, round(share * height))
