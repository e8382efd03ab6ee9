"""Options of observations: their frame, the whole scene, and formats of rotations and distances."""

from __future__ import annotations

import itertools
import math
from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tasks import LIBRARY, arm, digest, facing, near, physical, play, random_actions, tcp
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import taskbuilder.gym  # noqa: F401  # registers the tasks
from taskbuilder.env.observations import compressed
from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.env.vector import make_vec
from taskbuilder.geometry import Pose, Vec3, rotate

LEARNERS: dict[str, Any] = {"observe": "scene", "frame": "base", "rotation": "matrix"}

TWINS = """
timing: {{control_hz: 10, physics_hz: 120, episode_steps: 50}}
scene:
  robots:
    left:
      model: ur5e
      base: {{position: [-1, 0, 0.5]}}
      home: {{tcp: {{position: [-0.5, 0, 0.9], rpy_deg: [180, 0, 0]}}}}
      action: {{{action}}}
    right:
      model: ur5e
      base: {{position: [1, 0, 0.5], rpy_deg: [0, 0, 180]}}
      home: {{tcp: {{position: [0.5, 0, 0.9], rpy_deg: [180, 0, 180]}}}}
      action: {{{action}}}
  objects:
    mine:
      shape: {{box: [0.06, 0.04, 0.02]}}
      mass: 0.1
      position: [0.3, 1.5, 3]
      rpy_deg: [10, 20, 30]
    yours:
      shape: {{box: [0.06, 0.04, 0.02]}}
      mass: 0.1
      position: [-0.3, -1.5, 3]
      rpy_deg: [10, 20, 210]
  sites:
    here: {{position: [-0.4, 0.1, 0.7]}}
    there: {{position: [0.4, -0.1, 0.7]}}
observe:
  left: [{own}, mine.pose, mine.orientation, mine.velocity, here.position, right.tcp, time_left]
  right: [{own}, yours.pose, yours.orientation, yours.velocity, there.position, left.tcp, time_left]
"""
"""Turned by half a turn about the vertical, the scene is itself with left and right exchanged."""

OWN = "self.joints, self.joint_velocities, self.tcp, self.tcp_velocity, self.gripper, self.holding"

TWINS_DESCRIPTION = """
from taskbuilder.description import Description, Distance, Near


class Made(Description):
    success = Near("left.tcp", "right.tcp", within=0.01)
    reward = (Distance("reach", "left.tcp", "right.tcp"),)
"""

CROWD = """
timing: {control_hz: 10, physics_hz: 120, episode_steps: 5}
scene:
  robots:
    c: {model: ur5e, base: {position: [0, 0, 0]}}
    a: {model: ur5e, base: {position: [3, 0, 0]}}
    b: {model: ur5e, base: {position: [6, 0, 0]}}
  sites: {spot: {position: [0, 1, 1]}}
"""
CROWD_DESCRIPTION = TWINS_DESCRIPTION.replace("left", "a").replace("right", "b")

TOLD = (
    *("block.pose", "block.position", "block.orientation", "block.velocity", "spot.position"),
    *("self.tcp", "self.tcp_velocity", "left.tcp"),
)
"""Channels that are told in the world unless another frame is asked for."""

UNTOLD = (
    *("block.pose in self.tcp", "spot.position in left.base", "self.joints", "self.gripper"),
    *("self.holding", "self.previous_action", "time_left"),
)
"""Channels that no frame of the options changes."""


