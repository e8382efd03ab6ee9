"""The robots that robots/generate.py writes."""

from __future__ import annotations

import math
import runpy
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

ROBOTS = Path(__file__).resolve().parents[2] / "robots"
ELSEWHERE = {"panda", "ur5e", "xarm6"}
NAMES = sorted({path.parent.name for path in ROBOTS.glob("*/robot.yaml")} - ELSEWHERE)


def test_generator_reproduces_the_committed_files():
    files = runpy.run_path(str(ROBOTS / "generate.py"))["generated_files"]()
    assert {name for name in files if name.endswith(".urdf")} == {f"{n}/{n}.urdf" for n in NAMES}
    for name, text in files.items():
        assert (ROBOTS / name).read_bytes() == text.encode(), f"run robots/generate.py: {name}"
    meshes = {str(path.relative_to(ROBOTS)) for path in ROBOTS.glob("*/meshes/*.obj")}
    assert {name for name in meshes if not name.startswith("ur5e/")} == set(files) - {
        f"{name}/{name}.urdf" for name in NAMES
    }


@pytest.mark.parametrize("name", NAMES)
def test_masses_and_inertias_are_physical(name):
    for link in ET.parse(ROBOTS / name / f"{name}.urdf").getroot().iter("link"):
        mass = float(link.find("inertial/mass").get("value"))
        given = link.find("inertial/inertia")
        xx, xy, xz, yy, yz, zz = (
            float(given.get(key)) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        )
        low, middle, high = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert mass > 0.0
        assert low > 0.0
        assert high <= (low + middle) * (1 + 1e-6)


def test_a_link_of_solids_weighs_what_they_weigh():
    root = ET.parse(ROBOTS / "ur5e_pusher" / "ur5e_pusher.urdf").getroot()
    paddle = next(link for link in root.iter("link") if link.get("name") == "paddle")
    assert float(paddle.find("inertial/mass").get("value")) == pytest.approx(0.2)
    # Two even boxes, 25 mm apart along z: about y, by the parallel axis theorem.
    blade = 0.18 * (0.014**2 + 0.066**2) / 12
    strip = 0.02 * (0.018**2 + 0.012**2) / 12
    apart = 0.18 * 0.02 / 0.2 * 0.025**2
    iyy = float(paddle.find("inertial/inertia").get("iyy"))
    assert math.isclose(iyy, blade + strip + apart, rel_tol=1e-6)
