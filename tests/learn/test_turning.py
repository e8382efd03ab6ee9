"""Turned demonstrations are what a robot sees and does in a scene that stands otherwise."""

from __future__ import annotations

import math
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from taskbuilder import parallel_env
from taskbuilder.errors import UsageError
from taskbuilder.learn.turning import turns_of

torch = pytest.importorskip("torch")

from taskbuilder.learn.algorithms.bc import ALGORITHM, BcSettings  # noqa: E402  # needs PyTorch
from taskbuilder.learn.chunk_data import ChunkData  # noqa: E402  # needs PyTorch
from taskbuilder.learn.recordings import Demonstrations  # noqa: E402  # beside those it goes into

SCENE = """
task: turned
summary: A robot is beside a cube.
scene:
  robots:
    arm:
      model: ur5e
      base: {position: [-0.1, 0.2, 0.4], rpy_deg: [0, 0, YAW]}
      home: {tcp: {position: [0.4, 0.1, 0.7], rpy_deg: [180, 10, 30]}}
      action: {turn: full}
  objects:
    table: {shape: {box: [2, 2, 0.04]}, position: [0, 0, 0.38], fixed: true}
    cube:
      shape: {box: [0.05, 0.05, 0.05]}
      mass: 0.1
      position: [0.3, -0.3, 0.425]
      rpy_deg: [0, 0, 20]
  sites:
    goal: {position: [0.5, 0.3, 0.6]}
observe: {arm: [self.tcp, self.tcp_velocity, cube.pose, goal.position in self.tcp, time_left]}
"""
DESCRIPTION = """
from taskbuilder.description import Bonus, Description, Near


class Turned(Description):
    success = Near("cube", "goal", within=0.05)
    reward = (Bonus("there", success, 1.0),)
"""


@pytest.fixture
def seen(tmp_path):
    """What the robot observes from a base that is turned by an angle, and the names of it."""

    def observe(yaw_deg, **options):
        (tmp_path / "turned.yaml").write_text(SCENE.replace("YAW", str(yaw_deg)))
        (tmp_path / "turned.py").write_text(DESCRIPTION)
        chosen = {"frame": "base", "rotation": "matrix", **options}
        with closing(parallel_env(tmp_path / "turned.yaml", **chosen)) as env:
            observations, _ = env.reset(seed=0)
            return observations["arm"], env.observation_names["arm"], env.action_names["arm"]

    return observe


def demonstrations(observed, acted, turns):
    own = np.ones(observed.shape[1], dtype=bool)
    rows = np.full(len(observed), len(observed))
    return Demonstrations({"arm": observed}, {"arm": acted}, rows, {"arm": own}, {}, {"arm": turns})


def test_a_turned_observation_is_that_of_a_turned_base(seen):
    straight, names, actions = seen(0)
    turned, *_ = seen(-25)
    turns = turns_of("arm", names, actions)
    acted = np.array([[0.3, -0.2, 0.1, 0.4, 0.5, -0.6, 1.0]], np.float32)
    data = ChunkData(demonstrations(straight[None], acted, turns), torch.device("cpu"))
    angles = {"arm": torch.tensor([math.radians(25)])}
    rows = torch.tensor([0])
    shown = data.observations(rows, 0.0, np.random.default_rng(0), angles)["arm"].numpy()[0]
    mean, scale = data.statistics(0)
    assert shown * scale["arm"] + mean["arm"] == pytest.approx(turned, abs=2e-4)
    chunk, _ = data.chunks(rows, 1, angles)
    cos, sin = math.cos(math.radians(25)), math.sin(math.radians(25))
    dx, dy, dz, drx, dry, drz, hand = acted[0].tolist()
    expected = [cos * dx - sin * dy, sin * dx + cos * dy, dz]
    expected += [cos * drx - sin * dry, sin * drx + cos * dry, drz, hand]
    assert chunk[0].tolist() == pytest.approx(expected)


def test_what_turns_in_no_known_way_is_refused(seen):
    observed, names, actions = seen(0, rotation="quaternion")
    turns = turns_of("arm", names, actions)
    assert turns is None
    shown = demonstrations(observed[None], np.zeros((1, 7), np.float32), turns)
    with pytest.raises(UsageError, match="collect them with --frame base --rotation matrix"):
        ALGORITHM.learner(shown, BcSettings(turn=10.0), seed=0)


def test_pictures_are_not_turned(seen):
    observed, names, actions = seen(0)
    turns = turns_of("arm", names, actions)
    shown = demonstrations(observed[None], np.zeros((1, 7), np.float32), turns)
    pictures = {"front": np.zeros((1, 24, 24, 3), np.uint8)}
    with pytest.raises(UsageError, match="pictures are not turned; set turn=0"):
        ALGORITHM.learner(replace(shown, pictures=pictures), BcSettings(turn=10.0), seed=0)


def test_motions_of_joints_are_not_turned():
    turns = turns_of("arm", ["cube.x in arm.base", "cube.y in arm.base"], ["arm.joint_1_delta"])
    assert turns is not None
    assert not turns.of_tool


def test_a_robot_that_sees_its_own_joints_turns_in_no_known_way():
    """Its first joint would have to turn the other way."""
    assert turns_of("arm", ["arm.joint_1", "cube.x in arm.base"], ["arm.dx", "arm.dy"]) is None
    others = turns_of("arm", ["other.joint_1"], ["arm.dx", "arm.dy"])
    assert others is not None
    assert others.of_tool


def test_what_it_did_before_turns_with_what_it_does():
    names = ["other.previous_dx", "other.previous_dy", "arm.previous_dx", "arm.previous_dy"]
    turns = turns_of("arm", names, ["arm.dx", "arm.dy"])
    assert turns is not None
    assert turns.observed.tolist() == [[2, 3]]