def matrix(quaternion: Any) -> Any:
    """(3, 3) rotation of a quaternion xyzw, a column for each turned axis."""
    x, y, z, w = map(float, quaternion)
    turn = (x, y, z, w)
    return np.array([rotate(turn, axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]).T


def columns(quaternion: Any) -> Any:
    """(6,) the first two columns of a rotation's matrix, one after the other."""
    return matrix(quaternion)[:, :2].T.ravel()


def seen(env: TaskEnv) -> Any:
    """What every agent would see now."""
    env.episode.world.refresh()
    return env._observer.observe(env.episode)


def base(env: TaskEnv, agent: str) -> Pose:
    """Where a robot stands."""
    return env.episode.world.pose(f"{agent}.base")


# --- frame: robots that face each other are alike

MODES = {
    "steps": "",
    "steps that turn": "turn: full",
    "poses": "arm: tcp_pose, turn: full",
    "ways": "arm: tcp_path, turn: yaw",
    "steps of the tool": "frame: tcp",
}


@pytest.mark.parametrize("mode", MODES)
def test_in_their_own_frames_robots_that_face_each_other_are_one_robot(make, mode):
    """Told alike, they are commanded alike; posed alike, they see alike.

    In between, the solver takes one arm before the other, so that they move a little differently.
    """
    env = make(TWINS.format(action=MODES[mode], own=OWN), TWINS_DESCRIPTION, frame="base")
    views, _ = env.reset(seed=0)
    left, right = env.episode.world.robots.values()
    rng = np.random.default_rng(1)
    start = views["left"]
    for _ in range(6):
        action = rng.uniform(-0.5, 0.5, env.action_space("left").shape)
        views, *_ = env.step({"left": action, "right": action})
        assert near(left.arm.command.values, right.arm.command.values, 1e-9)
        tools = [base(env, agent).inverse() @ tcp(env, agent) for agent in env.agents]
        assert near(tools[0].position, tools[1].position, 1e-3)
    assert not near(views["left"], start, 0.03)
    for robot in (left, right):
        robot.body.reset_joints(robot.arm.indices, [joint - 0.1 for joint in robot.home])
        robot.body.reset_joints(robot.gripper.joints, robot.gripper.positions(0.3))
    views = seen(env)
    assert near(views["left"], views["right"], 1e-6)
    assert not near(views["left"], start, 0.03)


def test_in_the_world_they_see_and_move_each_their_own_way(make):
    env = make(TWINS.format(action="", own=OWN), TWINS_DESCRIPTION, flat=False)
    env.reset(seed=0)
    action = {"arm": np.array([0.5, 0.0, 0.0, 0.0]), "gripper": np.zeros(1)}
    for _ in range(3):
        views, *_ = env.step({"left": action, "right": action})
    assert views["left"]["self.tcp"][0] < -0.4 < 0.4 < views["right"]["self.tcp"][0]
    assert views["left"]["self.tcp_velocity"][0] > 0.1 < views["right"]["self.tcp_velocity"][0]


@pytest.mark.parametrize("mode", ["turn: full", "arm: tcp_pose, turn: yaw", "arm: tcp_path"])
def test_one_motion_in_either_frame_gives_one_world(make, mode):
    """The translation is turned into the base's axes; a turn that is told in `frame` likewise."""
    text = arm(action=mode).replace("[0, 0, 0]}", "[0, 0, 0], rpy_deg: [0, 0, 70]}")
    in_world, in_base = (make(text, frame=frame) for frame in ("task", "base"))
    for env in (in_world, in_base):
        env.reset(seed=0)
    back = base(in_base, "arm").inverse().quaternion
    start = in_world.episode.world.pose("arm.tcp").position
    rng = np.random.default_rng(2)
    for _ in range(6):
        action = rng.uniform(-0.5, 0.5, in_world.action_space("arm").shape)
        told = action.copy()
        for first in (0, 3) if mode == "turn: full" else (0,):
            told[first : first + 3] = rotate(back, tuple(action[first : first + 3]))
        in_world.step({"arm": action})
        in_base.step({"arm": told})
        one, other = (env.episode.world for env in (in_world, in_base))
        assert near(one.robots["arm"].arm_state()[0], other.robots["arm"].arm_state()[0], 1e-6)
        assert near(one.pose("arm.tcp").position, other.pose("arm.tcp").position, 1e-6)
    assert not near(one.pose("arm.tcp").position, start, 0.03)


@pytest.mark.parametrize("mode", ["frame: base", "frame: tcp", "arm: joint_delta"])
def test_actions_that_are_not_told_in_the_world_stay_as_they_are(make, mode):
    text = facing("left: [time_left]", "right: [time_left]", action=mode)
    hashes = set()
    for frame in ("task", "base"):
        env = make(text, frame=frame)
        env.reset(seed=0)
        hashes.add(play(env, random_actions(env, 0, 5)))
    assert len(hashes) == 1


def test_what_is_told_in_the_world_is_told_from_ones_base_and_nothing_else_is(make):
    channels = ", ".join((*TOLD, *UNTOLD))
    text = facing(f"left: [{channels}]", f"right: [{channels}]", action="arm: joint_delta")
    plain, own = (make(text, flat=False, frame=frame) for frame in ("task", "base"))
    for env in (plain, own):
        env.reset(seed=0)
    for action in random_actions(make(text), 0, 4):
        parts = {a: {"arm": v[:-1], "gripper": v[-1:]} for a, v in action.items()}
        here, there = plain.step(parts)[0], own.step(parts)[0]
    assert digest(physical(plain)) == digest(physical(own))
    for agent in plain.possible_agents:
        back = base(plain, agent).inverse()
        turn = matrix(back.quaternion)
        for channel in UNTOLD:
            assert here[agent][channel].tobytes() == there[agent][channel].tobytes(), channel
        for channel in TOLD:
            world, found = here[agent][channel].astype(float), there[agent][channel]
            if channel.endswith("velocity"):
                expected = [*turn @ world[:3], *turn @ world[3:]]
            elif channel.endswith("orientation"):
                found, expected = matrix(found), turn @ matrix(world)
            else:
                expected = [*turn @ world[:3] + back.position]
                if found.size == 7:
                    expected += [*(turn @ matrix(world[3:])).ravel()]
                    found = [*found[:3], *matrix(found[3:]).ravel()]
            assert near(found, expected, 1e-5), (agent, channel)
    assert not near(there["right"]["block.pose"], here["right"]["block.pose"], 0.1)


def test_the_state_and_the_reward_know_nothing_of_frames(make):
    envs = [make("handover"), make("handover", frame="base", observe="scene")]
    for env in envs:
        env.reset(seed=3)
    assert envs[0].state().tobytes() == envs[1].state().tobytes()
    assert envs[0].state_space == envs[1].state_space
    idle = {agent: np.zeros(5) for agent in envs[0].agents}
    assert envs[0].step(idle)[1] == envs[1].step(idle)[1]


# --- observe: the whole scene

IN_TOOL = "position in self.tcp"
SCENES = {
    "handover": (
        *("stick.pose", "obstacle.pose"),
        *(f"stick.left_end.{IN_TOOL}", f"stick.right_end.{IN_TOOL}"),
        *(f"goal.{IN_TOOL}", f"meeting.{IN_TOOL}"),
        *("goal.position", "meeting.position"),
    ),
    "collaborative_lift": (
        *("tray.pose", "cube.pose"),
        *(f"tray.left_handle_top.{IN_TOOL}", f"tray.right_handle_top.{IN_TOOL}"),
        *(f"goal.{IN_TOOL}", "goal.position"),
    ),
    "pick_push_place": (
        *("cube.pose", "tray.pose"),
        *(f"cube.middle.{IN_TOOL}", f"tray.grip.{IN_TOOL}"),
        *(f"middle.{IN_TOOL}", f"above_tray.{IN_TOOL}"),
        *("middle.position", "above_tray.position"),
    ),
}


@pytest.mark.parametrize("task", LIBRARY)
def test_the_scene_is_oneself_the_others_all_that_moves_all_sites_and_the_time_left(make, task):
    env = make(task, observe="scene", flat=False)
    views, _ = env.reset(seed=0)
    for agent, other in (("left", "right"), ("right", "left")):
        assert list(views[agent]) == [
            *("self.tcp", "self.gripper", "self.holding"),
            *(f"{other}.tcp", f"{other}.gripper", f"{other}.holding"),
            *SCENES[task],
            "time_left",
        ]
        assert env.observation_space(agent).contains(views[agent])


def test_others_come_in_the_order_of_the_file(make):
    env = make(CROWD, CROWD_DESCRIPTION, observe="scene", flat=False)
    views, _ = env.reset(seed=0)
    for agent, order in (("c", "self a b"), ("a", "self c b"), ("b", "self c a")):
        named = [name for name in views[agent] if " in " not in name]
        tools = [name.partition(".")[0] for name in named if name.endswith(".tcp")]
        assert tools == order.split()


@pytest.mark.parametrize("task", LIBRARY)
def test_whoever_sees_the_scene_sees_each_of_its_parts_move(make, task):
    env = make(task, observe="scene")
    world = env.episode.world
    for name in (*world.robots, *world.movable, *world.sites):
        env.reset(seed=0)
        before = seen(env)
        if name in world.robots:
            robot = world.robots[name]
            robot.body.reset_joints(robot.arm.indices, [0.1 + joint for joint in robot.home])
        elif name in world.objects:
            body = world.objects[name].body
            body.place(body.pose().moved((0.01, 0.02, 0.03)))
        else:
            world.sites[name].pose = world.sites[name].pose.moved((0.01, 0.02, 0.03))
        after = seen(env)
        for agent in env.possible_agents:
            assert after[agent].tobytes() != before[agent].tobytes(), (agent, name)


# --- rotation: matrices


def turning(env: TaskEnv, axis: Vec3, degrees: Any) -> Any:
    """What the left agent sees of a block as it is turned about an axis."""
    body = env.episode.world.objects["block"].body
    at = body.pose().position
    for angle in degrees:
        half = math.radians(angle) / 2.0
        x, y, z = (math.sin(half) * n for n in axis)
        body.place(Pose(at, (x, y, z, math.cos(half))))
        yield seen(env)["left"]


@pytest.mark.parametrize("frame", ["task", "base"])
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.0, -0.8, 0.6)])
def test_a_matrix_does_not_jump_where_a_quaternion_changes_its_sign(make, axis, frame):
    text = facing("left: [block.orientation]", "right: [time_left]")
    degrees = range(0, 721, 5)
    views = {}
    for rotation in ("quaternion", "matrix"):
        env = make(text, rotation=rotation, frame=frame)
        env.reset(seed=0)
        views[rotation] = list(turning(env, axis, degrees))
        assert all(map(env.observation_space("left").contains, views[rotation]))
    steps = {
        rotation: max(np.abs(np.subtract(*pair)).max() for pair in itertools.pairwise(list_))
        for rotation, list_ in views.items()
    }
    assert steps["matrix"] < math.radians(5.0) < 1.0 < steps["quaternion"]
    for numbers, quaternion in zip(views["matrix"], views["quaternion"], strict=True):
        assert near(numbers, columns(quaternion), 1e-6)


