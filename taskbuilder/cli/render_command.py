"""`taskbuilder render`."""

from __future__ import annotations

import argparse

from taskbuilder.cli.env_options import asked_options
from taskbuilder.cli.output import print_json
from taskbuilder.cli.tasks import asked_tasks, catalogue_of, make_folder
from taskbuilder.errors import display_path
from taskbuilder.task import load_task
from taskbuilder.visual.annotations import check_words
from taskbuilder.visual.rendering import check_views, render


def run(arguments: argparse.Namespace) -> int:
    """Take pictures of tasks and say where they are."""
    catalogue = catalogue_of(arguments)
    names, asked = asked_tasks(arguments, catalogue), asked_options(arguments, ("scene",))
    robots, grasp = dict(asked.get("robots", ())), asked.get("grasp", "task")
    tasks = [load_task(name, catalogue=catalogue, robots=robots, grasp=grasp) for name in names]
    cameras = arguments.camera or ()
    for task in tasks:
        check_views(task, arguments.variation, cameras)
    words = check_words([word for listed in arguments.show for word in listed.split(",")])
    make_folder(arguments.out)
    listed = []
    for task in tasks:
        files = render(
            task,
            arguments.out,
            camera=cameras,
            size=arguments.size,
            modalities=arguments.modality,
            show=words,
            variation=arguments.variation,
            seed=arguments.seed,
            randomize=arguments.randomize,
            renderer=arguments.renderer or "auto",
        )
        listed.append({"task": task.name, "files": [display_path(file) for file in files]})
        if not arguments.json:
            print("\n".join(display_path(file) for file in files))
    if arguments.json:
        print_json(listed[0] if len(listed) == 1 else {"tasks": listed})
    return 0
