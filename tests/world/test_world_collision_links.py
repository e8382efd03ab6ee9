"""The collision shapes that are drawn are those in which the physics engine's rays end."""

from __future__ import annotations

import re
from contextlib import closing

import numpy as np
import pytest

from taskbuilder.task import load_task
from taskbuilder.world.building import build_world
from taskbuilder.world.visible import LinkPoses, collision_links, visible_links

RAYS = 120
"""Aimed at each link."""

LEAST = 10
"""Of these, as many must end on a link, or else others hide it."""

NEAR_M = 2e-3
"""All are drawn a millimetre larger, and circles with 32 corners."""

GRAZING = 0.2
"""Share of rays that pass so near to an edge that only one of both is met."""

MESH = """\
task: shapes
summary: Meshes that collide in every way.
scene:
  robots:
    arm: {model: panda, base: {position: [0, 1, 0]}}
  objects:
    whole: {shape: {mesh: cup.obj}, fixed: true, position: [0, 0, 0.1], rpy_deg: [10, 20, 30]}
    filled: {shape: {mesh: cup.obj, collide: hull}, mass: 0.1, position: [0.3, 0, 0.1]}
    cut: {shape: {mesh: cup.obj, collision: cup_pieces.obj}, mass: 0.1, position: [0.6, 0, 0.1]}
    boxed:
      shape: {mesh: cup.obj, collision: some_pieces.obj, collide: boxes}
      mass: 0.1
      position: [0.9, 0, 0.1]
  cameras:
    front: {position: [1.2, 0, 0.8], look_at: [0.4, 0, 0.2], size: [64, 48]}
timing: {episode_steps: 3}
"""


def ends_on(world, name, starts, ends):
    """Which rays the engine says end on a link, how far along these, and the normal there.

    (n,), (k,) and (k, 3).
    """
    found = world.client.bullet.rayTestBatch(starts.tolist(), ends.tolist())
    bodies = np.array([hit[0] for hit in found], np.int32)
    links = np.array([hit[1] for hit in found], np.int32)
    own = world.segments.of(bodies, links) == world.segments.names.index(name)
    hits = [hit for hit, is_own in zip(found, own, strict=True) if is_own]
    return own, np.array([hit[2] for hit in hits]), np.array([hit[4] for hit in hits])


def drawn_ends(corners, starts, ends):
    """(n,) how far along each ray it meets the first of (t, 3, 3) triangles; 1 where it does not.

    The intersection of rays with triangles is that of Möller and Trumbore (1997).
    """
    a, b, c = (corners[:, k] for k in range(3))
    nearest = np.ones(len(starts))
    for row, (start, end) in enumerate(zip(starts, ends, strict=True)):
        way = end - start
        across = np.cross(way, c - a)
        scale = np.einsum("ij,ij->i", b - a, across)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.einsum("ij,ij->i", start - a, across) / scale
            over = np.cross(start - a, b - a)
            v = over @ way / scale
            along = np.einsum("ij,ij->i", c - a, over) / scale
        met = (u >= 0) & (v >= 0) & (u + v <= 1) & (along > 0) & (along < 1)
        nearest[row] = np.where(met, along, 1.0).min(initial=1.0)
    return nearest


def placed(link, poses):
    """(t, 3, 3) corners of a link's triangles in the world."""
    x, y, z, w, *axis = poses[link.row].astype(float)
    found = []
    for mesh in link.meshes:
        points = mesh.vertices.astype(float)
        turn = np.cross(axis, points)
        points = points + 2.0 * (np.cross(axis, turn) + w * turn) + (x, y, z)
        found.append(points[mesh.triangles])
    return np.concatenate(found)


def agree(world):
    """Compare rays at every link of a world as it stands."""
    poses, rng = LinkPoses(world).now(), np.random.default_rng(0)
    hidden: list[str] = []
    for link in collision_links(world):
        corners = placed(link, poses)
        aims = rng.uniform(corners.min(axis=(0, 1)), corners.max(axis=(0, 1)), (RAYS, 3))
        way = rng.normal(size=(RAYS, 3))
        starts = aims + 3.0 * way / np.linalg.norm(way, axis=1, keepdims=True)
        ends = aims + 0.5 * (aims - starts)
        own, engine, normals = ends_on(world, link.name, starts, ends)
        if len(engine) < LEAST:
            hidden.append(link.name)
            continue
        drawn = drawn_ends(corners, starts[own], ends[own])
        ways = ends[own] - starts[own]
        off = np.abs(engine - drawn) * np.abs(np.einsum("ij,ij->i", ways, normals))
        assert np.quantile(off, 1.0 - GRAZING) <= NEAR_M, link.name
    assert len(hidden) <= len(collision_links(world)) // 10, hidden


@pytest.mark.parametrize("name", ["handover", "cup_handover", "open_jar"])
def test_rays_end_on_the_shapes_that_are_drawn(name):
    with closing(build_world(load_task(name).file)) as world:
        world.reset(0)
        for robot in world.robots.values():
            robot.pose_arm([angle + 0.1 for angle in robot.home])
        agree(world)


def test_meshes_collide_as_whole_filled_cut_or_boxed(tmp_path):
    cups = load_task("cup_handover").file.entry.root.parent / "objects" / "cup"
    for mesh in ("cup.obj", "cup_pieces.obj"):
        (tmp_path / mesh).write_bytes((cups / mesh).read_bytes())
    text, *groups = re.split(r"(?m)^(?=[go] )", (cups / "cup_pieces.obj").read_text())
    (tmp_path / "some_pieces.obj").write_text(text + "".join(groups[:16]))
    file = tmp_path / "shapes.yaml"
    file.write_text(MESH)
    file.with_suffix(".py").write_text(
        "from taskbuilder.description import Bonus, Description, Near\n\n\n"
        "class Shapes(Description):\n"
        '    success = Near("arm.tcp", "cut", within=0.03)\n'
        '    reward = (Bonus("there", success, 1.0),)\n'
    )
    with closing(build_world(load_task(str(file)).file)) as world:
        world.reset(0)
        agree(world)
        sizes = {
            link.name: sum(len(m.triangles) for m in link.meshes) for link in collision_links(world)
        }
    assert sizes["filled"] < sizes["whole"]
    assert sizes["boxed"] == 16 * 12


def test_the_shapes_move_with_the_links_that_are_seen():
    with closing(build_world(load_task("handover").file)) as world:
        world.reset(0)
        seen = {link.name: link.row for link in visible_links(world)}
        solid = {link.name: link.row for link in collision_links(world)}
    assert {name: seen[name] for name in solid} == solid
    assert "left.ee_link" not in solid or solid["left.ee_link"] == seen["left.ee_link"]
    assert "world.floor" not in solid
