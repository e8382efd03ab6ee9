"""Gains of motors and delays of actions, drawn anew in each episode."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from taskbuilder import parallel_env
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.rollout import load_rollouts, play, replay, save_rollouts

TASK = """\
task: late
summary: Two arms move, one of them late.
timing: {episode_steps: 12}
scene:
  robots:
    left: {model: ur5e, base: {position: [-1, 0, 0]}, action: {arm: ACTION}}
    right: {model: ur5e, base: {position: [1, 0, 0]}, action: {arm: ACTION}}
  objects:
    cube: {shape: {box: [0.04, 0.04, 0.04]}, mass: 0.1, position: [0, 0.4, 0.02]}
RANDOMIZE
"""
DESCRIPTION = """\
from taskbuilder.description import Above, Bonus, Description


class Late(Description):
    success = Above("cube", height=0.2)
    reward = (Bonus("done", success, 1.0),)
"""
DELAYED = "randomize: {cube.mass: {uniform: [0.05, 0.2]}, left.delay: {choice: [3]}}"
BOTH = """\
randomize:
  cube.mass: {uniform: [0.05, 0.2]}
  left.gains: {uniform: [0.3, 1.8]}
  left.delay: {choice: [0, 1, 2, 3]}
"""


@pytest.fixture
def make(tmp_path: Path) -> Iterator:
    made: list[TaskEnv] = []

    def make_env(drawn: str, action: str = "tcp_delta", **options) -> TaskEnv:
        folder = tmp_path / f"{len(made)}"
        folder.mkdir()
        (folder / "late.py").write_text(DESCRIPTION)
        text = TASK.replace("RANDOMIZE", drawn).replace("ACTION", action)
        (folder / "late.yaml").write_text(text)
        made.append(parallel_env(folder / "late.yaml", **{"randomize": True, **options}))
        return made[-1]

    yield make_env
    for env in made:
        env.close()


def moving(env: TaskEnv, seed: int = 0) -> dict[str, list[np.ndarray]]:
    """Positions of both tools after each step, with the same constant action for both."""
    env.reset(seed=seed)
    world = env.episode.world
    at = {agent: [np.array(world.position(f"{agent}.tcp"))] for agent in env.agents}
    action = np.zeros(env.action_space("left").shape, np.float32)
    action[2] = 0.5
    while env.agents:
        env.step(dict.fromkeys(env.agents, action))
        for agent, found in at.items():
            found.append(np.array(world.position(f"{agent}.tcp")))
    return at


def random_play(env: TaskEnv, seed: int):
    rng = np.random.default_rng(seed)

    def act(_):
        return {
            agent: rng.uniform(-1, 1, env.action_space(agent).shape).astype(np.float32)
            for agent in env.agents
        }

    return play(env, act, seed)


def test_a_delayed_robot_does_the_same_later(make):
    at = moving(make(DELAYED))
    up = {agent: np.array([point[2] for point in found]) for agent, found in at.items()}
    assert np.ptp(up["left"][:4]) < 1e-3
    assert up["right"][3] - up["right"][0] > 0.03
    assert up["left"][3:] == pytest.approx(up["right"][:-3], abs=2e-3)


@pytest.mark.parametrize("action", ["joint_torque", "joint_velocity", "joint_position"])
def test_every_action_mode_can_be_delayed(action, make):
    at = moving(make(DELAYED, action))
    assert len(at["left"]) == 13


def test_low_gains_lag_behind(make):
    slow = moving(make("randomize: {left.gains: {choice: [0.05]}}"))
    assert slow["right"][2][2] - slow["left"][2][2] > 0.005


def test_they_are_drawn_by_the_seed_and_apart_from_the_others(make):
    env, plain = make(BOTH), make("randomize: {cube.mass: {uniform: [0.05, 0.2]}}")
    drawn = []
    for seed in range(12):
        env.reset(seed=seed)
        plain.reset(seed=seed)
        found, other = env.episode.world.quantities, plain.episode.world.quantities
        drawn.append((found["left.gains"], found["left.delay"]))
        assert found["cube.mass"] == other["cube.mass"]
    assert {delay for _, delay in drawn} == {0, 1, 2, 3}
    assert all(0.3 <= gains <= 1.8 for gains, _ in drawn)
    env.reset(seed=3)
    assert env.episode.world.quantities["left.gains"] == drawn[3][0]


def test_episodes_are_replayed_to_the_bit_from_their_files(make, tmp_path):
    env, fresh = make(BOTH), make(BOTH)
    played = [random_play(env, seed) for seed in range(3)]
    save_rollouts(tmp_path / "episodes.npz", played)
    for rollout in reversed(load_rollouts(tmp_path / "episodes.npz")):
        assert replay(fresh, rollout).equals(rollout)


def test_without_randomize_all_is_as_without_the_keys(make):
    with_keys, without = make(BOTH, randomize=False), make("", randomize=False)
    assert with_keys.episode.world.quantities["left.delay"] == 0
    one, two = random_play(with_keys, 1), random_play(without, 1)
    assert one.equals(two)


def test_gains_of_an_episode_do_not_reach_the_next(make):
    env, fresh = make(BOTH), make(BOTH)
    for seed in range(3):
        random_play(env, seed)
    assert random_play(env, 7).equals(random_play(fresh, 7))


def test_a_saved_state_keeps_the_actions_that_are_due(make):
    env = make(DELAYED)
    env.reset(seed=0)
    rng = np.random.default_rng(0)
    shape = env.action_space("left").shape
    actions = [
        {a: rng.uniform(-1, 1, shape).astype(np.float32) for a in ("left", "right")}
        for _ in range(8)
    ]
    for action in actions[:4]:
        env.step(action)
    state = env.episode.save()

    def go_on():
        for action in actions[4:]:
            env.step(action)
        return env.episode.world.robots["left"].arm_state()

    first = go_on()
    env.episode.load(state)
    env.agents = list(env.possible_agents)
    assert go_on() == first


def test_a_copy_of_an_environment_goes_on_alike(make):
    from copy import deepcopy

    env = make(DELAYED)
    env.reset(seed=0)
    shape = env.action_space("left").shape
    action = {a: np.full(shape, 0.3, np.float32) for a in ("left", "right")}
    for _ in range(2):
        env.step(action)
    with closing(deepcopy(env)) as copied:
        for _ in range(4):
            env.step(action)
            copied.step(action)
        states = [e.episode.world.robots["left"].arm_state() for e in (env, copied)]
    assert states[0] == states[1]
