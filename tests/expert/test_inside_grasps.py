"""What is hollow is held from inside: the fingers go in closed, and open."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest

from taskbuilder import load_task, parallel_env
from taskbuilder.expert.script.dry_run import dry_run
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import play
from taskbuilder.validate.playing import DropAll
from taskbuilder.world.building import build_world

TASK = """\
task: cup_up
summary: A cup is carried by fingers that open inside it, and put down elsewhere.
timing: {episode_steps: 100}
scene:
  robots:
    arm:
      model: MODEL
      base: {position: [0, 0, 0]}
      home: {tcp: {position: [0.45, 0, 0.3], rpy_deg: [180, 0, 0]}}
  objects:
    cup:
      parts:
        floor: {box: [0.066, 0.066, 0.006], at: [0, 0, -0.037]}
        north: {box: [0.066, 0.006, 0.08], at: [0, 0.03, 0]}
        south: {box: [0.066, 0.006, 0.08], at: [0, -0.03, 0]}
        east: {box: [0.006, 0.066, 0.08], at: [0.03, 0, 0]}
        west: {box: [0.006, 0.066, 0.08], at: [-0.03, 0, 0]}
      mass: 0.15
      position: [0.5, 0.1, 0.04]
      grasps: {hollow: {at: [0, 0, 0.02], across: y, inside: true}}
  sites:
    goal: {position: [0.45, -0.2, 0.04]}
expert:
  - arm: {grasp: cup.hollow}
  - arm: {bring: cup, to: [0.45, 0, 0.25]}
  - arm: {bring: cup, to: goal}
  - arm: release
  - arm: {retreat: 0.1}
"""
DESCRIPTION = """\
from taskbuilder.description import Bonus, Description, Held, Near, Released


class CupUp(Description):
    success = Near("cup", "goal", within=0.03) & Released("cup")
    reward = (Bonus("held", Held("cup", by="arm"), 1.0),)
"""


@pytest.fixture
def task(tmp_path: Path):
    def write(model: str = "ur5e") -> Path:
        (tmp_path / "cup_up.yaml").write_text(TASK.replace("MODEL", model))
        (tmp_path / "cup_up.py").write_text(DESCRIPTION)
        return tmp_path / "cup_up.yaml"

    return write


@pytest.mark.parametrize("model", ["ur5e", "panda"])
def test_a_cup_is_carried_by_fingers_that_open_inside(task, model):
    with closing(parallel_env(task(model))) as env, closing(Expert(env)) as expert:
        played = play(env, expert, 0)
        world = env.episode.world
        assert played.success, played.trouble
        assert not world.held("cup", "arm")


def test_it_is_held_while_the_gripper_is_told_to_open_and_pressed_outwards(task):
    with closing(parallel_env(task())) as env, closing(Expert(env)) as expert:
        env.reset(seed=0)
        expert.reset(env, 0)
        world = env.episode.world
        for _ in range(60):
            env.step(expert.act({}))
            if world.held("cup", "arm") and world.position("cup")[2] > 0.15:
                break
        assert world.held("cup", "arm")
        assert world.robots["arm"].gripper.told() == 1.0
        assert world.robots["arm"].opening() < 0.9
        assert world.grip_forces("cup", "arm") == pytest.approx((20.0, 20.0), rel=0.5)
        # Who drops everything has to close such a gripper.
        drop = DropAll()
        drop.reset(env, 0)
        for _ in range(8):
            env.step(drop.act({}))
        assert not world.held("cup", "arm")
        assert world.position("cup")[2] < 0.1


def test_a_dry_run_follows_it(task):
    with closing(build_world(load_task(task()).file)) as world:
        asked = list(dry_run(world))
    assert [ask.stage for ask in asked] == [1, 1, 2, 3, 5]
    assert not any(ask.guess for ask in asked[:-1])
