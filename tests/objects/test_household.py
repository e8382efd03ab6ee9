"""The household shelf: every object loads, rests, holds what it should, and can be grasped."""

from __future__ import annotations

import filecmp
import math
import runpy
import shutil
import sys
from pathlib import Path

import pytest
from shelf import TABLE_M, trial

import taskbuilder as tb
from taskbuilder.assets.mesh import read_mesh
from taskbuilder.assets.model import Urdf
from taskbuilder.expert.script.player import Expert
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.object_files import load_object
from taskbuilder.world.building import build_world
from taskbuilder.world.inertias import inertias

OBJECTS = Catalogue().objects
FOLDER = Path(__file__).resolve().parents[2] / "objects"

WANTED = (
    *("basket", "book", "bottle", "bowl", "box", "can", "cup", "dustpan", "hammer", "jar"),
    *("laptop", "mug", "pan", "plate", "shoe", "sponge", "spoon", "tray"),
)

GRASPED: dict[str, dict[str, object]] = {
    **{name: {} for name in ("basket", "bottle", "bowl", "can", "cup", "dustpan", "hammer")},
    **{name: {} for name in ("jar", "mug", "pan", "shoe", "sponge", "spoon")},
    "book": {"roll": 90, "above": 0.1},  # upright, as on a shelf
    "plate": {"grasp": "left", "x": 0.25, "stand": 0.16, "sideways": True},
}
"""How one gripper takes an object. It takes two for a tray; a box and a laptop are too wide."""

HOLLOW = {
    "basket": 0.05,
    "bowl": 0.02,
    "cup": 0.02,
    "dustpan": 0.02,
    "mug": 0.025,
    "pan": 0.03,
    "plate": 0.02,
    "tray": 0.05,
}
"""Objects that hold a ball of 2 cm, and how far from their axis it may roll, m."""


def test_the_shelf_is_whole():
    assert set(WANTED) <= OBJECTS.keys()


@pytest.mark.parametrize("name", WANTED)
def test_an_object_is_right(name):
    model = load_object(OBJECTS[name])
    assert not model.assets.warnings
    assert model.spec.summary
    assert model.spec.grasps
    looks = [file for file in FOLDER.joinpath(name).glob("*.obj") if "pieces" not in file.name]
    assert sum(read_mesh(file).triangles for file in looks) <= 2_000
    if isinstance(model.assets.main, Urdf):
        factors = [each.factor for each in inertias(model.assets.main, fixed=False)]
        assert all(math.isclose(factor, 1.0, rel_tol=0.01) for factor in factors)


def test_the_script_writes_the_same_bytes(tmp_path, monkeypatch):
    for file in FOLDER.glob("*.py"):
        shutil.copy(file, tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "modelling", raising=False)
    runpy.run_path(str(tmp_path / "generate.py"), run_name="__main__")
    monkeypatch.delitem(sys.modules, "modelling", raising=False)
    for name in WANTED:
        made = sorted(file.name for file in (tmp_path / name).iterdir())
        assert made == sorted(file.name for file in (FOLDER / name).iterdir())
        _, different, wrong = filecmp.cmpfiles(tmp_path / name, FOLDER / name, made, shallow=False)
        assert not different
        assert not wrong


@pytest.mark.parametrize("name", WANTED)
def test_an_object_rests_where_it_is_put(name, tmp_path):
    grasp = "grasp" if name in GRASPED or name == "box" else "left"
    grasp = str(GRASPED.get(name, {}).get("grasp", grasp))
    world = build_world(trial(tmp_path, f"object: {name}", grasp=grasp).file)
    try:
        world.reset(0)
        before = world.pose("thing")
        for _ in range(5 * 10):
            world.step()
        after = world.pose("thing")
        assert math.dist(before.position, after.position) < 5e-4
        assert abs(after.position[2] - TABLE_M) < 1e-3
        tilt = sum(a * b for a, b in zip(before.quaternion, after.quaternion, strict=True))
        assert abs(tilt) > math.cos(math.radians(0.25))
    finally:
        world.close()


@pytest.mark.parametrize("name", HOLLOW)
def test_a_hollow_object_holds_a_ball(name, tmp_path):
    side = 0.03 if name == "basket" else 0.0  # past the handle
    ball = "ball: {shape: {sphere: 0.01}, mass: 0.01, rolling_friction: 0.0005, "
    ball += f"position: [0, {side}, 0.52]}}"
    grasp = "left" if name in ("plate", "tray") else "grasp"
    world = build_world(trial(tmp_path, f"object: {name}", grasp=grasp, others=ball).file)
    try:
        world.reset(0)
        for _ in range(3 * 10):
            world.step()
        x, y, z = (
            a - b
            for a, b in zip(world.pose("ball").position, world.pose("thing").position, strict=True)
        )
        assert math.hypot(x, y) < HOLLOW[name]
        assert 0.01 < z < 0.035
    finally:
        world.close()


@pytest.mark.parametrize("name", GRASPED)
def test_an_object_is_grasped_lifted_and_held(name, tmp_path):
    env = tb.parallel_env(trial(tmp_path, f"object: {name}", **GRASPED[name]))
    expert = Expert(env)
    try:
        played = expert.play(0, finish=False)
        assert played.trouble is None
        world = env.episode.world
        for _ in range(2 * 10):
            world.step()
        assert world.held("thing", "arm")
        assert world.pose("thing").position[2] - world.pose("up").position[2] > -0.02
    finally:
        expert.close()
        env.close()


def test_the_lid_of_the_jar_rises_as_it_turns(tmp_path):
    heights = []
    for turned in (0, 360):
        thing = f"object: jar, joints: {{screw: {{start_deg: {turned}}}}}"
        world = build_world(trial(tmp_path, thing).file)
        try:
            world.reset(0)
            heights.append(world.pose("thing.lid").position[2])
        finally:
            world.close()
    assert heights[1] - heights[0] == pytest.approx(0.008 / 1.5, abs=3e-4)


def test_objects_of_the_shelf_come_in_groups(tmp_path):
    cups = "cups: {object: cup, count: 3, arrange: {line: 0.1}, position: [0.4, 0, 0.4]}"
    task = trial(tmp_path, "object: mug", others=cups)
    world = build_world(task.file)
    try:
        world.reset(0)
        assert world.pose("cups_3").position[0] - world.pose("cups_1").position[0] == (
            pytest.approx(0.2, abs=1e-3)
        )
        assert world.pose("cups_2.rim").position[2] > TABLE_M + 0.08
    finally:
        world.close()
