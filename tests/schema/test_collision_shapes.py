"""Objects and links that can be seen and not be touched, and joints that start where others do."""

from __future__ import annotations

import re

import pytest
from task_texts import CABINET

from taskbuilder.assets.model import Urdf
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import read_task

SITES = "  sites:\n"
PLACED = "place: {surface: table, center: [0.3, 0], size: [0, 0]}"
LOOK = '<visual><geometry><box size="0.2 0.2 0.1"/></geometry></visual>'
SOLID = re.compile("<collision>(.*?)</collision>")


def looks(text, count=0):
    """A URDF whose first collision shapes, or all, are only looked at."""
    return SOLID.sub(r"<visual>\1</visual>", text, count=count)


@pytest.fixture
def found(findings, folder):
    """What is found of the plain task with a cabinet of the given URDF and keys."""

    def read(urdf, keys, *changes):
        (folder / "cabinet.urdf").write_text(urdf)
        cabinet = f"    cabinet: {{shape: {{urdf: cabinet.urdf}}, {keys}}}\n"
        return findings((SITES, cabinet + SITES), *changes)

    return read


FIXED = "fixed: true, position: [0.5, 0.3, 0.5]"


def test_an_object_without_collision_shapes_cannot_be_placed(found):
    (finding,) = found(looks(CABINET), f"fixed: true, {PLACED}")
    assert "cabinet.urdf:2:3: error[TB424] link base: cabinet has no collision shape" in finding
    assert "add <collision>" in finding


def test_an_object_that_falls_needs_a_collision_shape(found):
    text = CABINET.replace('<link name="base"/>', f'<link name="base">{LOOK}</link>')
    (finding, *_) = found(looks(text), "position: [0.5, 0.3, 0.5]")
    assert "error[TB424] link base" in finding


def test_what_is_fixed_to_be_looked_at_needs_none(found):
    assert found(looks(CABINET), FIXED) == []


def test_other_mistakes_are_reported_beside_it(found):
    wrong = found(looks(CABINET), f"fixed: true, {PLACED}", ("mass: 0.1", "mas: 0.1"))
    wrong_again = found(CABINET, FIXED, ("surface: table", "surface: tabel"))
    assert any("TB201" in finding for finding in wrong_again)
    assert any("mas" in finding for finding in wrong)


def test_nothing_can_stand_on_what_cannot_be_touched(found):
    changes = ("surface: table", "surface: cabinet.drawer")
    wrong = found(looks(CABINET, 1), FIXED, changes)
    (surface,) = [finding for finding in wrong if "cube" in finding]
    assert "error[TB424] scene.objects.cube.place.surface" in surface
    assert "name one that has: cabinet.door" in surface


def test_a_link_that_moves_and_is_only_seen_is_doubtful(load, folder):
    (folder / "cabinet.urdf").write_text(looks(CABINET, 1))
    cabinet = f"    cabinet: {{shape: {{urdf: cabinet.urdf}}, {FIXED}}}\n"
    (finding,) = load((SITES, cabinet + SITES)).warnings
    assert (finding.code, finding.severity, finding.path) == ("TB424", "warning", "link drawer")
    assert finding.location.line == 3


@pytest.mark.parametrize("start", ["{start_deg: 10}", "10"])
def test_a_joint_that_mimics_another_has_no_start_of_its_own(found, start):
    mimic = CABINET.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 1"/><mimic joint="slide"/>')
    (finding,) = found(mimic, f"{FIXED}, joints: {{hinge: {start}}}")
    assert "error[TB106] scene.objects.cabinet.joints.hinge: hinge mimics slide" in finding
    assert found(mimic, f"{FIXED}, joints: {{slide: 0.1}}") == []


@pytest.mark.parametrize("task", Catalogue.discover().tasks)
def test_nothing_is_doubtful_about_the_objects_of_the_library(task):
    catalogue = Catalogue.discover()
    file = read_task(catalogue.task(task), catalogue)
    assert file.warnings == ()
    assert not [
        w for asset in file.assets.values() if isinstance(asset, Urdf) for w in asset.warnings
    ]
