"""The arms of other makers: their published kinematics, and what they can do."""

from __future__ import annotations

import math
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from loaded_robot import Array, Load

from taskbuilder import load_task, parallel_env
from taskbuilder.expert.script.player import Expert

sys.path.append(str(Path(__file__).resolve().parents[2] / "benchmarks"))

from reach_tasks import KINDS, REACHES, write_task

QUARTER = math.pi / 2
# Published Denavit-Hartenberg tables, (d, a, alpha) for every joint, and how the flange is told.
TABLES = {
    "ur10e": (
        [
            (0.1807, 0.0, QUARTER),
            (0.0, -0.6127, 0.0),
            (0.0, -0.57155, 0.0),
            (0.17415, 0.0, QUARTER),
            (0.11985, 0.0, -QUARTER),
            (0.11655, 0.0, 0.0),
        ],
        "robotiq_base",
        math.pi,  # by which the table's base is turned against ours
    ),
    "iiwa14": (
        [
            (0.36, 0.0, -QUARTER),
            (0.0, 0.0, QUARTER),
            (0.42, 0.0, QUARTER),
            (0.0, 0.0, -QUARTER),
            (0.4, 0.0, -QUARTER),
            (0.0, 0.0, QUARTER),
            (0.126, 0.0, 0.0),
        ],
        "robotiq_base",
        0.0,
    ),
    "xarm7": (
        [
            (0.267, 0.0, -QUARTER),
            (0.0, 0.0, QUARTER),
            (0.293, 0.0525, QUARTER),
            (0.0, 0.0775, QUARTER),
            (0.3425, 0.0, QUARTER),
            (0.0, 0.076, -QUARTER),
            (0.097, 0.0, 0.0),
        ],
        "xarm_gripper_base_link",
        0.0,
    ),
}


def flange_by_table(name: str, joint_positions: Array) -> Array:
    """The position of the flange in the base by the published table."""
    table, _, yaw = TABLES[name]
    pose = np.diag([math.cos(yaw), math.cos(yaw), 1.0, 1.0])
    for theta, (d, a, alpha) in zip(joint_positions, table, strict=True):
        ct, st, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
        pose = pose @ np.array(
            [
                [ct, -st * ca, st * sa, a * ct],
                [st, ct * ca, -ct * sa, a * st],
                [0.0, sa, ca, d],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
    return np.asarray(pose[:3, 3])


@pytest.mark.parametrize("name", TABLES)
def test_kinematics_equal_the_published_table(load: Load, name: str) -> None:
    robot = load(name)
    rng = np.random.default_rng(5)
    for joint_positions in [
        np.zeros(len(robot.arm)),
        *rng.uniform(-2.0, 2.0, (10, len(robot.arm))),
    ]:
        robot.move_arm(joint_positions.tolist())
        position, _ = robot.link_pose(TABLES[name][1])
        np.testing.assert_allclose(position, flange_by_table(name, joint_positions), atol=1e-6)


def test_the_2f85_is_the_same_on_all_arms(load: Load) -> None:
    grippers = []
    for name in ("gen3", "iiwa14", "ur10e"):
        robot = load(name)
        robot.move_gripper("closed")
        base, turn = robot.link_pose("robotiq_base")
        tips = [
            turn.T @ (robot.link_pose(link)[0] - base)
            for (link,) in robot.spec["gripper"]["fingers"]
        ]
        grippers.append((robot.spec["gripper"], np.array(tips)))
    for spec, tips in grippers[1:]:
        assert spec == grippers[0][0]
        np.testing.assert_allclose(tips, grippers[0][1], atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", REACHES)
def test_does_within_its_own_reach(tmp_path: Path, name: str, kind: str) -> None:
    """All of 20 seeds are in benchmarks/results/swaps.csv."""
    task = load_task(write_task(tmp_path, kind, name, REACHES[name]))
    with closing(parallel_env(task)) as env, closing(Expert(env)) as expert:
        done = expert.play(1)
    assert done.success, done.trouble
