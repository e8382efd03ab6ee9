"""A robot of the library in a PyBullet client of its own, straight from its robot.yaml."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pybullet
import pybullet_data
import yaml
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROBOTS = Path(__file__).resolve().parents[2] / "robots"
PACKAGE = "package://pybullet_data/"


@dataclass(frozen=True)
class LoadedRobot:
    """One robot, its base at the origin, loaded by PyBullet without any of this project's code."""

    client: int
    body: int
    spec: dict[str, Any]
    joints: dict[str, int]
    links: dict[str, int]

    @property
    def arm(self) -> list[int]:
        return [self.joints[name] for name in self.spec["arm"]]

    @property
    def gripper_joints(self) -> set[str]:
        return set(self.spec.get("gripper", {"joints": {}})["joints"])

    @property
    def home(self) -> list[float]:
        """Joint positions of home, in rad or m."""
        return [
            value if self.info(joint)[2] == pybullet.JOINT_PRISMATIC else float(np.radians(value))
            for joint, value in zip(self.arm, self.spec["home_deg"], strict=True)
        ]

    def info(self, joint: int) -> tuple[Any, ...]:
        """What PyBullet tells of a joint."""
        return tuple(pybullet.getJointInfo(self.body, joint, physicsClientId=self.client))

    def go_home(self) -> None:
        """Put the arm to home, and open the gripper."""
        self.move_arm(self.home)
        if self.gripper_joints:
            self.move_gripper("open")

    def move_arm(self, joint_positions: Sequence[float]) -> None:
        for joint, position in zip(self.arm, joint_positions, strict=True):
            pybullet.resetJointState(self.body, joint, position, physicsClientId=self.client)

    def move_gripper(self, key: str) -> None:
        self.open_gripper({"open": 1.0, "closed": 0.0}[key])

    def open_gripper(self, share: float) -> None:
        for name, ends in self.spec["gripper"]["joints"].items():
            at = ends["closed"] + share * (ends["open"] - ends["closed"])
            pybullet.resetJointState(self.body, self.joints[name], at, physicsClientId=self.client)

    def link_pose(self, name: str) -> tuple[Array, Array]:
        """Position (3,) and rotation (3, 3) of a link's own frame in the base."""
        state = pybullet.getLinkState(
            self.body,
            self.links[name],
            computeForwardKinematics=True,
            physicsClientId=self.client,
        )
        rotation = np.array(pybullet.getMatrixFromQuaternion(state[5])).reshape(3, 3)
        return np.array(state[4]), rotation

    def tcp_pose(self) -> tuple[Array, Array]:
        """Position (3,) and rotation (3, 3) of the tcp in the base."""
        position, rotation = self.link_pose(self.spec["tcp"]["link"])
        offset = np.array(self.spec["tcp"].get("position", [0.0, 0.0, 0.0]))
        turn = pybullet.getQuaternionFromEuler(
            np.radians(self.spec["tcp"].get("rpy_deg", [0.0, 0.0, 0.0])).tolist()
        )
        turn_matrix = np.array(pybullet.getMatrixFromQuaternion(turn)).reshape(3, 3)
        return position + rotation @ offset, rotation @ turn_matrix

    def finger_centers(self) -> list[Array]:
        """The middle of each finger's bounding box in the tcp frame."""
        position, rotation = self.tcp_pose()
        centers = []
        # A box around a turned link lags behind a reset until collisions are looked at again.
        pybullet.performCollisionDetection(physicsClientId=self.client)
        for links in self.spec["gripper"]["fingers"]:
            boxes = [
                pybullet.getAABB(self.body, self.links[link], physicsClientId=self.client)
                for link in links
            ]
            low = np.min([box[0] for box in boxes], axis=0)
            high = np.max([box[1] for box in boxes], axis=0)
            centers.append(rotation.T @ ((low + high) / 2 - position))
        return centers

    def gap(self) -> float:
        """What is left between the two fingers, in m."""
        one, other = (self.links[links[0]] for links in self.spec["gripper"]["fingers"])
        near = pybullet.getClosestPoints(
            self.body, self.body, 1.0, one, other, physicsClientId=self.client
        )
        return float(min(point[8] for point in near))

    def open_along_y(self) -> float:
        """What is open between the fingers on the line along y through the tcp, in m."""
        pybullet.performCollisionDetection(physicsClientId=self.client)
        position, rotation = self.tcp_pose()
        away = [0.2 * side * rotation[:, 1] for side in (1.0, -1.0)]
        hits = [
            pybullet.rayTest(position, position + way, physicsClientId=self.client)[0]
            for way in away
        ]
        assert {hit[1] for hit in hits} == {
            self.links[links[0]] for links in self.spec["gripper"]["fingers"]
        }
        return float(sum(0.2 * hit[2] for hit in hits))


def load_robot(name: str) -> LoadedRobot:
    """A robot of the library by name, at home with its gripper open, in a new client."""
    folder = ROBOTS / name
    spec = yaml.safe_load((folder / "robot.yaml").read_text(encoding="utf-8"))
    urdf = spec["urdf"]
    if urdf.startswith(PACKAGE):
        path = Path(pybullet_data.getDataPath()) / urdf.removeprefix(PACKAGE)
    else:
        path = folder / urdf
    client = pybullet.connect(pybullet.DIRECT)
    body = pybullet.loadURDF(
        str(path),
        useFixedBase=True,
        flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
        physicsClientId=client,
    )
    count = pybullet.getNumJoints(body, physicsClientId=client)
    infos = [pybullet.getJointInfo(body, i, physicsClientId=client) for i in range(count)]
    robot = LoadedRobot(
        client,
        body,
        spec,
        {info[1].decode(): info[0] for info in infos},
        {info[12].decode(): info[0] for info in infos},
    )
    robot.go_home()
    return robot


Load = Callable[[str], LoadedRobot]
