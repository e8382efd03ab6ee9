"""`taskbuilder render`."""

from __future__ import annotations

import argparse
from pathlib import Path

from taskbuilder.cli.env_options import asked_options
from taskbuilder.cli.output import print_json
from taskbuilder.cli.tasks import asked_tasks, catalogue_of, check_views, make_folder
from taskbuilder.env.options import Renderer
from taskbuilder.errors import display_path
from taskbuilder.schema.task import LOOK_PARTS
from taskbuilder.task import Task, load_task
from taskbuilder.visual.annotations import Annotator, check_words
from taskbuilder.visual.still import (
    Still,
    contact_sheet,
    save_image,
    save_still,
    seeds_sheet,
    take_still,
)
from taskbuilder.world.building import build_world
from taskbuilder.world.world import World


def run(arguments: argparse.Namespace) -> int:
    """Take pictures of tasks and say where they are."""
    catalogue = catalogue_of(arguments)
    names, asked = asked_tasks(arguments, catalogue), asked_options(arguments, ("scene",))
    robots, grasp = dict(asked.get("robots", ())), asked.get("grasp", "task")
    tasks = [load_task(name, catalogue=catalogue, robots=robots, grasp=grasp) for name in names]
    for task in tasks:
        check_views(task, arguments)
    arguments.show = check_words([word for listed in arguments.show for word in listed.split(",")])
    make_folder(arguments.out)
    listed = []
    draw = _render_randomized if arguments.randomize else _render
    for task in tasks:
        files = draw(task, arguments)
        listed.append({"task": task.name, "files": [display_path(file) for file in files]})
        if not arguments.json:
            print("\n".join(display_path(file) for file in files))
    if arguments.json:
        print_json(listed[0] if len(listed) == 1 else {"tasks": listed})
    return 0


def _render(task: Task, arguments: argparse.Namespace) -> list[Path]:
    world = _world(task, arguments)
    try:
        world.reset(arguments.seed)
        cameras = list(dict.fromkeys(arguments.camera or world.scene.cameras))
        stills = _stills(world, cameras, arguments)
    finally:
        world.close()
    modalities = list(dict.fromkeys(arguments.modality))
    name = task.name.replace("/", "-")
    files = []
    for still in stills:
        files += save_still(still, arguments.out / f"{name}-{still.camera}", modalities)
    sheet = contact_sheet(task.name, task.file.spec.summary, stills, modalities)
    save_image(arguments.out / f"{name}-sheet.png", sheet)
    return [*files, arguments.out / f"{name}-sheet.png"]


def _render_randomized(task: Task, arguments: argparse.Namespace) -> list[Path]:
    """One sheet of episodes in which all is drawn that may be."""
    world = _world(task, arguments)
    stills = []
    try:
        cameras = list(dict.fromkeys(arguments.camera or [next(iter(world.scene.cameras))]))
        for seed in range(arguments.seed, arguments.seed + arguments.randomize):
            world.reset(seed, randomized=True, looks=LOOK_PARTS)
            stills += [(seed, still) for still in _stills(world, cameras, arguments)]
    finally:
        world.close()
    modalities = list(dict.fromkeys(arguments.modality))
    sheet = seeds_sheet(task.name, task.file.spec.summary, stills, modalities)
    file = arguments.out / f"{task.name.replace('/', '-')}-randomized.png"
    save_image(file, sheet)
    return [file]


def _world(task: Task, arguments: argparse.Namespace) -> World:
    renderer: Renderer = arguments.renderer or "auto"
    return build_world(task.file, variation=arguments.variation, renderer=renderer)


def _stills(world: World, cameras: list[str], arguments: argparse.Namespace) -> list[Still]:
    """Pictures of a world as it stands, with what is to be shown over them."""
    annotator = Annotator(world, arguments.show)
    return [
        annotator.annotated(take_still(world, camera, arguments.size), arguments.size)
        for camera in cameras
    ]
