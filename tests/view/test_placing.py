"""Things are moved by hand on the page, and the task file says so afterwards."""

from __future__ import annotations

import math
from contextlib import closing

import pytest

from taskbuilder.errors import UsageError
from taskbuilder.geometry import Pose, from_rpy_deg
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.rewrite import rewritten
from taskbuilder.task import load_task
from taskbuilder.view.place_tab import BACK, NOTHING, UNDO, WRITE
from taskbuilder.view.placing import Placing, movables
from taskbuilder.view.regions import RegionPlacing
from taskbuilder.world.building import build_world
from tests.view.test_page import parts, turn

UP = Pose((0.0, 0.0, 0.05))
TURNED = Pose((0.02, -0.03, 0.0), from_rpy_deg((0.0, 0.0, 20.0)))


def take(page, label):
    page.place.choice.value = label
    turn(page, lambda: page.place.placing is not None and str(page.place.placing.thing) == label)
    return page.place.placing


def shifted(pose, by):
    x, y, z = (a + b for a, b in zip(pose.position, by, strict=True))
    return Pose((x, y, z), pose.quaternion)


def test_an_object_is_moved_written_and_taken_back(page_of, touch):
    text = touch.read_text()
    page = page_of(touch)
    placing = take(page, "cube (object)")
    page.ask(lambda: page.place.move(shifted(placing.pose, (0.1, 0.0, 0.0))))
    turn(page, lambda: "position: [0.6, 0.2, 0.02]" in page.place.words.content)
    words = page.place.words.content
    assert "# scene.objects.cube.position\n# was [0.5, 0.2, 0.02]\n" in words
    line = "    cube: {shape: {box: [0.04, 0.04, 0.04]}, mass: 0.1, position: [0.5, 0.2, 0.02]}"
    changed = f"-{line}\n+{line.replace('[0.5, 0.2', '[0.6, 0.2')}"
    assert words.endswith(f"touch.yaml changes so:\n\n```diff\n{changed}\n```")
    page.ask(lambda: page.place.do(WRITE))
    wanted = text.replace("position: [0.5, 0.2, 0.02]", "position: [0.6, 0.2, 0.02]")
    turn(page, lambda: touch.read_text() == wanted)
    world = page.scene.world
    turn(page, lambda: page.scene.world is not world)  # the page follows the file
    assert page.scene.world.pose("cube").position[0] == pytest.approx(0.6, abs=1e-3)
    assert str(page.place.placing.thing) == "cube (object)"
    page.ask(lambda: page.place.do(UNDO))
    turn(page, lambda: touch.read_text() == text)
    page.ask(lambda: page.place.do(UNDO))
    turn(page, lambda: "nothing has been written" in page.place.words.content)


def test_a_thing_is_put_back(page_of, touch):
    page = page_of(touch)
    placing = take(page, "cube (object)")
    before = placing.pose
    page.ask(lambda: page.place.move(shifted(before, (0.1, 0.0, 0.0))))
    turn(page, lambda: placing.values)
    page.ask(lambda: page.place.do(BACK))
    turn(page, lambda: not placing.values)
    assert page.scene.world.pose("cube").position == pytest.approx(before.position, abs=1e-6)
    page.ask(lambda: page.place.do(WRITE))
    turn(page, lambda: "nothing has moved" in page.place.words.content)


def test_the_tool_is_jogged_and_a_pose_out_of_reach_is_told(page_of, touch):
    page = page_of(touch)
    placing = take(page, "arm (tool at the start)")
    page.ask(lambda: page.place.move(Pose((0.4, 0.1, 0.5), from_rpy_deg((180, 0, 0)))))
    turn(page, lambda: placing.solution is not None)
    assert placing.solution.ok
    assert "joints" in page.place.words.content
    robot = page.scene.world.robots["arm"]
    assert robot.tcp.position == pytest.approx((0.4, 0.1, 0.5), abs=2e-3)
    page.ask(lambda: page.place.do(WRITE))
    home = "home: {tcp: {position: [0.4, 0.1, 0.5], rpy_deg: [180, 0, 0]}}"
    turn(page, lambda: home in touch.read_text())
    placing = take(page, "arm (tool at the start)")
    page.ask(lambda: page.place.move(Pose((3.0, 0.0, 0.5), from_rpy_deg((180, 0, 0)))))
    turn(page, lambda: "out of reach" in page.place.words.content)


