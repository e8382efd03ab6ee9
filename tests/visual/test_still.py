"""Stills, depth and masks of known scenes, and contact sheets."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import cv2
import numpy as np
import pytest

from taskbuilder.cameras import Image
from taskbuilder.errors import SimulationError, UnknownNameError
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.load import TaskFile, read_task
from taskbuilder.sim.renderers import probe_egl
from taskbuilder.visual.still import (
    Modality,
    Still,
    contact_sheet,
    save_image,
    save_still,
    take_still,
)
from taskbuilder.world.building import build_world
from taskbuilder.world.world import World

MODALITIES = get_args(Modality)

SCENE = """\
task: wall
summary: A wall, a block before it, and a robot out of sight.
scene:
  robots:
    arm: {model: ur5e, base: {position: [5, 5, 0]}}
  objects:
    wall: {shape: {box: [4, 0.2, 4]}, fixed: true, position: [0, 0, 2], color: blue}
    block: {shape: {box: [0.2, 0.2, 0.2]}, fixed: true, position: [0, -0.5, 1], color: red}
  sites:
    goal: {position: [0.6, -0.5, 1], marker: {sphere: 0.1}, color: green, opacity: 1}
    flag: {position: [0, 0, 0.1], in: block, marker: {box: [0.02, 0.02, 0.4]}, color: yellow}
  cameras:
    front: {position: [0, -2.1, 1], look_at: [0, 0, 1], size: [160, 120]}
    away: {position: [0, -2.1, 1], look_at: [0, -4, 1.2], fov_deg: 20, size: [64, 48]}
    wrist: {mount: arm.tcp, size: [64, 48]}
    huge: {position: [0, -2.1, 1], look_at: [0, 0, 1], size: [4096, 16]}
variations:
  - {block.color: yellow}
  - {block.position: [0.3, -0.5, 1]}
