"""Looks that vary from episode to episode, and change nothing but pictures."""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from written_tasks import read

from taskbuilder import load_task, parallel_env
from taskbuilder.errors import UsageError
from taskbuilder.schema.task import LOOK_PARTS
from taskbuilder.shapes import BoxShape, SphereShape
from taskbuilder.world.distractors import CLEAR_M, HALF_M
from taskbuilder.world.looks import AS_WRITTEN, SHIFT_M, Look
from taskbuilder.world.pictures import capture

SCENE = """
scene:
  robots:
    arm: {model: ur5e, base: {position: [0, 0, 0]}}
  objects:
    table:
      parts:
        top: {box: [0.4, 0.6, 0.04], at: [0, 0, 0.18]}
        foot: {box: [0.1, 0.1, 0.16], at: [0, 0, 0.08], color: black}
      fixed: true
      position: [0.6, 0, 0]
      color: wood
    shelf: {shape: {box: [0.1, 0.5, 0.4]}, fixed: true, position: [0.9, 0, 0.4], color: blue}
    cube: {shape: {box: [0.05, 0.05, 0.05]}, mass: 0.1, position: [0.6, 0, 0.226], color: red}
  cameras:
    front: {position: [0.6, -1.2, 0.9], look_at: [0.6, 0, 0.2], size: [64, 48]}
    wrist: {mount: arm.tcp, size: [48, 36]}
randomize:
  cube.mass: {uniform: [0.05, 0.2]}
"""


DESCRIPTION = """
from taskbuilder.description import Description, Distance, Near


class Made(Description):
    success = Near("arm.tcp", "cube", within=0.05)
    reward = (Distance("reach", "arm.tcp", "cube"),)
"""


def colors(world, name):
    return world.objects[name].body.colors()


def picture(world, camera="front"):
    return capture(world, world.camera(camera)).rgb.tobytes()


def test_the_seed_decides_the_look(build):
    world = build(SCENE)
    looks, pictures = [], []
    for seed in (1, 2, 1):
        world.reset(seed, looks=LOOK_PARTS)
        looks.append(world.look)
        pictures.append(picture(world))
    assert looks[0] == looks[2] != looks[1]
    assert pictures[0] == pictures[2] != pictures[1]


def test_without_looks_everything_is_as_written_again(build):
    world = build(SCENE)
    world.reset(1)
    table, floor, seen = colors(world, "table"), world.floor.colors(), picture(world)
    world.reset(1, looks=LOOK_PARTS)
    assert colors(world, "table") != table
    assert world.floor.colors() != floor
    world.reset(1)
    assert world.look == AS_WRITTEN
    assert (colors(world, "table"), world.floor.colors()) == (table, floor)
    assert picture(world) == seen


def test_parts_of_furniture_stay_apart_and_what_is_handled_keeps_its_colour(build):
    world = build(SCENE)
    world.reset(1)
    cube, arm = colors(world, "cube"), world.robots["arm"].body.colors()
    for seed in range(5):
        world.reset(seed, looks=LOOK_PARTS)
        top, foot = colors(world, "table").values()
        assert np.abs(np.subtract(top, foot)).max() > 0.1
        assert colors(world, "cube") == cube
        assert world.robots["arm"].body.colors() == arm


@pytest.mark.parametrize(
    "telling",
    [
        "instructions: ['touch the {shelf.color} shelf']\n",
        "variations: [{shelf.color: green}]\n",
    ],
)
def test_a_colour_that_says_something_stays(build, telling):
    world = build(SCENE + telling)
    world.reset(0)
    written = colors(world, "shelf")
    world.reset(3, looks=LOOK_PARTS)
    assert colors(world, "shelf") == written
    assert set(world.look.paints) == {"table"}


def test_cameras_move_a_little_and_those_on_robots_less(build):
    world = build(SCENE)
    world.reset(0)
    written = {name: world.camera(name) for name in world.scene.cameras}
    for seed in range(5):
        world.reset(seed, looks=LOOK_PARTS)
        for name, most in (("front", SHIFT_M), ("wrist", 0.0061)):
            moved = np.subtract(world.camera(name).eye, written[name].eye)
            assert 0.0 < np.linalg.norm(moved) <= most * np.sqrt(3) + 1e-4
            assert world.camera(name).fov_deg != written[name].fov_deg


def test_a_saved_state_keeps_its_look(build):
    world = build(SCENE)
    world.reset(1, looks=LOOK_PARTS)
    state, seen = world.save(), picture(world)
    world.reset(2, looks=LOOK_PARTS)
    assert picture(world) != seen
    world.restore(state)
    assert picture(world) == seen


def test_furniture_and_the_floor_have_textures_in_some_episodes(build):
    world = build(SCENE)
    seen = set()
    for seed in range(12):
        world.reset(seed, looks=LOOK_PARTS)
        seen |= set(world.look.textures)
        seen |= {"floor"} if world.look.floor_texture else set()
    assert seen == {"table", "shelf", "floor"}
    world.reset(0)
    assert not world.client.scenery.textures


