"""A client and a few scenes on real physics."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pybullet_data
import pytest

from taskbuilder.geometry import Pose, Vec3
from taskbuilder.shapes import BoxShape, CylinderShape, Part
from taskbuilder.sim.bodies import create_body, load_urdf
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.motors import Motors

TRAY = {
    "floor": Part(BoxShape((0.30, 0.20, 0.01))),
    "wall": Part(BoxShape((0.30, 0.01, 0.05)), Pose((0.0, 0.095, 0.02))),
    "left_handle": Part(BoxShape((0.02, 0.06, 0.10)), Pose((-0.16, 0.0, 0.05))),
    "right_handle": Part(CylinderShape(0.01, 0.10), Pose((0.16, 0.0, 0.05))),
}


@pytest.fixture
def client() -> Iterator[Client]:
    with Client(physics_hz=120) as opened:
        yield opened


@pytest.fixture(scope="session")
def assets() -> Path:
    return Path(pybullet_data.getDataPath())


@pytest.fixture
def table(client: Client) -> Body:
    """A static box whose top is at z = 0."""
    return create_body(
        client, {"table": Part(BoxShape((2.0, 2.0, 0.1)))}, pose=Pose((0.0, 0.0, -0.05))
    )


@pytest.fixture
def tray(client: Client) -> Body:
    """A tray of 0.4 kg with a wall on one side and two different handles."""
    return create_body(client, TRAY, name="tray", mass=0.4)


@pytest.fixture
def panda(client: Client, assets: Path) -> Body:
    """A Franka Panda on a fixed base: 7 joints and 2 fingers."""
    return load_urdf(client, assets / "franka_panda/panda.urdf", name="panda", fixed_base=True)


@pytest.fixture
def panda_arm(panda: Body) -> Motors:
    return Motors(panda, range(7), forces=[80.0] * 7, velocities=[1.5] * 7)


@pytest.fixture
def make_cube(client: Client) -> Callable[..., Body]:
    """Makes cubes of 50 g at positions."""

    def make(position: Vec3, edge: float = 0.04) -> Body:
        parts = {"cube": Part(BoxShape((edge, edge, edge)))}
        return create_body(client, parts, mass=0.05, pose=Pose(position))

    return make
