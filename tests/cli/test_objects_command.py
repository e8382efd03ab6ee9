"""`taskbuilder objects`."""

from __future__ import annotations

import cv2
import pytest

from taskbuilder.schema.catalogue import Catalogue

OBJECTS = sorted(Catalogue().objects)


def test_the_list_names_every_object(run):
    rows = run("objects").out.splitlines()[1:]
    assert [name for row in rows if (name := row[:1].strip() and row.split()[0])] == OBJECTS


def test_the_list_for_programs(run):
    listed = {each["name"]: each for each in run("objects", "list", "--json").data["objects"]}
    assert sorted(listed) == OBJECTS
    assert listed["mug"]["shape"] == "mesh"
    assert {"rim", "handle"} <= set(listed["mug"]["grasps"])
    assert listed["jar"]["joints"] == ["rise", "screw"]


def test_a_check_renders_the_object(run):
    ran = run("objects", "check", "mug")
    assert ran.status == 0
    assert "0.28 kg" in ran.out
    assert "handle" in ran.out
    pixels = cv2.imread("renders/mug.png")
    reddish = (pixels[:, :, 2].astype(int) - pixels[:, :, 1]) > 60
    assert reddish.mean() > 0.03


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("object: block\nsummary: A block.\nshape: {mesh: no.obj}\nmass: 1\n", "no.obj"),
        ("object: brick\nsummary: A block.\nshape: {sphere: 0.1}\nmass: 1\n", "use one name"),
        ("object: block\nsummary: A block.\nshape: {sphere: 0.1}\n", "mass is missing"),
        ("object: block\nsummary: A block.\nmass: 1\n", "exactly one of shape, parts"),
        ("object: block\nsummary: A block.\nshape: {sphere: 0.1}\nmas: 1\n", '"mass"'),
        (
            "object: block\nsummary: A block.\nshape: {sphere: 0.1}\nmass: 1\n"
            "grasps: {top: {link: lid}}\n",
            "no URDF and has no links",
        ),
    ],
)
def test_what_is_wrong_with_an_object_is_said_where_it_is(run, tmp_path, text, message):
    file = tmp_path / "block" / "object.yaml"
    file.parent.mkdir()
    file.write_text(text, encoding="utf-8")
    ran = run("objects", "check", str(file))
    assert ran.status == 1
    assert message in ran.out
    assert "object.yaml:" in ran.out
    assert "(has errors)" in run("objects", "--task-path", str(tmp_path)).out


def test_an_object_that_there_is_not(run):
    ran = run("objects", "check", "mugg")
    assert ran.status == 2
    assert 'did you mean "mug"?' in ran.err


def test_check_wants_a_name(run):
    ran = run("objects", "check")
    assert ran.status == 2
    assert "which object?" in ran.err
