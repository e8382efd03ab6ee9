"""The matrices, depths and masks of cameras agree with where things are."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from env_tasks import facing, still

from taskbuilder import load_task
from taskbuilder.env.joint import JointEnv
from taskbuilder.sim.renderers import probe_egl

CAMERAS = """
  cameras:
    front: {position: [-0.1, -0.8, 0.9], look_at: [-0.1, 0, 0.4], size: [160, 120]}
    wrist: {mount: left.tcp, fov_deg: 75, size: [160, 120]}
    sky: {position: [0.6, -2.5, 0.7], look_at: [-0.1, 0, 0.9], size: [80, 60], near: 0.2, far: 30}
    away: {position: [0, -1, 1], look_at: [0, -4, 5], size: [24, 16]}
"""
ALL = "self.tcp, " + ", ".join(
    f"{camera}.{quantity}"
    for camera in ("front", "wrist", "sky", "away")
    for quantity in ("depth", "mask", "points")
)
VARIED = "variations:\n  - {post.color: green}\n"
needs_egl = pytest.mark.skipif(not probe_egl().works, reason=f"no EGL: {probe_egl().reason}")
EVERY = ["raster", "tiny", pytest.param("egl", marks=needs_egl)]


def scene(extra: str = "") -> str:
    text = facing(f"left: [{ALL}]", "right: [self.tcp]", extra=extra)
    return text.replace("  sites:", CAMERAS.strip("\n") + "\n  sites:")


def off_surface(points: np.ndarray, pose, half) -> np.ndarray:
    """How far each point is from the surface of a box, in metres."""
    own = np.array([pose.inverse().apply(tuple(point)) for point in points.tolist()])
    off = np.abs(own) - half
    outside = np.linalg.norm(np.maximum(off, 0.0), axis=1)
    return outside + np.abs(np.minimum(off.max(axis=1), 0.0))


@pytest.mark.parametrize("renderer", EVERY)
@pytest.mark.parametrize("randomize", [False, "looks"])
def test_depth_and_matrices_give_the_surfaces_of_known_boxes(make, renderer, randomize):
    env = make(scene(), renderer=renderer, randomize=randomize)
    seen, _ = env.reset(seed=3)
    written = make(scene(), renderer=renderer).cameras()["front"].extrinsics
    push = still(env)
    push["left"][:3] = (0.3, 0.2, 0.6)
    for step in range(3):
        world, views = env.episode.world, seen["left"]
        for name, camera in env.cameras().items():
            depth, mask = views[f"{name}.depth"], views[f"{name}.mask"]
            assert (camera.height, camera.width) == depth.shape
            rows, columns = np.nonzero(depth < camera.far)
            points = camera.points(depth)
            assert len(points) == len(rows)
            labels = [env.mask_names[number] for number in mask[rows, columns]]
            for thing, half in (("block", (0.03, 0.02, 0.02)), ("post", (0.05, 0.015, 0.19))):
                own = points[np.array([label == thing for label in labels], bool)]
                if len(own) < 20:
                    continue
                off = off_surface(own, world.pose(thing), half)
                assert np.quantile(off, 0.95) < 0.001, (name, thing, step)
                assert off.max() < (0.002 if renderer == "raster" else 0.006), (name, thing, step)
        if step == 0:
            front, wrist = env.cameras()["front"], env.cameras()["wrist"]
            assert np.array_equal(front.extrinsics, written) == (not randomize)
        seen, *_ = env.step(push)
    assert np.array_equal(env.cameras()["front"].extrinsics, front.extrinsics)
    assert np.abs(env.cameras()["wrist"].extrinsics - wrist.extrinsics).max() > 0.01


@pytest.mark.parametrize("renderer", EVERY)
def test_a_point_of_the_world_is_in_the_pixel_that_the_matrices_give(make, renderer):
    env = make(scene(), renderer=renderer)
    seen, _ = env.reset(seed=0)
    shown = 0
    for name, camera in env.cameras().items():
        for thing in ("block", "post", "other"):
            point = np.array([*env.episode.world.position(thing), 1.0])
            in_camera = (camera.extrinsics @ point)[:3]
            u, v, w = camera.intrinsics @ in_camera
            column, row = round(u / w), round(v / w)
            if w < 0 or not (0 <= column < camera.width and 0 <= row < camera.height):
                continue
            label = env.mask_names[seen["left"][f"{name}.mask"][row, column]]
            depth = seen["left"][f"{name}.depth"][row, column]
            if label == thing:  # and not something before it
                assert 0.0 < in_camera[2] - depth < 0.2
                shown += 1
            else:
                assert depth < in_camera[2] + 1e-3
    assert shown >= 3


@pytest.mark.parametrize("renderer", EVERY)
def test_the_background_is_at_the_far_plane_and_in_no_point_cloud(make, renderer):
    env = make(scene(), renderer=renderer)
    seen, _ = env.reset(seed=0)
    views, cameras = seen["left"], env.cameras()
    for name, far in (("sky", 30.0), ("away", 10.0)):
        nothing = views[f"{name}.mask"] == 0
        assert nothing.any()
        assert (views[f"{name}.depth"][nothing] == far).all()
        assert (views[f"{name}.depth"][~nothing] < far).all()
        assert cameras[name].far == far
        assert env.observation_space("left")[f"{name}.depth"].high.max() == far
    own = cameras["sky"].points(views["sky.depth"])
    assert len(own) == (views["sky.mask"] > 0).sum()
    cloud = views["sky.points"]
    # Every point of the channel is one of those, and each of those is in it.
    assert {tuple(p) for p in cloud.tolist()} == {tuple(p) for p in own.astype(np.float32).tolist()}
    assert np.abs(cloud).max() < 4.0
    assert len(cameras["away"].points(views["away.depth"])) == 0
    assert np.allclose(views["away.points"], (0, -1, 1))


def test_masks_have_the_names_of_robots_objects_parts_links_and_sites():
    env = JointEnv("open_drawer", cameras=("front",))
    names = env.mask_names
    world = env.parallel.episode.world
    assert names[:2] == ("background", "world.floor")
    assert len(set(names)) == len(names)
    for robot in world.robots:
        assert {f"{robot}.{link}" for link in world.robots[robot].body.links} <= set(names)
    assert {"table.top", "table.left_frame"} <= set(names)
    links = {name for name in names if name.startswith("cabinet.")}
    assert len(links) >= 2
    env.close()


def test_the_names_in_masks_are_the_same_in_every_episode_variation_and_process(make):
    env = make(scene(VARIED), variation="random", renderer="raster")
    names, shown = env.mask_names, set()
    for seed in range(8):
        seen, _ = env.reset(seed=seed)
        assert env.mask_names == names
        mask, points = (seen["left"][f"front.{what}"] for what in ("mask", "points"))
        block = np.array(env.episode.world.position("block"))
        on = points[(mask == names.index("block")).reshape(-1)]
        assert np.abs(on - block).max() < 0.05
        shown.add(env.episode.variation)
    assert shown == {0, 1}
    code = (
        "import sys; from taskbuilder import parallel_env;"
        "print(parallel_env(sys.argv[1]).mask_names)"
    )
    file = str(env.task.file.entry.file)
    told = subprocess.run([sys.executable, "-c", code, file], capture_output=True, check=True)
    assert told.stdout.decode().strip() == str(names)


@pytest.mark.parametrize("name", ["handover", "suction_sort", "open_lid", "gather_cubes"])
def test_every_number_of_a_mask_has_a_name_of_its_own(name):
    task = load_task(name)
    cameras = tuple(task.file.spec.scene.cameras)
    env = JointEnv(task, cameras=cameras, camera_size=(64, 48))
    names = env.mask_names
    assert len(set(names)) == len(names)
    for part in (*task.file.names.objects, *task.agents):
        assert any(each.partition(".")[0] == part for each in names)
    assert set(env.cameras()) == set(cameras)
    assert {(camera.width, camera.height) for camera in env.cameras().values()} == {(64, 48)}
    env.close()