def test_a_matrix_stands_where_the_quaternion_stood(make):
    text = facing("left: [self.gripper, block.pose, time_left]", "right: [spot.position]")
    plain, other = (make(text, rotation=rotation) for rotation in ("quaternion", "matrix"))
    for env in (plain, other):
        env.reset(seed=4)
    one, two = (next(turning(env, (0.6, 0.0, 0.8), [50])) for env in (plain, other))
    assert other.observation_space("left").shape == two.shape == (11,)
    assert near(two, [*one[:4], *columns(one[4:8]), 1.0], 1e-6)
    assert seen(other)["right"].tobytes() == seen(plain)["right"].tobytes()
    assert near(other.observation_space("left").low[4:10], np.full(6, -1.0), 0.0)
    assert near(other.observation_space("left").high[4:10], np.ones(6), 0.0)


def test_the_state_has_matrices_too(make):
    text = facing(extra="state: [block.pose, time_left]\n")
    plain, other = (make(text, rotation=rotation) for rotation in ("quaternion", "matrix"))
    for env in (plain, other):
        env.reset(seed=4)
    state = plain.state()
    assert other.state_space.contains(other.state())
    assert near(other.state(), [*state[:3], *columns(state[3:7]), state[7]], 1e-6)


# --- distances on a logarithmic scale