def test_what_lies_inside_something_else_is_told(page_of, touch):
    page = page_of(touch)
    placing = take(page, "cube (object)")
    page.ask(lambda: page.place.move(Pose((0.0, 0.0, 0.1))))
    turn(page, lambda: placing.values)
    assert "mm inside arm" in page.place.words.content


def test_a_camera_shows_what_it_sees_from_there(page_of, touch):
    page = page_of(touch)
    placing = take(page, "front (camera)")
    assert placing.view(240).width == 240
    page.ask(lambda: page.place.move(shifted(placing.pose, (0.0, 0.1, 0.0))))
    turn(page, lambda: placing.values)
    page.ask(lambda: page.place.do(WRITE))
    turn(page, lambda: "position: [1.2, 0.1, 0.8], look_at: [0.4, 0.1, 0.2]" in touch.read_text())


def test_a_file_that_has_changed_meanwhile_is_not_written(page_of, touch, monkeypatch):
    page = page_of(touch)
    placing = take(page, "cube (object)")
    placing.move(shifted(placing.pose, (0.1, 0.0, 0.0)))
    correction = page.place._correction()
    touch.write_text(touch.read_text() + "# mine\n")
    monkeypatch.setattr(page.place, "_correction", lambda: correction)
    page.place.do(WRITE)
    assert "has changed meanwhile" in page.place.words.content
    assert touch.read_text().endswith("# mine\n")


def test_a_click_takes_what_can_be_moved(page_of, touch):
    page = page_of(touch)
    assert page.place.choice.value == NOTHING
    page.ask(lambda: page.scene.pick("arm.panda_link3"))
    turn(page, lambda: page.place.placing is not None)
    assert str(page.place.placing.thing) == "arm (base)"


def test_a_region_is_moved_resized_written_and_taken_back(page_of, with_region, server):
    text = with_region.read_text()
    page = page_of(with_region)
    placing = take(page, "cube (region)")
    assert {"/placed", "/corner", "/region"} <= parts(server)
    assert placing.pose.position == pytest.approx((0.4, 0.2, 0.103), abs=1e-6)
    assert placing.corner.position == pytest.approx((0.45, 0.3, 0.103), abs=1e-6)
    cube = page.scene.world.pose("cube")
    page.ask(lambda: page.place.move(shifted(placing.pose, (0.1, -0.1, 0.3))))
    turn(page, lambda: "center: [0.5, 0.1]" in page.place.words.content)
    corner = server.viser.scene._handle_from_node_name["/corner"]
    assert tuple(corner.position) == pytest.approx((0.55, 0.2, 0.103), abs=1e-6)
    page.ask(lambda: page.place.resize(shifted(placing.corner, (0.05, -0.08, 0.0))))
    turn(page, lambda: "size: [0.2, 0.04]" in page.place.words.content)
    assert page.scene.world.pose("cube") == cube  # the file has to be written first
    edges = server.viser.scene._handle_from_node_name["/region"].points
    assert edges.min(axis=(0, 1)) == pytest.approx((0.4, 0.08, 0.103), abs=1e-6)
    page.ask(lambda: page.place.do(WRITE))
    wanted = text.replace("[0.4, 0.2], size: [0.1, 0.2]", "[0.5, 0.1], size: [0.2, 0.04]")
    world = page.scene.world
    turn(page, lambda: page.scene.world is not world)  # the page follows the file
    assert with_region.read_text() == wanted
    assert page.place.placing.size == pytest.approx((0.2, 0.04))
    for gizmo in ("/placed", "/corner"):  # it lies on the table, so nothing points upwards
        handle = server.viser.scene._handle_from_node_name[gizmo]
        assert tuple(handle.active_axes) == (True, True, False)
    page.ask(lambda: page.place.do(UNDO))
    turn(page, lambda: with_region.read_text() == text)


