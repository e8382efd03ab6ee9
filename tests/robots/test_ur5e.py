"""The UR5e against its generator, its published figures, and what a simulator needs of it."""

from __future__ import annotations

import importlib.util
import itertools
import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from types import ModuleType

import numpy as np
import pybullet
import pytest
from loaded_robot import ROBOTS, Array, Load

FOLDER = ROBOTS / "ur5e"
MESHES = sorted((FOLDER / "meshes").glob("*.obj"))
TCP_HEIGHT = 0.144
# The published Denavit-Hartenberg table: (d, a, alpha) for every joint.
DH = (
    (0.1625, 0.0, math.pi / 2),
    (0.0, -0.425, 0.0),
    (0.0, -0.3922, 0.0),
    (0.1333, 0.0, math.pi / 2),
    (0.0997, 0.0, -math.pi / 2),
    (0.0996, 0.0, 0.0),
)


@pytest.fixture(scope="module")
def generator() -> ModuleType:
    spec = importlib.util.spec_from_file_location("ur5e_generate", FOLDER / "generate.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def flange_by_dh(joint_positions: Array) -> Array:
    """The flange's pose (4, 4) in base_link by the DH table."""
    pose = np.diag([-1.0, -1.0, 1.0, 1.0])  # the table's base is base_link turned about z
    for theta, (d, a, alpha) in zip(joint_positions, DH, strict=True):
        ct, st, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
        pose = pose @ np.array(
            [
                [ct, -st * ca, st * sa, a * ct],
                [st, ct * ca, -ct * sa, a * st],
                [0.0, sa, ca, d],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
    return pose


def inertia_tensors() -> dict[str, tuple[float, Array]]:
    """Mass and inertia (3, 3) of every link of the URDF."""
    found = {}
    for link in ET.parse(FOLDER / "ur5e.urdf").getroot().iter("link"):
        inertial = link.find("inertial")
        assert inertial is not None, f"{link.get('name')} would weigh 1 kg"
        mass, inertia = inertial.find("mass"), inertial.find("inertia")
        assert mass is not None
        assert inertia is not None
        xx, xy, xz, yy, yz, zz = (
            float(inertia.get(key, "nan")) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        )
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        found[link.get("name", "")] = (float(mass.get("value", "nan")), tensor)
    return found


def test_generator_reproduces_the_committed_files(generator: ModuleType) -> None:
    files: dict[str, str] = generator.generated_files()
    committed = {f"meshes/{path.name}" for path in MESHES} | {"ur5e.urdf"}
    assert set(files) == committed
    for name, text in files.items():
        assert (FOLDER / name).read_bytes() == text.encode(), f"run robots/ur5e/generate.py: {name}"


def test_arm_is_low_poly() -> None:
    triangles = sum(len(re.findall(r"^f ", path.read_text(), re.MULTILINE)) for path in MESHES)
    assert 3000 <= triangles <= 8000


@pytest.mark.parametrize("path", MESHES, ids=lambda path: path.stem)
def test_mesh_is_well_formed(path: Path) -> None:
    rows = [line.split() for line in path.read_text().splitlines()]
    vertices = np.array([row[1:] for row in rows if row[0] == "v"], dtype=float)
    normals = np.array([row[1:] for row in rows if row[0] == "vn"], dtype=float)
    corners = np.array(
        [[corner.split("//") for corner in row[1:]] for row in rows if row[0] == "f"], dtype=int
    )
    # A face index out of range ends the interpreter inside PyBullet.
    assert corners.min() >= 1
    assert corners[..., 0].max() <= len(vertices)
    assert corners[..., 1].max() <= len(normals)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=2e-3)
    assert np.abs(vertices).max() < 0.7
    # The normals stand on the side that the triangle's winding says is outside.
    a, b, c = (vertices[corners[:, i, 0] - 1] for i in range(3))
    face = np.cross(b - a, c - a)
    for i in range(3):
        agree = (face * normals[corners[:, i, 1] - 1]).sum(axis=1)
        assert (agree > 0).all()


def test_urdf_names_the_meshes_beside_it() -> None:
    root = ET.parse(FOLDER / "ur5e.urdf").getroot()
    named = {mesh.get("filename", "") for mesh in root.iter("mesh")}
    assert named == {f"meshes/{path.name}" for path in MESHES}
    # What collides is made of primitives: fast, and without a hull that fills hollows.
    shapes = {
        geometry[0].tag for link in root.iter("collision") for geometry in link.iter("geometry")
    }
    assert shapes <= {"box", "capsule", "cylinder", "sphere"}


def test_kinematics_equal_the_published_table(load: Load) -> None:
    robot = load("ur5e")
    rng = np.random.default_rng(5)
    for joint_positions in [np.zeros(6), *rng.uniform(-math.pi, math.pi, (25, 6))]:
        robot.move_arm(joint_positions.tolist())
        flange = flange_by_dh(joint_positions)
        position, rotation = robot.link_pose("wrist_3_link")
        np.testing.assert_allclose(position, flange[:3, 3], atol=1e-6)
        np.testing.assert_allclose(rotation, flange[:3, :3], atol=1e-5)
        tcp, tcp_rotation = robot.tcp_pose()
        np.testing.assert_allclose(tcp, position + TCP_HEIGHT * rotation[:, 2], atol=1e-6)
        np.testing.assert_allclose(tcp_rotation[:, 2], rotation[:, 2], atol=1e-5)


def test_zero_is_stretched_out_forward(load: Load) -> None:
    robot = load("ur5e")
    robot.move_arm([0.0] * 6)
    position, _ = robot.link_pose("wrist_1_link")
    np.testing.assert_allclose(position, [0.8172, 0.1333, 0.1625], atol=1e-6)
    robot.move_arm([0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
    assert robot.link_pose("wrist_1_link")[0][2] < position[2]


def test_limits_are_the_published_ones(load: Load) -> None:
    robot = load("ur5e")
    for name, effort in zip(robot.spec["arm"], (150, 150, 150, 28, 28, 28), strict=True):
        info = pybullet.getJointInfo(robot.body, robot.joints[name], physicsClientId=robot.client)
        reach = math.pi if name == "elbow_joint" else 2 * math.pi
        assert info[8:12] == pytest.approx((-reach, reach, effort, math.pi))


def test_masses_are_the_published_ones() -> None:
    masses = {name: mass for name, (mass, _) in inertia_tensors().items()}
    published = {
        "base_link": 4.0,
        "shoulder_link": 3.761,
        "upper_arm_link": 8.058,
        "forearm_link": 2.846,
        "wrist_1_link": 1.37,
        "wrist_2_link": 1.3,
        "wrist_3_link": 0.365,
    }
    assert published.items() <= masses.items()


@pytest.mark.parametrize("link", sorted(inertia_tensors()))
def test_inertia_is_physical(link: str) -> None:
    mass, tensor = inertia_tensors()[link]
    low, middle, high = np.linalg.eigvalsh(tensor)
    assert mass > 0
    assert low > 0
    assert high <= (low + middle) * (1 + 1e-9)


def test_pybullet_takes_the_inertia_as_written(load: Load) -> None:
    robot = load("ur5e")
    for name, (mass, tensor) in inertia_tensors().items():
        if name == "base_link":
            continue  # fixed to the world, where it weighs nothing
        info = pybullet.getDynamicsInfo(robot.body, robot.links[name], physicsClientId=robot.client)
        assert info[0] == pytest.approx(mass)
        np.testing.assert_allclose(sorted(info[2]), np.linalg.eigvalsh(tensor), rtol=2e-2)


def test_every_part_has_its_own_colour(load: Load) -> None:
    robot = load("ur5e")
    shapes = pybullet.getVisualShapeData(robot.body, physicsClientId=robot.client)
    assert len(shapes) == len(MESHES)
    for shape in shapes:
        color = Path(shape[4].decode()).stem.rsplit("_", 1)[1]
        red, _, blue, alpha = shape[7]
        assert alpha == 1.0
        assert (blue - red > 0.2) == (color == "cap"), shape[4]


def test_only_neighbours_touch_at_home(load: Load) -> None:
    robot = load("ur5e")
    pybullet.performCollisionDetection(physicsClientId=robot.client)
    count = pybullet.getNumJoints(robot.body, physicsClientId=robot.client)
    parent = {
        i: pybullet.getJointInfo(robot.body, i, physicsClientId=robot.client)[16]
        for i in range(count)
    }
    for one, other in itertools.combinations(range(-1, count), 2):
        if parent.get(other) == one:
            continue
        near = pybullet.getClosestPoints(
            robot.body, robot.body, 0.0, one, other, physicsClientId=robot.client
        )
        assert not near, (one, other)


def test_grasp_holds_still(load: Load) -> None:
    """Fingers tied by a gear hold a stick for a second, neither drifting nor creeping."""
    robot = load("ur5e")
    client = robot.client
    fingers = [robot.joints[name] for name in robot.spec["gripper"]["joints"]]
    gear = pybullet.createConstraint(
        robot.body,
        fingers[0],
        robot.body,
        fingers[1],
        pybullet.JOINT_GEAR,
        [0, 1, 0],
        [0, 0, 0],
        [0, 0, 0],
        physicsClientId=client,
    )
    pybullet.changeConstraint(gear, gearRatio=-1, maxForce=100, erp=0.2, physicsClientId=client)
    pybullet.setTimeStep(1 / 120, physicsClientId=client)
    home = np.radians(robot.spec["home_deg"]).tolist()
    pybullet.setJointMotorControlArray(
        robot.body,
        robot.arm,
        pybullet.POSITION_CONTROL,
        home,
        positionGains=[0.5] * 6,
        forces=[150.0] * 3 + [28.0] * 3,
        physicsClientId=client,
    )
    pybullet.setJointMotorControlArray(
        robot.body,
        fingers,
        pybullet.POSITION_CONTROL,
        [0.0, 0.0],
        forces=[robot.spec["gripper"]["force"]] * 2,
        physicsClientId=client,
    )
    position, _ = robot.tcp_pose()
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=[0.14, 0.015, 0.015], physicsClientId=client
    )
    stick = pybullet.createMultiBody(0.08, shape, -1, position, physicsClientId=client)
    for _ in range(60):  # weightless until it is held
        pybullet.stepSimulation(physicsClientId=client)
    pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
    for _ in range(60):
        pybullet.stepSimulation(physicsClientId=client)
    before, _ = pybullet.getBasePositionAndOrientation(stick, physicsClientId=client)
    for _ in range(120):
        pybullet.stepSimulation(physicsClientId=client)
    after, turn = pybullet.getBasePositionAndOrientation(stick, physicsClientId=client)
    np.testing.assert_allclose(after, before, atol=2e-4)
    assert 2 * math.acos(min(1.0, abs(turn[3]))) < math.radians(1.0)
    contacts = pybullet.getContactPoints(robot.body, stick, physicsClientId=client)
    for name in ("left_finger", "right_finger"):
        force = sum(contact[9] for contact in contacts if contact[3] == robot.links[name])
        assert force == pytest.approx(robot.spec["gripper"]["force"], rel=0.1)