def test_positions_in_the_frame_of_a_tool_alone_are_compressed(make):
    channels = "self.tcp, block.pose, block.pose in self.tcp, block.position in right.tcp"
    text = facing(f"left: [{channels}, spot.position in left.base, time_left]", "right: [self.tcp]")
    plain, other = (make(text, distances=distances) for distances in ("metres", "log"))
    one, two = (env.reset(seed=4)[0]["left"] for env in (plain, other))
    assert other.observation_space("left").contains(two)
    near_tool = [*range(14, 17), *range(21, 24)]
    rest = np.delete(np.arange(len(one)), near_tool)
    assert two[rest].tobytes() == one[rest].tobytes()
    assert near(two[near_tool], np.arcsinh(one[near_tool] / 0.02) / 2.0, 1e-5)
    assert np.all(np.abs(two[near_tool]) < 3.0)
    assert other.observation_names == plain.observation_names


def test_a_millimetre_near_the_tool_is_seen_more_than_one_far_away():
    steps = [compressed(x + 0.001) - compressed(x) for x in (0.0, 0.1, 1.0)]
    assert steps == pytest.approx([0.025, 0.0049, 0.0005], rel=0.03)
    assert compressed(-0.3) == -compressed(0.3)


def test_noise_comes_before_the_scale(make):
    noise = "\nobservation_noise: {left: {block.position in self.tcp: {std: 0.01}}}\n"
    text = facing("left: [block.position in self.tcp]", "right: [self.tcp]", extra=noise)
    one, two = (make(text, distances=d).reset(seed=0)[0]["left"] for d in ("metres", "log"))
    assert near(two, np.arcsinh(one / 0.02) / 2.0, 1e-5)


