"""Pictures of a task: a file for each camera, and a sheet of all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path

from taskbuilder.env.options import Renderer
from taskbuilder.errors import UsageError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.choices import GraspChoice
from taskbuilder.schema.task import LOOK_PARTS
from taskbuilder.task import Task, load_task
from taskbuilder.visual.annotations import Annotator, check_words
from taskbuilder.visual.still import (
    Modality,
    Still,
    contact_sheet,
    save_image,
    save_still,
    seeds_sheet,
    take_still,
)
from taskbuilder.world.building import build_world
from taskbuilder.world.world import World


def check_views(task: Task, variation: int, cameras: Sequence[str]) -> None:
    """Refuse a variation or a camera that a task does not have.

    Raises:
        UsageError: There is no such variation.
        UnknownNameError: There is no such camera.
    """
    scenes = task.file.scenes
    if variation not in range(len(scenes)):
        has = f"it has 1 to {len(scenes) - 1}" if len(scenes) > 1 else "it has none"
        raise UsageError(
            f"{task.name} has no variation {variation}; {has}, and 0 is the plain task"
        )
    task.file.check_cameras(cameras, variation)


def render(
    task: str | Path | Task,
    out: str | Path = "renders",
    *,
    camera: str | Sequence[str] = (),
    size: tuple[int, int] | None = None,
    modalities: Sequence[Modality] = ("rgb",),
    show: Sequence[str] = (),
    variation: int = 0,
    seed: int = 0,
    randomize: int = 0,
    renderer: Renderer = "auto",
    robots: Mapping[str, str | Path] | None = None,
    grasp: GraspChoice = "task",
    catalogue: Catalogue | None = None,
) -> list[Path]:
    """Take pictures of a task.

    Args:
        task: Name or path of the task, or the task itself.
        out: Folder of the pictures.
        camera: The camera, or several; by default all of the scene, with ``randomize`` the first.
        size: Width and height in pixels; by default those of each camera.
        modalities: ``rgb``, ``depth`` and ``mask``.
        show: What is drawn over the pictures, such as ``frames``; the command ``render`` lists all.
        variation: Number of the variation.
        seed: Seed of the initial state.
        randomize: Number of episodes, with everything random in them, to show on one sheet.
        renderer: Renderer of the pictures.
        robots: Models that replace those of the task file, by robot; see `load_task`.
        grasp: How grippers with fingers hold objects; see `load_task`.
        catalogue: Where names are looked up; by default the catalogue of this installation.

    Returns:
        The files.

    Raises:
        UnknownNameError: There is no such task, camera or thing to show.
        UsageError: There is no such variation.
        FileError: The task has errors.
        OSError: A file cannot be written.
    """
    if not isinstance(task, Task):
        task = load_task(task, catalogue=catalogue, robots=robots, grasp=grasp)
    elif robots or grasp != "task":
        raise UsageError("the task is loaded already; give robots and grasp to load_task")
    cameras = [camera] if isinstance(camera, str) else camera
    check_views(task, variation, cameras)
    words, folder = check_words(list(show)), Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    stem = folder / task.name.replace("/", "-")
    summary, kinds = task.file.spec.summary, list(dict.fromkeys(modalities))
    with closing(build_world(task.file, variation=variation, renderer=renderer)) as world:
        every = [*world.scene.cameras]
        named = list(dict.fromkeys(cameras or (every[:1] if randomize else every)))
        if randomize:
            shown = []
            for number in range(seed, seed + randomize):
                world.reset(number, randomized=True, looks=LOOK_PARTS)
                shown += [(number, still) for still in _stills(world, named, size, words)]
            file = stem.with_name(f"{stem.name}-randomized.png")
            save_image(file, seeds_sheet(task.name, summary, shown, kinds))
            return [file]
        world.reset(seed)
        stills = _stills(world, named, size, words)
    files: list[Path] = []
    for still in stills:
        files += save_still(still, stem.with_name(f"{stem.name}-{still.camera}"), kinds)
    sheet = stem.with_name(f"{stem.name}-sheet.png")
    save_image(sheet, contact_sheet(task.name, summary, stills, kinds))
    return [*files, sheet]


def _stills(
    world: World, cameras: Sequence[str], size: tuple[int, int] | None, show: Sequence[str]
) -> list[Still]:
    """Pictures of a world as it stands, with what is to be shown over them."""
    annotator = Annotator(world, show)
    return [annotator.annotated(take_still(world, camera, size), size) for camera in cameras]
