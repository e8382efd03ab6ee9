"""Saved states lead to the same wherever they are loaded: by a snapshot, or by their actions."""

from __future__ import annotations

import gc
import pickle
import subprocess
import sys
from contextlib import closing
from copy import copy, deepcopy
from pathlib import Path

import pytest
from env_tasks import digest, facing, moment, play, random_actions

from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import ExplosionError, UsageError
from taskbuilder.expert import Expert

TIPPING = Path(__file__).parents[1] / "tasks" / "variants" / "tip_and_rake.yaml"

VARIED = """
variations:
  - {block.color: green}
  - {block.mass: 0.2, spot.place.center: [0.1, 0.3, 0.5]}
randomize:
  block.mass: {uniform: [0.05, 0.3]}
  left.delay: {choice: [0, 2]}
observation_noise:
  left: {block.pose: {position_std: 0.01, angle_std_deg: 2}}
"""
WATCHED = ("left: [self.tcp, block.pose, self.previous_action]", "right: [self.tcp, time_left]")

ELSEWHERE = """
import pickle, sys
sys.path.insert(0, {folder!r})
from env_tasks import digest, moment, play
from taskbuilder.env.parallel import parallel_env

env = parallel_env({task!r}, variation="random", randomize=True)
env.reset(seed=9)
with open({file!r}, "rb") as file:
    state, actions = pickle.load(file)
seen = digest(env.load_state(state), moment(env))
print(seen, play(env, actions), digest(moment(env)))
"""

GUTTER = """<robot name="gutter">
  <link name="stand"><inertial><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="gutter"><inertial><mass value="0.5"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0.04 0" rpy="0.7 0 0"/>
      <geometry><box size="0.3 0.1 0.01"/></geometry></collision>
    <collision><origin xyz="0 -0.04 0" rpy="-0.7 0 0"/>
      <geometry><box size="0.3 0.1 0.01"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="stand"/><child link="gutter"/>
    <axis xyz="1 0 0"/><limit lower="-0.1" upper="0.1" effort="10" velocity="1"/></joint>
</robot>
"""
ROLLING = """
timing: {control_hz: 10, physics_hz: 120, episode_steps: 50}
scene:
  robots:
    arm: {model: ur5e, base: {position: [0, 0, 0]}}
  objects:
    gutter: {shape: {urdf: gutter.urdf}, fixed: true, position: [0.8, 0, 0.1]}
    ball:
      shape: {sphere: 0.03}
      mass: 0.1
      place: {center: [0.8, 0, 0.6], size: [0.1, 0, 0]}
  sites:
    spot: {position: [0.45, 0.1, 0.4]}
"""

HARD = {"open_lid": range(48, 58), "pack_and_close": range(62, 68)}
"""Control steps of the expert's episode of seed 0 that a snapshot does not lead back to."""

WAYS = {"as it is": lambda state: state, "by its actions": deepcopy}
ways = pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)


@pytest.fixture
def tipping():
    """A ball that rolls on several shapes of one moving link: contacts that no snapshot holds."""
    with closing(parallel_env(TIPPING)) as env, closing(Expert(env)) as expert:
        played = expert.play(0)
        assert played.success, played.trouble
        yield env, [{a: own[step] for a, own in played.actions.items()} for step in range(65)]


def test_what_touches_several_shapes_of_a_link_is_restored_exactly(tipping):
    env, actions = tipping
    env.reset(seed=0)
    saved, after = [], []
    for action in actions:
        saved.append(env.save_state())
        after.append(digest(*env.step(action), moment(env)))
    snapshots = [state.episode.snapshot is not None for state in saved]
    assert not any(snapshots[40:60]), "the ball is raked"
    for first in range(len(actions) - 5, 0, -5):
        env.load_state(saved[first])
        for step in range(first, first + 3):
            assert digest(*env.step(actions[step]), moment(env)) == after[step], (first, step)


@pytest.mark.parametrize(("task", "steps"), HARD.items())
def test_states_that_the_engine_alone_does_not_restore(task, steps):
    with closing(parallel_env(task)) as env, closing(Expert(env)) as expert:
        played = expert.play(0)
        actions = [
            {a: own[step] for a, own in played.actions.items()} for step in range(steps.stop)
        ]
        env.reset(seed=0)
        play(env, actions[: steps.start])
        saved, after = [], []
        for step in steps:
            saved.append(env.save_state())
            after.append(digest(*env.step(actions[step]), moment(env)))
        for step, state, then in reversed(list(zip(steps, saved, after, strict=True))):
            env.load_state(state)
            assert digest(*env.step(actions[step]), moment(env)) == then, step


def test_an_episode_goes_on_from_a_snapshot_into_such_contacts_exactly(make):
    env = make(ROLLING, files={"gutter.urdf": GUTTER})
    actions = random_actions(env, 0, 15)
    env.reset(seed=0)
    state = env.save_state()
    assert state.episode.snapshot is not None, "the ball is still in the air"
    first = play(env, actions), digest(moment(env))
    for seed in (1, 2):
        env.reset(seed=seed)
        play(env, actions[: 5 * seed])
        env.load_state(state)
        assert env.episode.world.contact_order.watched
        assert (play(env, actions), digest(moment(env))) == first
        assert not env.episode.world.contact_order.watched, "its actions were played again"