# --- noise

NOISE = """
observation_noise:
  left:
    self.tcp: {position_std: 0.01, angle_std_deg: 8}
    block.pose: {position_std: 0.02, angle_std_deg: 8}
"""
NOISY = ("left: [self.tcp, block.pose]", "right: [block.pose]")


def test_noise_turns_what_is_seen_before_it_is_told_as_a_matrix(make):
    text = facing(*NOISY, extra=NOISE)
    plain, other = (make(text, rotation=rotation) for rotation in ("quaternion", "matrix"))
    truth = make(facing(*NOISY)).reset(seed=0)[0]["left"]
    one, two = (env.reset(seed=0)[0]["left"] for env in (plain, other))
    for begin in (0, 1):
        vector, told = one[7 * begin :][:7], two[9 * begin :][:9]
        assert near(told, [*vector[:3], *columns(vector[3:])], 1e-6)
        apart = matrix(vector[3:]) @ matrix(truth[7 * begin :][3:7]).T
        assert 0.5 < math.degrees(math.acos(min(1.0, (np.trace(apart) - 1.0) / 2.0))) < 60.0


def test_noise_is_on_the_numbers_that_are_seen_in_whatever_frame(make):
    """With the same draws the right arm's base would turn them, were they drawn in the world."""
    noise = NOISE.replace("left:", "right:")
    lists = ("left: [block.pose]", "right: [self.tcp, block.pose]")
    off = []
    for frame in ("task", "base"):
        noisy, plain = (make(facing(*lists, extra=extra), frame=frame) for extra in (noise, ""))
        views = [env.reset(seed=0)[0]["right"].astype(float) for env in (noisy, plain)]
        off.append(np.subtract(*views)[[0, 1, 2, 7, 8, 9]])
    assert near(off[0], off[1], 1e-6)
    assert np.abs(off[0]).min() > 1e-4