"""
WALL_M, BLOCK_M = 2.0, 1.5  # from the camera to the wall's face, and to the block's


@pytest.fixture(scope="module")
def task(tmp_path_factory: pytest.TempPathFactory) -> TaskFile:
    file = tmp_path_factory.mktemp("scene") / "wall.yaml"
    file.write_text(SCENE)
    return read_task(CatalogueEntry("wall", file), Catalogue())


@pytest.fixture(scope="module")
def world(task: TaskFile) -> Iterator[World]:
    built = build_world(task)
    built.reset(0)
    yield built
    built.close()


@pytest.fixture(scope="module")
def still(world: World) -> Still:
    return take_still(world, "front")


def test_a_still_has_the_size_of_its_camera_or_the_one_asked_for(world, still):
    assert still.image.rgb.shape == (120, 160, 3)
    assert take_still(world, "front", (64, 48)).image.rgb.shape == (48, 64, 3)


def test_every_modality_is_a_picture(still):
    for modality in MODALITIES:
        picture = still.colored(modality)
        assert (picture.shape, picture.dtype) == ((120, 160, 3), np.uint8)


def test_depth_is_in_millimetres_along_the_line_of_sight(still):
    depth = still.depth_mm()
    assert (depth.shape, depth.dtype) == ((120, 160), np.uint16)
    assert depth[5, 80] == pytest.approx(WALL_M * 1000, abs=2)
    assert depth[60, 10] == pytest.approx(WALL_M * 1000, abs=2)  # along z, not along the ray
    assert depth[60, 80] == pytest.approx(BLOCK_M * 1000, abs=2)


def test_depth_is_zero_where_nothing_is(world):
    away = take_still(world, "away")
    nothing = away.image.mask == 0
    assert nothing.any()
    assert not away.depth_mm()[nothing].any()
    assert (away.colored_depth()[nothing] == 0).all()


def test_near_is_bright_and_far_is_dark(still):
    shown = still.colored_depth().astype(int).sum(axis=2)
    assert shown[60, 80] > shown[5, 80]


def test_the_legend_names_what_the_mask_shows(still):
    legend, mask = still.legend(), still.colored_mask()
    assert set(legend) == {"floor", "arm", "wall", "block", "goal", "flag"}
    assert len({tuple(color) for color in legend.values()}) == len(legend)
    assert mask[5, 80].tolist() == legend["wall"]
    assert mask[65, 80].tolist() == legend["block"]
    assert mask[60, 80 + 48].tolist() == legend["goal"]
    assert mask[40, 80].tolist() == legend["flag"]  # the marker of a site that rides on the block
    assert {tuple(color) for color in mask.reshape(-1, 3).tolist()} <= {
        *map(tuple, legend.values()),
        (255, 255, 255),
    }


def test_colours_are_those_of_the_scene(still):
    red, _, blue = still.image.rgb[64, 80].astype(int)
    assert red > 2 * blue
    red, _, blue = still.image.rgb[5, 80].astype(int)
    assert blue > 2 * red


def test_a_mounted_camera_sees_from_its_mount(world):
    seen = take_still(world, "wrist")
    assert seen.image.rgb.shape == (48, 64, 3)
    assert seen.image.shows("arm").any()
    assert not seen.image.shows("wall").any()


def test_the_same_moment_gives_the_same_picture(world, still):
    assert np.array_equal(take_still(world, "front").image.rgb, still.image.rgb)


@pytest.mark.parametrize("variation", [1, 2])
def test_a_variation_changes_the_picture(variation, task, still):
    varied = build_world(task, variation=variation)
    varied.reset(0)
    seen = take_still(varied, "front")
    varied.close()
    assert not np.array_equal(seen.image.rgb, still.image.rgb)
    assert np.array_equal(seen.image.mask, still.image.mask) == (variation == 1)


def test_seeds_put_things_elsewhere():
    catalogue = Catalogue.discover()
    world = build_world(read_task(catalogue.task("handover"), catalogue))
    pictures = []
    for seed in (0, 1, 0):
        world.reset(seed)
        pictures.append(take_still(world, "front", (160, 120)).image.rgb)
    world.close()
    assert not np.array_equal(pictures[0], pictures[1])
    assert np.array_equal(pictures[0], pictures[2])


def test_a_camera_too_large_to_be_drawn_twice_as_large_is_drawn_once(world):
    assert take_still(world, "huge").image.rgb.shape == (16, 4096, 3)


def test_an_unknown_camera_is_refused_with_a_hint(world):
    with pytest.raises(UnknownNameError, match=r'no camera "frnt"; did you mean "front"\?'):
        take_still(world, "frnt")


def test_a_picture_beyond_reason_is_refused(world):
    with pytest.raises(SimulationError, match="cannot be drawn"):
        take_still(world, "front", (20_000, 20_000))


egl = probe_egl()


@pytest.mark.skipif(not egl.works, reason=f"EGL does not work here: {egl.reason}")
def test_egl_and_tiny_see_the_same_things(task, still):
    world = build_world(task, renderer="egl")
    world.reset(0)
    seen = take_still(world, "front")
    world.close()
    same = seen.image.mask == still.image.mask
    assert same.mean() > 0.98
    gap = np.abs(seen.depth_mm().astype(int) - still.depth_mm().astype(int))
    assert np.median(gap) <= 3


# Contact sheets


def made_up(count: int, size: tuple[int, int] = (64, 48)) -> list[Still]:
    """Stills of one colour each, in which the left half is a body."""
    width, height = size
    stills = []
    for index in range(count):
        mask = np.zeros((height, width), dtype=np.int16)
        mask[:, : width // 2] = 1
        image = Image(
            rgb=np.full((height, width, 3), 40 * index, dtype=np.uint8),
            depth=np.ones((height, width), dtype=np.float32),
            mask=mask,
            names=("background", "wall"),
            intrinsics=np.eye(3),
        )
        stills.append(Still(f"camera_{index}", image))
    return stills


@pytest.mark.parametrize("modalities", [1, 2, 3])
@pytest.mark.parametrize("cameras", [1, 2, 3, 4, 5])
def test_a_sheet_has_a_place_for_every_picture(cameras, modalities):
    sheet = contact_sheet("task", "What it is.", made_up(cameras), MODALITIES[:modalities])
    columns = cameras if modalities > 1 else min(cameras, 2)
    rows = modalities if modalities > 1 else -(-cameras // 2)
    tile = max(240, min(640, 1600 // columns))
    height = round(48 * tile / 64) + 30
    assert sheet.shape == (78 + rows * height, columns * (tile + 24) + 24, 3)
    assert sheet.dtype == np.uint8
    for index in range(cameras):
        row, column = (0, index) if modalities > 1 else divmod(index, 2)
        middle = sheet[78 + row * height + height // 2, 24 + column * (tile + 24) + tile // 2]
        assert middle.tolist() == [40 * index] * 3


def test_a_sheet_takes_pictures_of_different_sizes(still):
    upright, lying = made_up(1, (48, 96)), made_up(1, (96, 48))
    sheet = contact_sheet("task", "What it is.", [*upright, *lying], ["rgb"])
    assert sheet.shape == (78 + 1280 + 30, 2 * 664 + 24, 3)


def test_a_long_summary_is_cut_at_the_edge_of_the_page():
    short, long = (
        contact_sheet("task", "word " * count, made_up(1), ["rgb"]) for count in (10, 200)
    )
    assert short.shape == long.shape
    ink = (long[:78] != [252, 251, 250]).any(axis=2)
    right = int(np.flatnonzero(ink.any(axis=0))[-1])
    assert 600 < right < 24 + 640


# Files


def test_what_is_written_is_read_back(still, tmp_path):
    files = save_still(still, tmp_path / "wall-front", MODALITIES)
    assert [file.name for file in files] == [
        "wall-front.png",
        "wall-front-depth.png",
        "wall-front-mask.png",
        "wall-front-mask.json",
    ]
    rgb, depth, mask, legend = files
    assert np.array_equal(cv2.imread(str(rgb))[:, :, ::-1], still.image.rgb)
    assert np.array_equal(cv2.imread(str(depth), cv2.IMREAD_UNCHANGED), still.depth_mm())
    assert np.array_equal(cv2.imread(str(mask))[:, :, ::-1], still.colored_mask())
    assert json.loads(legend.read_text()) == still.legend()


def test_a_file_that_cannot_be_finished_is_not_begun(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError("the disk is full")

    old = tmp_path / "picture.png"
    old.write_bytes(b"old")
    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(OSError, match="full"):
        save_image(old, np.zeros((2, 2, 3), dtype=np.uint8))
    assert [file.name for file in tmp_path.iterdir()] == ["picture.png"]
    assert old.read_bytes() == b"old"