def test_physics_that_diverges_only_after_a_snapshot_is_played_again(make):
    env, twin = make(facing()), make(facing())
    actions = random_actions(env, 0, 6)
    for one in (env, twin):
        one.reset(seed=0)
        play(one, actions[:3])
    env.load_state(env.save_state())
    world = env.episode.world

    def burst(targets):
        world.contact_order.uncertain = True
        raise ExplosionError("for a test")

    world.step = burst
    assert play(env, actions[3:]) == play(twin, actions[3:])
    assert env.episode.world is not world


@ways
def test_a_state_holds_noise_delays_and_what_is_randomised(way, make):
    env = make(facing(*WATCHED, extra=VARIED), variation="random", randomize=True)
    delays = set()
    for seed in range(6):
        env.reset(seed=seed)
        delays.add(env.episode.delay("left"))
        actions = random_actions(env, seed, 10)
        play(env, actions[:4])
        state, now = way(env.save_state()), digest(moment(env))
        first = play(env, actions[4:]), digest(env.reset())
        env.reset(seed=50 + seed)
        for _ in range(2):
            env.load_state(state)
            assert digest(moment(env)) == now
            assert (play(env, actions[4:]), digest(env.reset())) == first
    assert len(delays) == 2


def test_a_state_is_loaded_in_another_process(make, tmp_path):
    env = make(facing(*WATCHED, extra=VARIED), variation="random", randomize=True)
    env.reset(seed=3)
    actions = random_actions(env, 3, 10)
    seen = None
    for action in actions[:5]:
        seen, *_ = env.step(action)
    file = tmp_path / "state.pickle"
    file.write_bytes(pickle.dumps((env.save_state(), actions[5:])))
    here = digest(seen, moment(env)), play(env, actions[5:]), digest(moment(env))
    folder, task = str(Path(__file__).parent), str(env.task.file.entry.file)
    code = ELSEWHERE.format(folder=folder, task=task, file=str(file))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.stdout.split(), done.stderr) == ([*here], "")


@ways
def test_a_state_is_loaded_in_another_environment_of_the_task(way, make):
    env = make(facing(*WATCHED))
    env.reset(seed=0)
    actions = random_actions(env, 0, 12)
    play(env, actions[:6])
    state = env.save_state()
    first = play(env, actions[6:]), digest(moment(env))
    other = parallel_env(env.task)
    other.reset(seed=8)
    play(other, actions[::-1])
    for _ in range(2):
        other.load_state(way(state))
        assert (play(other, actions[6:]), digest(moment(other))) == first
    other.close()


def test_a_state_is_loaded_after_the_physics_diverged(make):
    env = make(facing())
    env.reset(seed=0)
    actions = random_actions(env, 0, 6)
    play(env, actions[:3])
    state = env.save_state()
    first = play(env, actions[3:])

    def burst(targets):
        raise ExplosionError("for a test")

    env.episode.world.step = burst
    play(env, actions[:1])
    assert env.episode.exploded
    env.load_state(state)
    assert play(env, actions[3:]) == first


def test_a_state_that_was_loaded_is_saved_again(make):
    env = make(facing())
    env.reset(seed=0)
    actions = random_actions(env, 0, 9)
    play(env, actions[:3])
    env.load_state(deepcopy(env.save_state()))
    play(env, actions[3:6])
    state = env.save_state()
    first = play(env, actions[6:])
    env.load_state(deepcopy(state))
    assert play(env, actions[6:]) == first


@ways
def test_a_state_of_another_task_or_of_other_options_is_refused(way, make):
    env, quick = make(facing()), make(facing(), horizon=20)
    reach = make("reach")
    for one in (env, quick, reach):
        one.reset(seed=0)
    before = digest(moment(env))
    with pytest.raises(UsageError, match="the state is of reach; this environment plays made"):
        env.load_state(way(reach.save_state()))
    wanted = "saved with horizon=20, and this environment has horizon=None"
    with pytest.raises(UsageError, match=wanted):
        env.load_state(way(quick.save_state()))
    assert digest(moment(env)) == before
    assert env.agents
    make_seen = make(facing(), reward="local", observe="scene")
    make_seen.load_state(env.save_state())  # other options are no hindrance


def test_a_world_that_something_else_moved_is_not_restored_by_actions(make):
    env = make(facing())
    env.reset(seed=0)
    block = env.episode.world.objects["block"].body
    block.place(type(block.pose())((0.3, 0.3, 0.3), block.pose().quaternion))
    state = env.save_state()
    with pytest.raises(UsageError, match=r"something else moved the world .*reset the environment"):
        env.load_state(deepcopy(state))
    with pytest.raises(UsageError, match="reset"):
        env.save_state()
    env.reset(seed=0)
    assert env.agents


def test_snapshots_go_with_the_last_state_that_holds_them(make):
    env = make(facing())
    env.reset(seed=0)
    client = env.episode.world.client
    before = client.snapshots
    state = env.save_state()
    other = copy(state)
    assert client.snapshots == before + 1
    del state
    gc.collect()
    env.load_state(other)
    assert client.snapshots == before + 1
    del other
    gc.collect()
    assert client.snapshots == before