def test_a_region_is_put_back_and_one_beyond_its_surface_is_told(page_of, with_region, server):
    page = page_of(with_region)
    placing = take(page, "cube (region)")
    page.ask(lambda: page.place.move(shifted(placing.pose, (0.0, 0.25, 0.0))))
    turn(page, lambda: placing.values)
    assert "✗ it reaches beyond table" in page.place.words.content
    page.ask(lambda: page.place.resize(placing.pose))  # as small as can be
    turn(page, lambda: placing.size == pytest.approx((0.0, 0.0), abs=1e-6))
    page.ask(lambda: page.place.do(BACK))
    turn(page, lambda: not placing.values)
    assert placing.size == (0.1, 0.2)
    assert "beyond" not in page.place.words.content
    gizmo = server.viser.scene._handle_from_node_name["/placed"]
    assert tuple(gizmo.position) == pytest.approx(placing.pose.position)
    page.place.choice.value = NOTHING
    turn(page, lambda: page.place.placing is None)
    assert not {"/placed", "/corner", "/region"} & parts(server)


def test_a_region_in_the_air_has_a_height(page_of, touch, server):
    region = "{place: {center: [0.45, 0, 0.4], size: [0.1, 0.2, 0.3]}}"
    touch.write_text(touch.read_text().replace("{position: [0.45, 0, 0.4]}", region))
    page = page_of(touch)
    placing = take(page, "ball (region)")
    assert len(placing.edges()) == 12
    gizmo = server.viser.scene._handle_from_node_name["/placed"]
    assert tuple(gizmo.active_axes) == (True, True, True)
    page.ask(lambda: page.place.move(shifted(placing.pose, (0.0, 0.0, 0.1))))
    turn(page, lambda: "center: [0.45, 0, 0.5]" in page.place.words.content)
    page.ask(lambda: page.place.resize(shifted(placing.corner, (0.0, 0.0, -0.05))))
    turn(page, lambda: "size: [0.1, 0.2, 0.2]" in page.place.words.content)


CASES = [("handover", 0, None), ("pick_push_place", 1, None), ("gather_cubes", 0, "cubes")]
"""Tasks with a variation, and the one thing that is moved, or all: a group is moved as a whole."""


@pytest.mark.parametrize(("name", "variation", "only"), CASES)
def test_what_is_written_puts_things_where_they_were_dragged(name, variation, only, tmp_path):
    """For everything in some tasks of the library, one thing after the other."""
    entry = Catalogue.discover().tasks[name]
    text = entry.file.read_text(encoding="utf-8")
    copy = tmp_path / entry.file.name
    copy.with_suffix(".py").write_bytes(entry.file.with_suffix(".py").read_bytes())
    file = load_task(name).file
    with closing(build_world(file, variation=variation)) as world:
        world.reset(0)
        for thing in movables(world):
            if only not in (None, thing.name):
                continue
            placing = placing_of(world, variation, thing)
            before = placing.pose
            # The base takes its tool along, and an arm reaches only so far.
            change = TURNED if thing.sort != "tool" else Pose((0.0, 0.0, 0.01))
            placing.move(Pose(change.position) @ before @ Pose(quaternion=change.quaternion))
            assert placing.values
            try:
                copy.write_text(rewritten(text, placing.values), encoding="utf-8")
            except UsageError as error:
                if not any(mark in str(error) for mark in ("(*)", "(&)")):
                    raise
            else:
                there = where(copy, variation, thing)
                assert there == pytest.approx(placing.pose.position, abs=2e-3), thing
            placing.put_back()
            assert math.dist(placing.pose.position, before.position) < 1e-6


def where(file, variation, thing):
    """Where a thing is, in a task that was written."""
    with closing(build_world(load_task(str(file)).file, variation=variation)) as world:
        world.reset(0)
        return placing_of(world, variation, thing).pose.position


def placing_of(world, variation, thing):
    """What moves a thing."""
    return (RegionPlacing if thing.sort == "region" else Placing)(world, variation, thing)