def test_noise_stays_on_what_it_is_on_when_the_scene_is_seen(make):
    noisy, plain = (
        make(facing(*NOISY, extra=extra), observe="scene", flat=False) for extra in (NOISE, "")
    )
    views = [env.reset(seed=0)[0] for env in (noisy, plain)]
    for agent in noisy.possible_agents:
        differ = {
            name
            for name, numbers in views[0][agent].items()
            if numbers.tobytes() != views[1][agent][name].tobytes()
        }
        assert differ == ({"self.tcp", "block.pose"} if agent == "left" else set())


# --- all views, all seeds


_ENVS: dict[str, TaskEnv] = {}


@pytest.fixture(scope="module", autouse=True)
def _closed():
    yield
    while _ENVS:
        _ENVS.popitem()[1].close()


@settings(max_examples=4, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2**31 - 1), scale=st.sampled_from([0.2, 1.0, 50.0]))
@pytest.mark.parametrize("task", LIBRARY)
def test_observations_are_in_their_spaces_in_own_frames_too(task, seed, scale):
    if task not in _ENVS:
        _ENVS[task] = parallel_env(task, horizon=15, variation="random", **LEARNERS)
    env = _ENVS[task]
    views, _ = env.reset(seed=seed)
    rng = np.random.default_rng(seed)
    while True:
        for agent in env.possible_agents:
            assert env.observation_space(agent).contains(views[agent])
        assert env.state_space.contains(env.state())
        if not env.agents:
            return
        views, *_ = env.step({agent: rng.uniform(-scale, scale, 5) for agent in env.agents})


def test_channels_by_name_are_the_vector_one_after_the_other(make):
    flat, split = (make("handover", flat=flat, **LEARNERS) for flat in (True, False))
    vectors, parts = flat.reset(seed=1)[0], split.reset(seed=1)[0]
    for agent in flat.possible_agents:
        shown = parts[agent]
        assert np.concatenate(list(shown.values())).tobytes() == vectors[agent].tobytes()
        sizes = {name: numbers.size for name, numbers in shown.items()}
        assert sizes["self.tcp"] == sizes["stick.pose"] == 9
        assert sizes["goal.position"] == 3
        assert split.observation_space(agent).contains(shown)


def test_the_frame_is_ones_own_in_every_variation(make):
    env = make("handover", variation="random", frame="base")
    variations = set()
    for seed in range(8):
        env.reset(seed=seed)
        variations.add(env.episode.variation)
        before = env.episode.world.pose("right.tcp").position
        forward = {"left": np.zeros(5), "right": np.array([1.0, 0.0, 0.0, 0.0, 0.0])}
        env.step(forward)
        env.step(forward)
        assert env.episode.world.pose("right.tcp").position[0] < before[0] - 0.03
    assert len(variations) > 1


def test_vectors_of_environments_take_the_options():
    envs = make_vec("handover", num_envs=2, horizon=3, **LEARNERS)
    single = parallel_env("handover", horizon=3, **LEARNERS)
    rows, _ = envs.reset(seed=5)
    alone, _ = single.reset(seed=6)
    rng = np.random.default_rng(0)
    for _ in range(2):
        for agent in single.possible_agents:
            assert rows[agent][1].tobytes() == alone[agent].tobytes()
        actions = {agent: rng.uniform(-1, 1, (2, 5)) for agent in single.possible_agents}
        rows, *_ = envs.step(actions)
        alone, *_ = single.step({agent: values[1] for agent, values in actions.items()})
    envs.close()
    single.close()


def test_the_joint_view_takes_the_options():
    env = gymnasium.make("taskbuilder/Handover-v1", disable_env_checker=True, **LEARNERS)
    single = parallel_env("handover", **LEARNERS)
    seen_, _ = env.reset(seed=5)
    apart, _ = single.reset(seed=5)
    assert np.concatenate(list(apart.values())).tobytes() == seen_.tobytes()
    action = np.linspace(-0.5, 0.5, 10)
    seen_, *_ = env.step(action)
    apart, *_ = single.step({"left": action[:5], "right": action[5:]})
    assert np.concatenate(list(apart.values())).tobytes() == seen_.tobytes()
    env.close()
    single.close()
