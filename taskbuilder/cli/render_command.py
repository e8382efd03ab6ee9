"""`taskbuilder render`."""

from __future__ import annotations

import argparse
from pathlib import Path

from taskbuilder.cli.output import print_json
from taskbuilder.cli.tasks import asked_tasks, catalogue_of, make_folder
from taskbuilder.errors import UnknownNameError, UsageError, display_path
from taskbuilder.render import contact_sheet, save_image, save_still, take_still
from taskbuilder.spec.explain import suggestion
from taskbuilder.task import Task, load_task
from taskbuilder.world.building import build_world


def run(arguments: argparse.Namespace) -> int:
    """Take pictures of tasks and say where they are."""
    catalogue = catalogue_of(arguments)
    tasks = [load_task(name, catalogue=catalogue) for name in asked_tasks(arguments, catalogue)]
    for task in tasks:
        _check(task, arguments)
    make_folder(arguments.out)
    listed = []
    for task in tasks:
        files = _render(task, arguments)
        listed.append({"task": task.name, "files": [display_path(file) for file in files]})
        if not arguments.json:
            print("\n".join(display_path(file) for file in files))
    if arguments.json:
        print_json(listed[0] if len(listed) == 1 else {"tasks": listed})
    return 0


def _check(task: Task, arguments: argparse.Namespace) -> None:
    """Refuse what cannot be rendered before anything is written."""
    scenes = task.file.scenes
    if arguments.variation >= len(scenes):
        has = f"it has 1 to {len(scenes) - 1}" if len(scenes) > 1 else "it has none"
        wrong = f"{task.name} has no variation {arguments.variation}"
        raise UsageError(f"{wrong}; {has}, and 0 is the plain task")
    cameras = scenes[arguments.variation].cameras
    for camera in arguments.camera or ():
        if camera not in cameras:
            help_ = suggestion(camera, cameras, what="it has")
            raise UnknownNameError(f'{task.name} has no camera "{camera}"; {help_}')


def _render(task: Task, arguments: argparse.Namespace) -> list[Path]:
    world = build_world(task.file, variation=arguments.variation, renderer=arguments.renderer)
    try:
        world.reset(arguments.seed)
        cameras = list(dict.fromkeys(arguments.camera or world.scene.cameras))
        stills = [take_still(world, camera, arguments.size) for camera in cameras]
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
