"""What `render --show` draws over pictures: where, over what, and with names that can be read."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from taskbuilder.cameras import CameraView
from taskbuilder.errors import UnknownNameError
from taskbuilder.geometry import Pose
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.load import read_task
from taskbuilder.visual.annotations import AXES, SHOWN, Annotator, axes, check_words
from taskbuilder.visual.ink import FADED, Lens, Marks, Patch, Stroke, Tag, drawn_over
from taskbuilder.visual.labels import Label, place_labels
from taskbuilder.visual.outlines import outlines
from taskbuilder.visual.still import take_still
from taskbuilder.world.building import build_world
from taskbuilder.world.reach import reach_map
from taskbuilder.world.world import World

RED = (200, 0, 0)
SIZE = (160, 120)

SCENE = """\
task: bench
summary: A robot, a cube to be placed, and a goal.
scene:
  robots:
    arm: {model: ur5e, base: {position: [-0.6, 0, 0.4]}}
  objects:
    table: {shape: {box: [1.6, 1.0, 0.04]}, fixed: true, position: [0, 0, 0.38]}
    cube:
      shape: {box: [0.05, 0.05, 0.05]}
      mass: 0.1
      grasps: {top: {across: y}}
      place: {surface: table, center: [-0.1, 0], size: [0.3, 0.2]}
  sites:
    goal: {position: [0.1, 0.2, 0.6], marker: {sphere: 0.02}}
  cameras:
    front: {position: [0, -1.7, 1.3], look_at: [0, 0, 0.4], size: [320, 240]}
    side: {position: [1.2, -0.6, 0.9], look_at: [0, 0, 0.4], size: [320, 240]}
    wrist: {mount: arm.tcp, size: [64, 48]}
