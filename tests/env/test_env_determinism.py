"""The same seed and actions lead to the same numbers, bit for bit, wherever and whenever."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from env_tasks import (
    GRASPS,
    LIBRARY,
    digest,
    facing,
    grasp,
    moment,
    physical,
    play,
    random_actions,
    towards,
    write_task,
)
from env_trajectories import episodes, run

from taskbuilder.env.joint import JointEnv
from taskbuilder.env.parallel import parallel_env

SEEDS = (0, 1, 2)
EPISODES = 3

VARIED = """
variations:
  - {block.color: green}
  - {block.mass: 0.2, spot.place.center: [0.1, 0.3, 0.5]}
randomize:
  block.mass: {uniform: [0.05, 0.3]}
  other.friction: {uniform: [0.3, 1.2]}
  block.color: {choice: [red, green]}
observation_noise:
  left: {block.pose: {position_std: 0.01, angle_std_deg: 2}}
"""
WATCHED = ("left: [self.tcp, block.pose, self.previous_action]", "right: [self.tcp, time_left]")


@pytest.fixture(scope="module")
def played():
    """Hashes of every task's episodes, each seed in an environment of its own."""
    return {(task, seed): run(task, {}, seed, EPISODES) for task in LIBRARY for seed in SEEDS}


def elsewhere(jobs: list[object]) -> list[list[str]]:
    """The hashes of jobs in a fresh process."""
    done = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("env_trajectories.py"))],
        input=json.dumps(jobs),
        env={**os.environ, "PYTHONHASHSEED": "7"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found: list[list[str]] = json.loads(done.stdout)
    return found


def test_episodes_and_seeds_differ(played):
    hashes = [found for each in played.values() for found in each]
    assert len(set(hashes)) == len(LIBRARY) * len(SEEDS) * EPISODES


@pytest.mark.parametrize(
    "task",
    [
        pytest.param(name, marks=pytest.mark.slow if number else ())
        for number, name in enumerate(LIBRARY)
    ],
)
def test_episodes_do_not_depend_on_those_before(played, task):
    env = parallel_env(task)
    grasping = GRASPS[task]
    for seed in (*SEEDS, *reversed(SEEDS)):
        env.reset(seed=99)
        grasp(env, grasping)
        assert episodes(env, seed, EPISODES) == played[task, seed]
    env.close()


@pytest.mark.slow
@pytest.mark.parametrize("task", LIBRARY)
def test_episodes_rich_in_contacts_do_not_depend_on_those_before(task):
    """Grasps, collisions and things that fall change the order in which Bullet knows its pairs."""
    used = parallel_env(task)
    for seed in range(6):
        used.reset(seed=100 + seed)
        grasp(used, GRASPS[task])
        play(used, random_actions(used, seed, 20 if seed % 2 else 5))
        fresh = parallel_env(task)
        found = []
        for env in (used, fresh):
            env.reset(seed=seed)
            back = grasp(env, GRASPS[task])
            for _ in range(6):
                back.append(env.step(towards(env, lifted(env, GRASPS[task]), {})))
            actions = random_actions(env, seed + 7, 20)
            found.append(digest(back, play(env, actions), moment(env)))
        fresh.close()
        assert found[0] == found[1], seed
    used.close()


def lifted(env, grasps) -> dict[str, tuple[float, float, float]]:
    """Where tools go straight up to."""
    return {agent: (*env.episode.world.position(f"{agent}.tcp")[:2], 0.65) for agent in grasps}


@pytest.mark.slow
def test_a_fresh_process_gives_the_same(played, tmp_path):
    jobs = [[task, {}, seed, EPISODES] for task, seed in played]
    path = write_task(tmp_path, facing(*WATCHED, extra=VARIED))
    options = {"variation": "random", "randomize": True, "control_hz": 20, "reward": "local"}
    jobs.append([str(path), options, 5, 4])
    assert elsewhere(jobs) == [*played.values(), run(str(path), options, 5, 4)]


@pytest.mark.parametrize("task", LIBRARY)
def test_an_episode_goes_on_the_same_from_a_saved_state_with_a_grasped_object(task):
    env = parallel_env(task)
    env.reset(seed=1)
    grasp(env, GRASPS[task])
    world = env.episode.world
    assert any(world.held(name, robot) for name in world.movable for robot in world.robots)
    lift = lifted(env, GRASPS[task])
    state, now = env.save_state(), digest(moment(env))
    actions = []
    for _ in range(8):
        actions.append(towards(env, lift, {}))
        env.step(actions[-1])
    actions += random_actions(env, 0, 20)
    env.load_state(state)
    assert digest(moment(env)) == now
    first = play(env, actions), digest(moment(env)), episodes_after(env)
    for disturbance in ("another episode", "the end", "nothing"):
        if disturbance == "another episode":
            env.reset(seed=17)
            play(env, random_actions(env, 3, 10))
        elif disturbance == "the end":
            env.load_state(state)
            while env.agents:
                env.step(random_actions(env, 4, 1)[0])
        env.load_state(state)
        assert digest(moment(env)) == now, disturbance
        assert env.agents == env.possible_agents
        assert (play(env, actions), digest(moment(env)), episodes_after(env)) == first, disturbance
    env.close()


def episodes_after(env) -> list[str]:
    """Hashes of the next episodes, not seeded."""
    found = []
    for number in range(2):
        found.append(digest(*env.reset()))
        found.append(play(env, random_actions(env, number, 5)))
    return found


def test_a_saved_state_holds_noise_randomised_quantities_and_the_variation(make):
    env = make(facing(*WATCHED, extra=VARIED), variation="random", randomize=True)
    masses = set()
    for seed in range(6):
        views, _ = env.reset(seed=seed)
        for action in random_actions(env, seed, 3):
            views, *_ = env.step(action)
        state, now = env.save_state(), moment(env)
        quantities = dict(env.episode.world.quantities)
        masses.add(env.episode.world.objects["block"].body.mass)
        actions = random_actions(env, seed, 6)
        first = play(env, actions), episodes_after(env)
        loaded = env.load_state(state)
        assert digest(loaded) == digest(views)
        assert digest(moment(env)) == digest(now)
        assert dict(env.episode.world.quantities) == quantities
        assert (play(env, actions), episodes_after(env)) == first
    assert len(masses) == 6


def test_what_load_state_gives_back_is_what_was_seen_then(make):
    env = make(facing(*WATCHED))
    views, _ = env.reset(seed=0)
    for action in random_actions(env, 0, 4):
        views, *_ = env.step(action)
    state = env.save_state()
    env.reset(seed=5)
    assert digest(env.load_state(state)) == digest(views)


def test_a_state_saved_at_the_end_is_one_at_the_end(make):
    env = make(facing(), horizon=2)
    env.reset(seed=0)
    play(env, random_actions(env, 0, 2))
    state = env.save_state()
    env.reset(seed=1)
    env.load_state(state)
    assert env.agents == []
    assert env.episode.over


def test_many_states_can_be_kept_and_gone_back_to_in_any_order(make):
    env = make(facing())
    env.reset(seed=0)
    kept = []
    for action in random_actions(env, 0, 10):
        env.step(action)
        kept.append((env.save_state(), digest(moment(env))))
    for number in np.random.default_rng(0).permutation(len(kept)):
        state, then = kept[number]
        env.load_state(state)
        assert digest(moment(env)) == then


def test_the_joint_view_goes_back_too():
    env = JointEnv("handover")
    env.reset(seed=0)
    rng = np.random.default_rng(0)
    seen, *_ = env.step(rng.uniform(-1, 1, 10))
    state = env.save_state()
    actions = rng.uniform(-1, 1, (5, 10))
    first = digest([env.step(action) for action in actions], env.reset())
    assert env.load_state(state).tobytes() == seen.tobytes()
    assert digest([env.step(action) for action in actions], env.reset()) == first
    env.close()


def test_without_a_seed_environments_differ(make):
    placed = set()
    for _ in range(3):
        env = make(facing())
        env.reset()
        placed.add(env.episode.world.position("spot"))
    assert len(placed) == 3


def test_a_seed_decides_all_episodes_until_the_next_seed(make):
    env = make(facing())
    shown = []
    for seed in (3, 4, 3):
        env.reset(seed=seed)
        placed = []
        for _ in range(3):
            env.reset()
            placed.append(env.episode.world.position("spot"))
        shown.append(placed)
    assert shown[0] == shown[2]
    assert shown[0] != shown[1]
    assert len(set(shown[0])) == 3


def test_global_random_state_neither_matters_nor_moves(make):
    env = make(facing(*WATCHED, extra=VARIED), variation="random", randomize=True)
    found = []
    for seed in (0, 1):
        np.random.seed(seed)
        before = np.random.get_state()[1].tobytes()
        env.reset(seed=3)
        found.append(play(env, random_actions(env, 0, 5)))
        assert np.random.get_state()[1].tobytes() == before
    assert found[0] == found[1]


def test_two_environments_in_turns_do_not_disturb_each_other(make):
    alone = make(facing())
    alone.reset(seed=0)
    actions = random_actions(alone, 0, 10)
    expected = play(alone, actions)
    one, other = make(facing()), make(facing())
    one.reset(seed=0)
    other.reset(seed=9)
    parts = []
    for action, noise in zip(actions, random_actions(other, 1, 10), strict=True):
        parts += [*one.step(action), one.state()]
        other.step(noise)
    assert digest(*parts) == expected


@pytest.mark.parametrize("task", LIBRARY)
def test_the_cost_of_a_step_is_recorded(task, record_property):
    """Not asserted, for machines differ; the numbers are in the report that pytest writes."""
    from time import perf_counter

    env = parallel_env(task)
    env.reset(seed=0)
    actions = random_actions(env, 0, 50)
    start = perf_counter()
    for action in actions:
        env.step(action)
    record_property("ms_per_step", round((perf_counter() - start) / len(actions) * 1e3, 3))
    start = perf_counter()
    env.reset()
    record_property("ms_per_reset", round((perf_counter() - start) * 1e3, 3))
    assert digest(physical(env))
    env.close()
