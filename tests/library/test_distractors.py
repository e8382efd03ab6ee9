"""In no task of the library can a distractor be taken for a sign that the task is done."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from taskbuilder import build_world, load_task
from taskbuilder.description.description import Referee
from taskbuilder.description.node import walk
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.task import LOOK_PARTS
from taskbuilder.shapes import BoxShape

MARGIN_M = 0.055
SEEDS = range(4)


def named_in(task) -> set[str]:
    """The objects and sites that success, failure, stages or an instruction name."""
    description, scene = task.description, task.file.spec.scene
    roots = (description.success, description.failure, *description.stages.values())
    found = {name.partition(".")[0] for node in walk(roots) for _, name in node.references()}
    text = " ".join(task.file.spec.instructions)
    found |= set(re.findall(r"\{(\w+)\.", text))
    words = {name: name.replace("_", " ") for name in (*scene.objects, *scene.sites)}
    found |= {name for name, word in words.items() if re.search(rf"\b{word}\b", text)}
    return found & {*words}


def spots(world, name) -> np.ndarray:
    """(n, 2) points, about 5 mm apart, of the box around a thing seen from above."""
    site = world.sites.get(name)
    if site is not None and site.box is None:
        return np.array([world.position(name)[:2]])
    box, pose = world.box(name), world.pose(name)
    across, along = (np.linspace(-h, h, max(2, math.ceil(h / 0.0025) + 1)) for h in box.half[:2])
    grid = np.stack(np.meshgrid(across, along, (-box.half[2], box.half[2])), axis=-1)
    axes = np.array([pose.axis(0), pose.axis(1), pose.axis(2)])
    return ((grid.reshape(-1, 3) + box.center) @ axes + pose.position)[:, :2]


def reach(shape) -> float:
    return math.hypot(*shape.size[:2]) / 2 if isinstance(shape, BoxShape) else shape.radius


@pytest.mark.parametrize("name", sorted(Catalogue.discover().tasks))
def test_distractors_keep_clear_of_what_the_task_names(name):
    task = load_task(name)
    world = build_world(task.file)
    named = named_in(task)
    named -= {"table"}  # on which the robots stand, and everything else
    judge = Referee(task.description, task.agents)
    world.watch_forces(judge.force_pairs)
    drawn = 0
    for seed in SEEDS:
        world.reset(seed)
        without = judge.start(world)
        world.reset(seed, looks=LOOK_PARTS)
        assert judge.start(world) == without
        things = {each: spots(world, each) for each in named}
        drawn += len(world.look.distractors)
        for one in world.look.distractors:
            for each, points in things.items():
                gap = np.linalg.norm(points - one.pose.position[:2], axis=1).min()
                assert gap - reach(one.shape) > MARGIN_M, (seed, each)
    assert drawn > len(SEEDS)
    world.close()
