"""`taskbuilder explain`: the reference at the shell."""

from __future__ import annotations

import pytest

from taskbuilder import description
from taskbuilder.description import Description
from taskbuilder.reference.codes import known
from taskbuilder.reference.lookup import explain
from taskbuilder.schema.order import VERBS
from taskbuilder.schema.variants import DRIVES


@pytest.mark.parametrize(
    ("name", "whole", "says"),
    [
        ("TB511", "TB511", "out of reach"),
        ("tb101", "TB101", "missing"),
        ("Held", "Held", "Held(body: BodyName"),
        ("grasp", "expert.grasp", "Grasp point to take"),
        ("objects.place", "scene.objects.NAME.place", "yaw_deg: two numbers in degrees"),
        ("objects.place.size", "scene.objects.NAME.place.size", "Full edge lengths"),
        ("control_hz", "timing.control_hz", "Value: Hz, 1 to 1000; by default `10`."),
        ("slide", "expert.slide", "  tolerance: m, 0.0005 to 100"),
        ("Contact", "Contact", "- BodyName: an object, a part or a link"),
        ("BodyName", "BodyName", "A name of an object, a part or a link"),
        ("Beyond", "Beyond", "`Beyond(frame: FrameName, reference: FrameName, *, axis: "),
        ("tcp_velocity", "SUBJECT.tcp_velocity", "angular velocity"),
        ("gripper.stroke", "gripper.stroke", "robot.yaml"),
    ],
)
def test_it_prints_what_a_name_means(name, whole, says, run):
    ran = run("explain", name)
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.startswith(f"{whole}  ")
    assert says in ran.out


def test_a_name_of_several_things_is_told_for_each(run):
    entries = run("explain", "tcp", "--json").data["entries"]
    kinds = [entry["kind"] for entry in entries]
    assert kinds == ["observation channel", "key of task files", "key of robot.yaml"]
    assert entries[1]["keys"][0]["key"] == "`position`"


@pytest.mark.parametrize(
    ("name", "meant"), [("helt", "Held"), ("objects.plac", "objects.place"), ("releese", "release")]
)
def test_an_unknown_name_is_met_with_what_was_meant(name, meant, run):
    ran = run("explain", name)
    assert (ran.status, ran.out) == (2, "")
    assert f'no entry "{name}"; did you mean "{meant}' in ran.err


def test_a_name_like_no_other(run):
    assert "name a finding's code" in run("explain", "zzzzzz").err


def no_part(part):
    """Loads no part of other packages."""
    raise AssertionError(part)


def test_all_that_people_write_is_there():
    names = [*known(), *VERBS, *(name for name in description.__all__ if name[0].isupper())]
    kinds = [name for name in names if not callable(getattr(description, name, len))]
    for name in names:
        if name not in kinds:
            assert explain(name, no_part), name


def test_what_a_description_declares_and_what_robots_draw_has_an_entry():
    declared = [name for name in vars(Description) if name in Description.__annotations__]
    for name in (*declared, *DRIVES):
        assert any(entry.name.endswith(f".{name}") for entry in explain(name, no_part)), name
