"""Orders to hold something, carried out by suction."""

from __future__ import annotations

import math
import shutil

import numpy as np
import pytest
from test_expert_joints import CABINET, URDFS
from written_experts import made, same

from taskbuilder.errors import FileError
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import replay

PLATE = """\
    plate:
      shape: {box: [0.2, 0.12, 0.008]}
      mass: 0.3
      position: [0.05, 0.1, 0.4045]
      grasps: {top: {at: [0, 0, 0.004]}, inside: {at: [0, 0, -0.05]}}
"""
GRASP = "arm: {grasp: plate.top}"
LIFT = "arm: {bring: plate, to: [0.05, -0.1, 0.55]}"


@pytest.fixture
def begin(tmp_path):
    """An environment with the given stages for an arm with suction, and its expert."""
    experts = []
    shutil.copy(URDFS / "drawer_by_its_knob.urdf", tmp_path)

    def make(*stages, **scene):
        env = made(tmp_path, *stages, model="ur5e_suction", **{"objects": PLATE} | scene)
        experts.append(Expert(env))
        return env, experts[-1]

    yield make
    for expert in experts:
        expert.close()
        expert.env.close()


def test_a_plate_is_taken_brought_and_released(begin):
    places = []
    env, expert = begin(GRASP, LIFT, "arm: {bring: plate, to: [0.05, -0.1, 0.406]}", "arm: release")
    world = env.episode.world
    rollout = expert.play(0, after_stage=lambda _: places.append(world.position("plate")))
    assert rollout.trouble is None
    assert math.dist(places[1], (0.05, -0.1, 0.55)) < 0.02
    assert math.dist(world.position("plate"), (0.05, -0.1, 0.404)) < 0.02
    assert not world.held("plate", "arm")
    assert world.robots["arm"].opening() == 1.0
    assert replay(env, rollout).equals(rollout)  # to the bit
    assert same(expert.play(0), rollout)


def test_its_action_has_one_number_and_its_observation_a_channel(begin):
    env, _ = begin("arm: home", flat=False)
    assert env.action_space("arm")["gripper"].shape == (1,)
    seen, _ = env.reset(seed=0)
    still = {"arm": {"arm": np.zeros(4, np.float32), "gripper": np.array([-1.0], np.float32)}}
    assert (seen["arm"]["self.gripper"], seen["arm"]["self.holding"]) == (1.0, 0.0)
    seen, *_ = env.step(still)
    assert (seen["arm"]["self.gripper"], seen["arm"]["self.holding"]) == (0.0, 0.0)


def test_a_state_saved_in_an_environment_goes_on_to_the_bit(begin):
    env, expert = begin(GRASP, LIFT)
    rollout = expert.play(0)
    actions = rollout.actions["arm"]

    def play(steps):
        return [repr(env.step({"arm": actions[step]})[:2]) for step in steps]

    env.reset(seed=0)
    held = [env.episode.world.held("plate", "arm") for step in range(20) if play([step])]
    moment = held.index(True) + 1
    env.reset(seed=0)
    play(range(moment))
    saved = env.save_state()
    first = play(range(moment, len(actions)))
    env.reset(seed=1)
    play(range(moment + 3))
    env.load_state(saved)
    assert play(range(moment, len(actions))) == first


def test_suction_on_nothing_is_a_missed_grasp(begin):
    _, expert = begin("arm: {reach: spot}", "arm: {close: plate}")
    trouble = expert.play(0).trouble
    assert trouble.cause == "grasp missed"
    assert trouble.message == (
        "arm does not hold plate: its suction is on, and no surface is within 6 mm of its cup"
    )


def test_a_drawer_is_opened_by_suction(begin):
    cabinet = CABINET.replace("at: [-0.09, -0.135, 0.05]", "at: [0.03, -0.095, 0.035]")
    cabinet = cabinet.replace("across: x}}", "approach: +y, across: x}}")
    env, expert = begin(
        "arm: {reach: [-0.05, -0.35, 0.45], rpy_deg: [-90, 0, 0]}",
        "arm: {grasp: cabinet.knob}",
        "arm: {slide: cabinet.runner, to: 0.06, speed: 0.3}",
        objects=cabinet,
        action="turn: full",
    )
    rollout = expert.play(0, finish=False)
    assert rollout.trouble is None
    assert env.episode.world.joint("cabinet.runner") == pytest.approx(0.06, abs=0.02)


def test_it_pushes_without_sucking(begin):
    env, expert = begin("arm: {close: nothing}", "arm: {push: block, to: [-0.1, 0.0, 0.4]}")
    rollout = expert.play(0, finish=False)
    assert rollout.trouble is None
    world = env.episode.world
    assert world.robots["arm"].opening() == 1.0
    assert math.dist(world.position("block")[:2], (-0.1, 0.0)) < 0.021


def test_its_opening_has_no_width(begin):
    with pytest.raises(FileError) as caught:
        begin("arm: home", action="gripper: continuous")
    (found,) = caught.value.findings
    assert found.code == "TB216"
    assert found.message == "the suction of arm is on or off; write gripper: binary"
