"""Pictures for a report: the scene, the expert at work, and what went wrong when."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, repeat

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import TaskbuilderError
from taskbuilder.rollout.play import replay
from taskbuilder.rollout.record import Rollout
from taskbuilder.task import Task
from taskbuilder.validate.locate import in_description
from taskbuilder.validate.report import TaskReport
from taskbuilder.visual.capture import take_picture
from taskbuilder.visual.still import Pixels, take_still
from taskbuilder.world.building import build_world
from taskbuilder.world.world import World

LARGE, SMALL = 880, 560
"""Longer side of the picture that opens the page, and of the others, in pixels."""

MOST_FRAMES = 12
MOST_FAILURES = 6

SOLVED_BY = "solvable"
"""The family whose episodes are to succeed; those of the others are not."""


@dataclass(frozen=True)
class Picture:
    """A picture as it stands in a page.

    Attributes:
        name: What it shows: a camera, or a moment.
        jpeg: The file's content.
        width: In pixels.
        height: In pixels.
    """

    name: str
    jpeg: bytes
    width: int
    height: int


@dataclass(frozen=True)
class Moment:
    """A picture of an episode at one of its control steps.

    Attributes:
        step: Control steps that had passed.
        seconds: Simulated time that had passed.
        stages: Numbers, from 1, of the expert's stages that had ended just then.
        picture: What the scene's first camera saw.
    """

    step: int
    seconds: float
    stages: tuple[int, ...]
    picture: Picture


@dataclass(frozen=True)
class Failure:
    """An episode that did not go as it should, and how it stood in the end.

    Attributes:
        family: The family of checks that played it.
        rollout: The episode.
        moment: When the expert stopped, or the end; None where that cannot be shown.
    """

    family: str
    rollout: Rollout
    moment: Moment | None


@dataclass(frozen=True)
class Pictures:
    """All pictures of a task's report.

    Attributes:
        scene: What each camera sees at the start of an episode.
        strip: The expert's episode: its start, the end of every stage, and its success.
        shown: The episode of the strip, or None.
        failures: Episodes that failed.
        trouble: Why pictures are missing, or "".
    """

    scene: tuple[Picture, ...] = ()
    strip: tuple[Moment, ...] = ()
    shown: Rollout | None = None
    failures: tuple[Failure, ...] = ()
    trouble: str = ""

    @property
    def solved(self) -> Moment | None:
        """The first moment of the strip at which the task was solved, or None."""
        first = self.shown.first_success if self.shown else None
        if first is None:
            return None
        return next((moment for moment in self.strip if moment.step >= first), None)


def take_pictures(task: Task, report: TaskReport) -> Pictures:
    """Take the pictures of a report. What cannot be shown is left out, and it is said why."""
    try:
        scene = _scene(task)
    except Exception as error:  # a picture more or less must not cost the report
        return Pictures(trouble=f"The scene cannot be shown: {_why(error, task)}")
    try:
        return _episodes(task, report, scene)
    except (Exception, SystemExit) as error:  # the same
        return Pictures(scene, trouble=f"Episodes cannot be shown: {_why(error, task)}")


def _why(error: BaseException, task: Task) -> str:
    if isinstance(error, TaskbuilderError):
        return str(error)
    finding = in_description(error, task.file.entry)
    return str(finding) if finding else f"a defect of taskbuilder, {type(error).__name__}: {error}"


def _scene(task: Task) -> tuple[Picture, ...]:
    world = build_world(task.file)
    try:
        world.reset(0)
        sides = chain([LARGE], repeat(SMALL))
        return tuple(map(partial(_still, world), world.scene.cameras, sides))
    finally:
        world.close()


def _episodes(task: Task, report: TaskReport, scene: tuple[Picture, ...]) -> Pictures:
    played = [(family.name, demo) for family in report.families for demo in family.rollouts]
    shown = next((demo for name, demo in played if name == SOLVED_BY and demo.success), None)
    others = [(name, demo) for name, demo in played if demo is not shown and _wrong(name, demo)]
    return Pictures(
        scene,
        _moments(task, shown, _ends_of_stages(shown)) if shown else (),
        shown,
        tuple(
            Failure(name, demo, next(iter(_moments(task, demo, {_end(demo): ()})), None))
            for name, demo in others[:MOST_FAILURES]
        ),
    )


def _wrong(family: str, demo: Rollout) -> bool:
    """Whether an episode did not go as it should: only the expert's may succeed."""
    return demo.success != (family == SOLVED_BY)


def _end(demo: Rollout) -> int:
    """When an episode was decided."""
    if demo.first_success is not None:
        return demo.first_success
    return min(demo.trouble.step, demo.steps) if demo.trouble else demo.steps


def _ends_of_stages(demo: Rollout) -> Mapping[int, tuple[int, ...]]:
    """The steps worth a picture, and the stages of the expert that ended with each."""
    ends: dict[int, tuple[int, ...]] = {0: ()}
    for stage, step in enumerate(demo.stage_ends, 1):
        ends[step] = (*ends.get(step, ()), stage)
    if demo.first_success is not None and demo.first_success > max(ends):
        ends[demo.first_success] = ()
    if len(ends) <= MOST_FRAMES:
        return ends
    steps = sorted(ends)
    kept = {steps[i * (len(steps) - 1) // (MOST_FRAMES - 1)] for i in range(MOST_FRAMES)}
    return {step: stages for step, stages in ends.items() if step in kept}


def _moments(
    task: Task, demo: Rollout, wanted: Mapping[int, tuple[int, ...]]
) -> tuple[Moment, ...]:
    """Play an episode again, and take a picture of it after some of its control steps."""
    env = TaskEnv(task, replace(demo.options, horizon=max(demo.horizon, 1)))
    taken: list[Moment] = []

    def watch(env: TaskEnv) -> None:
        step = env.episode.steps
        if step in wanted and not env.episode.exploded:
            taken.append(_moment(env.episode.world, step, wanted[step]))

    try:
        replay(env, demo, watch)
    finally:
        env.close()
    return tuple(taken)


def _moment(world: World, step: int, stages: tuple[int, ...]) -> Moment:
    camera = next(iter(world.scene.cameras))
    pixels = take_picture(world, camera, _size(world, camera, SMALL))
    return Moment(step, step / world.spec.timing.control_hz, stages, _picture(camera, pixels))


def _still(world: World, camera: str, side: int) -> Picture:
    pixels = take_still(world, camera, _size(world, camera, side)).image.rgb
    return _picture(camera, pixels)


def _size(world: World, camera: str, side: int) -> tuple[int, int]:
    """The size of a picture whose longer side is so long."""
    view = world.camera(camera)
    share = side / max(view.width, view.height)
    return max(round(share * view.width), 1), max(round(share * view.height), 1)


def _picture(name: str, pixels: Pixels) -> Picture:
    from PIL import Image  # a report without pictures does without it

    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG", quality=90, subsampling=0, optimize=True)
    height, width = pixels.shape[:2]
    return Picture(name, file.getvalue(), width, height)
