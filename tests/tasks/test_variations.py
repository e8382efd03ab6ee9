"""What is held out for tests is a new mixture, and not a place that training has never seen."""

from __future__ import annotations

import re

import numpy as np
import pytest

from taskbuilder import catalogue, load_task
from taskbuilder.schema.suites import find_suites

OUTSIDE_M = 0.03
"""How far from where it always stands in training a thing may stand in the test."""

OUTSIDE = 0.5
"""How far outside of where it may be in training, as a share of that range."""


def where(scene):
    """The x and y that each thing may have, in its frame; one for all of those that are counted."""
    boxes = {}
    for name, thing in {**scene.objects, **scene.sites}.items():
        center, size = thing.position, 0.0
        if thing.place is not None:
            center, size = thing.place.center, np.array(thing.place.size)
        if center is not None:
            box = (np.array(center) - size / 2)[:2], (np.array(center) + size / 2)[:2]
            boxes.setdefault(re.sub(r"_\d+$", "", name), []).append(box)
    return {name: hull(several) for name, several in boxes.items()}


def hull(boxes):
    return np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)


CASES = [
    pytest.param(suite, name, id=f"{suite.name}-{name}")
    for suite in find_suites(catalogue()).values()
    for name in suite.tasks
]


@pytest.mark.parametrize(("suite", "name"), CASES)
def test_things_of_the_test_variation_stand_where_training_has_them(suite, name):
    scenes = load_task(name).file.scenes
    trained = [where(scenes[number]) for number in suite.train.variations]
    for number in suite.test.variations:
        for thing, (low, high) in where(scenes[number]).items():
            middle = (low + high) / 2
            lowest, highest = hull([boxes[thing] for boxes in trained if thing in boxes])
            outside = np.maximum(lowest - middle, middle - highest)
            most = np.maximum(OUTSIDE_M, OUTSIDE * (highest - lowest)) + 1e-9
            assert (outside <= most).all(), f"{thing}: {100 * outside.max():.1f} cm outside"


@pytest.mark.parametrize(("suite", "name"), CASES)
def test_fixed_things_of_the_test_variation_have_shapes_that_training_has(suite, name):
    """Policies that observe no pictures cannot see how high a wall is."""
    scenes = load_task(name).file.scenes
    for number in suite.test.variations:
        for thing, spec in scenes[number].objects.items():
            trained = [scenes[other].objects[thing] for other in suite.train.variations]
            if spec.fixed:
                assert (spec.shape, spec.parts) in [(one.shape, one.parts) for one in trained]