"""


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    file = tmp_path_factory.mktemp("scene") / "bench.yaml"
    file.write_text(SCENE)
    made = build_world(read_task(CatalogueEntry("bench", file), Catalogue()))
    made.reset(0)
    yield made
    made.close()


def lens(depth: float = 10.0) -> Lens:
    """A camera at the origin that looks along x, before a wall at some depth."""
    view = CameraView((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), width=SIZE[0], height=SIZE[1])
    focal = SIZE[1] / 2 / math.tan(math.radians(view.fov_deg) / 2)
    matrix = np.array([[focal, 0, SIZE[0] / 2], [0, focal, SIZE[1] / 2], [0, 0, 1.0]])
    return Lens(view.extrinsics, matrix, np.full(SIZE[::-1], depth, np.float32))


def gray() -> np.ndarray:
    return np.full((SIZE[1], SIZE[0], 3), 100, np.uint8)


def line(*, distance: float = 2.0) -> Stroke:
    """A line across the middle of the picture, from left to right."""
    return Stroke(np.array([[distance, 0.5, 0.0], [distance, -0.5, 0.0]]), RED, 3.0)


def test_a_line_is_drawn_where_the_camera_sees_it_and_nowhere_else():
    drawn = drawn_over(gray(), lens(), Marks(strokes=(line(),)))
    changed = np.argwhere((drawn != 100).any(axis=2))
    focal = lens().intrinsics[0, 0]
    assert abs(changed[:, 0].mean() - 60) <= 1
    assert np.ptp(changed[:, 0]) <= 8
    assert changed[:, 1].min() == pytest.approx(80 - focal * 0.25, abs=4)
    assert changed[:, 1].max() == pytest.approx(80 + focal * 0.25, abs=4)
    assert drawn[60, 80, 0] > 180 > drawn[60, 80, 1] + 100
    assert (gray() == 100).all()


def test_what_is_hidden_is_faded():
    seen = drawn_over(gray(), lens(), Marks(strokes=(line(),)))
    hidden = drawn_over(gray(), lens(1.0), Marks(strokes=(line(),)))
    assert 0 < hidden[60, 80, 0] - 100 <= 1.1 * FADED * (seen[60, 80, 0] - 100)


def test_what_is_behind_the_camera_is_not_drawn():
    tag = Tag("behind", np.array([-1.0, 0.0, 0.0]), RED)
    patch = Patch((np.array([[-1.0, 1, 0], [-1.0, -1, 0], [-2.0, 0, 0]]),), RED)
    marks = Marks((patch,), (line(distance=-1.0),), (tag,))
    assert (drawn_over(gray(), lens(), marks) == gray()).all()


def test_a_line_from_behind_the_camera_is_cut_at_the_camera():
    stroke = Stroke(np.array([[-1.0, 0.0, -0.2], [3.0, 0.0, -0.2]]), RED, 3.0)
    changed = np.argwhere((drawn_over(gray(), lens(), Marks(strokes=(stroke,))) != 100).any(axis=2))
    assert changed[:, 0].min() > 60  # below the middle, down to the edge
    assert changed[:, 0].max() == SIZE[1] - 1


def test_an_area_with_a_hole_is_tinted_around_the_hole():
    def square(half: float) -> np.ndarray:
        return np.array(
            [[2.0, y * half, z * half] for y, z in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
        )

    marks = Marks((Patch((square(0.6), square(0.2)), RED, 0.5),))
    seen = drawn_over(gray(), lens(), marks)
    assert seen[60, 80].tolist() == [100, 100, 100]
    assert seen[60, 110].tolist() == pytest.approx([150, 50, 50], abs=2)
    hidden = drawn_over(gray(), lens(1.0), marks)
    assert 100 < hidden[60, 110, 0] < 130


@pytest.mark.parametrize("number", [2, 8, 20])
def test_labels_lie_inside_the_picture_and_not_over_each_other(number):
    labels = [Label(f"thing_{i}", (300 + 3 * i, 200 + 2 * i), RED) for i in range(number)]
    boxes = place_labels(labels, (480, 640, 3))
    for index, box in enumerate(boxes):
        assert 0 <= box.left <= 640 - box.width
        assert 0 <= box.top <= 480 - box.height
        assert not any(box.overlap(other) for other in boxes[:index])


def test_a_lone_label_is_beside_its_point():
    (box,) = place_labels([Label("cube", (300.0, 200.0), RED)], (480, 640, 3))
    assert not box.holds((300.0, 200.0), 0.0)
    assert box.holds((300.0, 200.0), 14.0)


@pytest.mark.parametrize("word", SHOWN)
def test_each_word_draws_something_without_changing_anything_else(word, world):
    still = take_still(world, "front")
    drawn = Annotator(world, [word]).annotated(still)
    assert (drawn.image.rgb != still.image.rgb).any()
    assert drawn.image.depth is still.image.depth


def test_axes_are_those_of_the_frame():
    pose = Pose.from_rpy_deg((0.1, 0.2, 0.3), (180, 0, 30))
    strokes = axes(pose, "tool", 0.1).strokes
    for index, stroke in enumerate(strokes):
        along = (stroke.points[1] - stroke.points[0]) / 0.1
        assert along == pytest.approx(np.array(pose.axis(index)), abs=1e-9)
        assert stroke.color == AXES[index]


def test_nothing_shown_leaves_the_picture_as_it_is(world):
    still = take_still(world, "front")
    assert (Annotator(world, []).annotated(still).image.rgb == still.image.rgb).all()


def test_the_region_is_tinted_where_the_thing_is_placed(world):
    still = take_still(world, "front")
    drawn = Annotator(world, ["regions"]).annotated(still).image.rgb.astype(int)
    view = world.camera("front")
    for x, inside in ((-0.22, True), (0.6, False)):  # beside the cube; beside the region
        point = view.extrinsics @ np.array([x, -0.08, 0.4, 1.0])
        column, row, depth = still.image.intrinsics @ point[:3]
        at = round(row / depth), round(column / depth)
        assert (abs(drawn[at] - still.image.rgb[at]).max() > 8) == inside


def test_a_camera_on_a_tool_is_drawn_without_the_axes_of_its_tool(world):
    still = take_still(world, "wrist")
    Annotator(world, list(SHOWN)).annotated(still)


def test_words_are_taken_once_and_unknown_ones_refused():
    assert check_words(["sites", "frames", "sites"]) == ("sites", "frames")
    with pytest.raises(UnknownNameError, match='"grasp"; did you mean "grasps"'):
        check_words(["grasp"])


def test_the_reach_is_a_ring_around_the_base(world):
    robot = world.robots["arm"]
    found = reach_map(
        robot.chain,
        world.pose("arm.base"),
        robot.home,
        (-1.6, -1.0, 0.43),
        (0.4, 1.0),
        spacing=0.1,
    )
    x = np.linspace(-1.6, 0.4, found.reached.shape[1])
    y = np.linspace(-1.0, 1.0, found.reached.shape[0])
    away = np.hypot(x[None] + 0.6, y[:, None])
    assert found.reached[(away > 0.35) & (away < 0.65)].mean() > 0.95
    assert not found.reached[away > 0.95].any()
    assert not found.reached[away < 0.05].any()
    rings = outlines(found)
    assert rings
    assert all((ring[:, 2] == 0.43).all() for ring in rings)
    assert np.hypot(*(rings[0][:, :2] - [-0.6, 0]).T).max() < 0.95
