"""A hollow mesh that moves collides as if it had a lid, and that is said."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from written_tasks import read

from taskbuilder.assets.mesh import read_mesh
from taskbuilder.world.hollows import filled_hollows, share_inside

TASK = """
scene:
  robots: {arm: {model: ur5e, base: {position: [-0.5, 0, 0]}}}
  objects:
    mug: {shape: {mesh: mug.obj}, mass: 0.2, position: [0, 0, 0.05]}
"""


def revolved(profile: list[tuple[float, float]], sections: int = 24) -> str:
    """An OBJ of a profile (radius, height) that is turned about z."""
    lines = [
        f"v {r * math.cos(a):.6f} {r * math.sin(a):.6f} {z:.6f}"
        for r, z in profile
        for a in (2 * math.pi * k / sections for k in range(sections))
    ]
    for row in range(len(profile) - 1):
        for k in range(sections):
            a, b = row * sections + k + 1, row * sections + (k + 1) % sections + 1
            lines.append(f"f {a} {b} {b + sections} {a + sections}")
    return "\n".join(lines) + "\n"


MUG = [(1e-4, -0.05), (0.04, -0.05), (0.04, 0.05), (0.036, 0.05), (0.036, -0.045), (1e-4, -0.045)]
CAN = [(1e-4, -0.05), (0.04, -0.05), (0.04, 0.05), (1e-4, 0.05)]
BOTTLE = [(1e-4, -0.1), (0.03, -0.1), (0.03, 0.02), (0.012, 0.05), (0.012, 0.1), (1e-4, 0.1)]


@pytest.mark.parametrize(("profile", "hollow"), [(MUG, True), (CAN, False), (BOTTLE, False)])
def test_what_is_hollow_is_told_from_what_is_not(profile, hollow, tmp_path):
    (tmp_path / "thing.obj").write_text(revolved(profile))
    share = share_inside(read_mesh(tmp_path / "thing.obj"))
    assert (share > 0.4) if hollow else (share < 0.1)


def test_the_finding_says_what_to_do_and_ends_where_it_is_done(tmp_path: Path):
    (tmp_path / "mug.obj").write_text(revolved(MUG))
    (finding,) = filled_hollows(read(tmp_path, TASK))
    assert (finding.code, finding.severity) == ("TB425", "warning")
    assert finding.path == "scene.objects.mug.shape"
    assert finding.location.line > 1
    assert "taskbuilder objects import mug.obj" in finding.message
    assert "taskbuilder[import]" in finding.message
    for meant in ("collide: hull", "collide: pieces"):
        assert not filled_hollows(read(tmp_path, TASK.replace("mug.obj}", f"mug.obj, {meant}}}")))
    fixed = TASK.replace("mass: 0.2", "fixed: true")
    assert not filled_hollows(read(tmp_path, fixed))