@pytest.mark.parametrize(
    ("part", "varies"),
    {
        "light": {"light"},
        "background": {"backdrop", "floor"},
        "furniture": {"paints"},
        "textures": {"textures", "floor_texture"},
        "distractors": {"distractors"},
        "cameras": {"cameras"},
    }.items(),
)
def test_parts_are_drawn_apart_and_as_they_are_drawn_together(build, part, varies):
    world = build(SCENE)
    for seed in range(4):
        world.reset(seed, looks=LOOK_PARTS)
        whole = world.look
        world.reset(seed, looks=(part,))
        for field in fields(Look):
            expected = whole if field.name in varies else AS_WRITTEN
            assert getattr(world.look, field.name) == getattr(expected, field.name), field.name


def test_a_task_lists_what_is_drawn_with_its_quantities(tmp_path):
    read(tmp_path, SCENE + "looks: [light, distractors]\n")
    (tmp_path / "made.py").write_text(DESCRIPTION)
    file = tmp_path / "made.yaml"
    for randomize, drawn in {False: (), True: ("light", "distractors"), "all": LOOK_PARTS}.items():
        env = parallel_env(file, randomize=randomize)
        env.reset(seed=3)
        look = env.episode.world.look
        assert (look.light != AS_WRITTEN.light) == ("light" in drawn)
        assert bool(look.distractors) == ("distractors" in drawn)
        assert bool(look.cameras) == ("cameras" in drawn)
        env.close()


def test_distractors_stand_beside_what_the_episode_is_about(build):
    world = build(SCENE)
    found = []
    for seed in range(10):
        world.reset(seed, looks=LOOK_PARTS)
        cube = world.pose("cube").position
        for thing in world.look.distractors:
            x, y, z = thing.pose.position
            assert math.hypot(x - cube[0], y - cube[1]) > CLEAR_M + HALF_M[0]
            low = z - bottom(thing.shape)
            assert min(abs(low), abs(low - 0.2), abs(low - 0.6)) < 1e-3  # floor, table or shelf
            found.append(low)
    assert len(found) >= 20
    assert any(abs(low - 0.2) < 1e-3 for low in found)
    world.reset(0)
    assert not world.look.distractors


def bottom(shape):
    """How far the lowest point of a shape is below its centre."""
    if isinstance(shape, SphereShape):
        return shape.radius
    return (shape.size[2] if isinstance(shape, BoxShape) else shape.length) / 2.0


def test_distractors_are_seen_and_are_no_bodies(build):
    world = build(SCENE)
    world.reset(2, looks=LOOK_PARTS)
    assert world.look.distractors
    view = world.camera("front")
    with_them = capture(world, view)
    world.client.scenery = replace(world.client.scenery, distractors=())
    world.client.looks += 1
    without = capture(world, view)
    changed = with_them.depth < without.depth - 1e-4
    assert changed.any()
    assert not with_them.mask[changed].any()


def test_looks_change_nothing_in_what_happens():
    plain, varied = (parallel_env("handover", randomize=value) for value in (False, "looks"))
    try:
        for env in (plain, varied):
            env.reset(seed=4)
        generator = np.random.default_rng(0)
        for _ in range(5):
            action = {a: generator.uniform(-1, 1, 5).astype(np.float32) for a in plain.agents}
            one, other = plain.step(action), varied.step(action)
            assert plain.state().tobytes() == varied.state().tobytes()
            assert one[1] == other[1]
    finally:
        plain.close()
        varied.close()


def test_observed_pictures_vary_and_a_copy_sees_the_same():
    from copy import deepcopy

    env = parallel_env("handover", cameras=("front",), camera_size=(32, 24), randomize="looks")
    try:
        first = env.reset(seed=1)[0]["left"]["front.rgb"]
        copied = deepcopy(env)
        np.testing.assert_array_equal(copied.observe()["left"]["front.rgb"], first)
        copied.close()
        second = env.reset(seed=2)[0]["left"]["front.rgb"]
        assert (np.abs(first.astype(int) - second).max(axis=2) > 8).mean() > 0.5
    finally:
        env.close()


def test_quantities_and_looks_are_drawn_apart(build):
    world = build(SCENE)
    world.reset(5, randomized=True)
    alone = world.quantities
    world.reset(5, randomized=True, looks=LOOK_PARTS)
    assert world.quantities == alone
    world.reset(5, looks=LOOK_PARTS)
    assert world.quantities["cube.mass"] == 0.1


def test_an_unknown_kind_is_refused():
    with pytest.raises(UsageError, match=r'randomize "lookz": did you mean "looks"'):
        parallel_env(load_task("handover"), randomize="lookz")
