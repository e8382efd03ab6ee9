"""What agents see: only what their task lists, and what is there."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from env_tasks import (
    LIBRARY,
    arm,
    digest,
    facing,
    grasp,
    near,
    physical,
    random_actions,
    still,
    tcp,
    towards,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import FileError, UsageError
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import play

EVERYTHING = facing(
    "left:",
    *(
        "- " + channel
        for channel in (
            "self.joints",
            "self.joint_velocities",
            "self.tcp",
            "self.tcp in right.base",
            "self.tcp_velocity",
            "self.gripper",
            "self.holding",
            "self.force",
            "self.previous_action",
            "right.tcp",
            "right.joints",
            "block.pose",
            "block.pose in self.tcp",
            "block.position in right.tcp",
            "block.orientation",
            "block.velocity",
            "block.velocity in self.tcp",
            "other.position",
            "spot.position",
            "spot.position in self.base",
            "ride.pose",
            "time_left",
        )
    ),
    "right: [self.tcp]",
)


def seen(env):
    """What every agent would see now."""
    env.episode.world.refresh()
    return env._observer.observe(env.episode)


def disturb(env, name):
    """Move a robot, an object or a site."""
    world = env.episode.world
    if name in world.robots:
        robot = world.robots[name]
        robot.body.reset_joints(robot.arm.indices, [0.1 + joint for joint in robot.home])
        robot.body.reset_joints(robot.gripper.joints, robot.gripper.positions(0.4))
    elif name in world.objects:
        thing = world.objects[name]
        thing.body.place(thing.body.pose().moved((0.01, 0.02, 0.03)))
    else:
        world.sites[name].pose = world.sites[name].pose.moved((0.01, 0.02, 0.03))


def matrix(quaternion):
    """(3, 3) rotation of a quaternion xyzw."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def relative(frame, pose):
    """Position and rotation of a pose (7,) as seen from another."""
    back = matrix(frame[3:]).T
    return back @ (pose[:3] - frame[:3]), back @ matrix(pose[3:])


def raw_pose(env, name):
    """A body's pose, from the engine: position of the centre of mass, then xyzw."""
    bullet, body = env.episode.world.client.bullet, env.episode.world.objects[name].body
    position, quaternion = bullet.getBasePositionAndOrientation(body.id)
    return np.array((*position, *quaternion))


# --- only what is listed


@pytest.mark.parametrize("task", LIBRARY)
def test_an_agent_sees_what_its_task_lists_and_nothing_else(make, task):
    env = make(task)
    world = env.episode.world
    for agent in env.possible_agents:
        listed = env.task.file.spec.observe[agent]
        subjects = {channel.partition(".")[0] for channel in listed} - {"time_left"}
        subjects = {agent if subject == "self" else subject for subject in subjects}
        for name in (*world.robots, *world.objects, *world.sites):
            env.reset(seed=0)
            before = seen(env)[agent]
            disturb(env, name)
            changed = seen(env)[agent].tobytes() != before.tobytes()
            assert changed == (name in subjects), (agent, name)


def test_an_agent_does_not_see_what_rides_on_what_it_does_not_see(make):
    env = make(facing("left: [ride.position]", "right: [self.tcp, spot.position]"))
    env.reset(seed=0)
    before = seen(env)
    disturb(env, "block")
    after = seen(env)
    assert after["left"].tobytes() != before["left"].tobytes()
    assert after["right"].tobytes() == before["right"].tobytes()


def test_what_the_other_does_changes_nothing_in_what_an_agent_sees(make):
    """As long as it touches nothing: two arms apart, one of them at random."""
    env = make(facing("left: [self.tcp, self.joints]", "right: [self.tcp, self.joints]"))
    views = []
    for sign in (0.0, 1.0):
        env.reset(seed=0)
        own = []
        for _ in range(5):
            actions = still(env)
            actions["left"][:] = (0.3, 0.1, 0.2, 0.5, 1.0)
            actions["right"][:3] = (0.3 * sign, 0.2 * sign, 0.4 * sign)
            own.append(env.step(actions)[0]["left"])
        views.append(np.array(own))
    assert near(*views, 1e-5)


def test_an_agent_without_an_entry_is_refused(make):
    with pytest.raises(FileError, match="right"):
        make(facing("left: [self.tcp]"))


def test_without_a_list_every_agent_sees_itself_and_all_things(make):
    env = make(facing(), flat=False)
    own = ["self.joints", "self.tcp", "self.gripper", "self.holding"]
    things = [
        "post.pose",
        "block.pose",
        "other.pose",
        "spot.position",
        "ride.position",
        "time_left",
    ]
    for agent in env.possible_agents:
        assert set(env.observation_space(agent)) == {*own, *things}


def test_an_agent_may_see_nothing(make):
    env = make(facing("left: []", "right: [self.tcp]"))
    observation, _ = env.reset(seed=0)
    assert observation["left"].shape == (0,)
    assert env.observation_space("left").contains(observation["left"])


# --- what the channels say


@pytest.fixture
def everything(make):
    env = make(EVERYTHING, flat=False)
    env.reset(seed=0)
    return env


def test_poses_are_those_of_the_engine(everything):
    env = everything
    rng = np.random.default_rng(0)
    for _ in range(5):
        actions = {agent: rng.uniform(-0.4, 0.4, 5) for agent in env.agents}
        parts = {a: {"arm": v[:-1], "gripper": v[-1:]} for a, v in actions.items()}
        views, *_ = env.step(parts)
    found = views["left"]
    block = raw_pose(env, "block")
    assert near(found["block.pose"][:3], block[:3], 1e-6)
    assert near(matrix(found["block.pose"][3:]), matrix(block[3:]), 1e-5)
    assert near(matrix(found["block.orientation"]), matrix(block[3:]), 1e-5)
    assert near(found["other.position"], raw_pose(env, "other")[:3], 1e-6)
    assert near(found["spot.position"], env.episode.world.sites["spot"].pose.position, 1e-6)
    robot = env.episode.world.robots["left"]
    link = env.episode.world.client.bullet.getLinkState(
        robot.body.id, robot.body.links["tcp"], computeForwardKinematics=True
    )
    assert near(found["self.tcp"][:3], link[4], 1e-6)
    assert near(matrix(found["self.tcp"][3:]), matrix(link[5]), 1e-5)
    assert near(found["self.joints"], robot.arm_state()[0], 1e-6)
    other = env.episode.world.robots["right"].arm_state()[0]
    assert near(found["right.joints"], other, 1e-6)
    assert near(found["right.tcp"], views["right"]["self.tcp"], 0.0)


def test_poses_in_a_frame_are_as_seen_from_there(everything):
    env = everything
    actions = {
        a: {"arm": np.array([0.3, 0.5, 0.8, 0.9]), "gripper": np.zeros(1)} for a in env.agents
    }
    for _ in range(4):
        found = env.step(actions)[0]["left"]
    own, other, block = found["self.tcp"], found["right.tcp"], found["block.pose"]
    position, turned = relative(own, block)
    assert near(found["block.pose in self.tcp"][:3], position, 1e-5)
    assert near(matrix(found["block.pose in self.tcp"][3:]), turned, 1e-5)
    assert near(found["block.position in right.tcp"], relative(other, block)[0], 1e-5)
    right_base = np.array((0.6, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0))
    position, turned = relative(right_base, own)
    assert near(found["self.tcp in right.base"][:3], position, 1e-5)
    assert near(matrix(found["self.tcp in right.base"][3:]), turned, 1e-5)
    assert near(found["spot.position in self.base"], found["spot.position"] + (0.6, 0.0, 0.0), 1e-5)
    above = block[:3] + matrix(block[3:]) @ (0.0, 0.0, 0.1)
    assert near(found["ride.pose"][:3], above, 1e-5)
    turned = matrix(own[3:]).T
    linear, angular = np.split(found["block.velocity"], 2)
    expected = np.concatenate([turned @ linear, turned @ angular])
    assert near(found["block.velocity in self.tcp"], expected, 1e-5)


def test_of_two_quaternions_the_one_with_w_at_least_0_is_shown(make):
    """And never the other for a moment: also where w passes zero."""
    env = make(
        facing("left: [self.tcp, block.orientation]", "right: [self.tcp]", action="turn: full")
    )
    env.reset(seed=0)
    body = env.episode.world.objects["block"].body
    for angle in np.linspace(0.0, 2.0 * math.pi, 25):
        pose = body.pose()
        quaternion = (0.0, math.sin(angle / 2), 0.0, math.cos(angle / 2))
        body.place(type(pose)(pose.position, quaternion))
        found = seen(env)["left"][-4:]
        assert found[3] >= 0.0
        assert near(matrix(found), matrix(quaternion), 1e-5)
        assert env.observation_space("left").contains(seen(env)["left"])


def test_velocities_are_what_positions_change_by(make):
    text = facing(
        "left: [other.velocity, other.position, self.tcp_velocity, self.tcp, "
        "self.joint_velocities, self.joints]",
        "right: [self.tcp]",
    )
    env = make(text, control_hz=120, flat=False, horizon=200)
    env.reset(seed=0)
    world = env.episode.world
    body = world.objects["other"].body
    body.place(body.pose().moved((0.0, 0.0, 1.0)))
    world.client.bullet.resetBaseVelocity(body.id, (0.3, -0.2, 1.0), (1.0, 2.0, 3.0))
    push = {"arm": np.array([0.24, 0.36, 0.6, 0.6]), "gripper": np.zeros(1)}
    views = [env.step({"left": push, "right": push})[0]["left"] for _ in range(30)]
    for before, after in itertools.pairwise(views):
        for channel, speed in (
            ("other.position", after["other.velocity"][:3]),
            ("self.joints", after["self.joint_velocities"]),
        ):
            assert near((after[channel] - before[channel]) * 120.0, speed, 2e-3)
        moved = (after["self.tcp"][:3] - before["self.tcp"][:3]) * 120.0
        assert near(moved, after["self.tcp_velocity"][:3], 0.02)
        between = matrix(after["self.tcp"][3:]) @ matrix(before["self.tcp"][3:]).T
        turn = np.array(
            [
                between[2, 1] - between[1, 2],
                between[0, 2] - between[2, 0],
                between[1, 0] - between[0, 1],
            ]
        )
        assert near(turn / 2.0 * 120.0, after["self.tcp_velocity"][3:], 0.02)
    assert np.linalg.norm(views[-1]["self.tcp_velocity"][:3]) > 0.1
    assert near(views[-1]["other.velocity"][3:], (1.0, 2.0, 3.0), 0.2)


def test_gripper_holding_and_forces_tell_of_a_grasp(make):
    text = facing("left: [self.gripper, self.holding, self.force]", "right: [self.holding]")
    env = make(text, flat=False)
    first, _ = env.reset(seed=0)
    assert first["left"]["self.gripper"] == pytest.approx(1.0, abs=0.01)
    assert first["left"]["self.holding"] == 0.0
    assert near(first["left"]["self.force"], (0.0, 0.0), 0.0)
    close = {"arm": np.zeros(4), "gripper": -np.ones(1)}
    idle = {"arm": np.zeros(4), "gripper": np.zeros(1)}
    for _ in range(5):
        views, *_ = env.step({"left": close, "right": idle})
    assert views["left"]["self.gripper"] == pytest.approx(0.04 / 0.085, abs=0.03)
    assert views["left"]["self.holding"] == 1.0
    assert near(views["left"]["self.force"], (20.0, 20.0), 4.0)
    assert views["right"]["self.holding"] == 0.0
    for _ in range(5):
        views, *_ = env.step({"left": {"arm": np.zeros(4), "gripper": np.ones(1)}, "right": close})
    assert views["left"]["self.holding"] == 0.0
    assert views["left"]["self.gripper"] == pytest.approx(1.0, abs=0.03)


def test_a_drawer_that_is_held_is_felt(make):
    env = make("open_drawer")
    expert = Expert(env)
    robot = env.possible_agents[0]
    felt = []

    def look(env):
        world = env.episode.world
        held = world.held("cabinet.drawer", robot)
        felt.append((held, env.episode.holding(robot), max(env.episode.forces(robot))))

    assert play(env, expert, 0, watch=look).success
    expert.close()
    assert any(held for held, _, _ in felt)
    assert all(held == holding for held, holding, _ in felt)
    assert all(force > 5.0 for held, _, force in felt if held)


@pytest.mark.parametrize("normalize", [True, False])
def test_the_previous_action_is_shown_from_minus_1_to_1(make, normalize):
    env = make(facing("left: [self.previous_action]", "right: [time_left]"), normalize=normalize)
    first, _ = env.reset(seed=0)
    assert not first["left"].any()
    space = env.action_space("left")
    views, *_ = env.step({"left": space.high, "right": space.low})
    assert near(views["left"], np.ones(5), 1e-6)
    middle = (space.high + space.low) / 2.0 + 0.25 * (space.high - space.low)
    views, *_ = env.step({"left": middle, "right": space.low})
    assert near(views["left"], np.full(5, 0.5), 1e-6)
    views, *_ = env.step({"left": space.low * 7.0, "right": space.low})
    assert near(views["left"], -np.ones(5), 1e-6)
    again, _ = env.reset(seed=0)
    assert not again["left"].any()


def test_an_action_array_that_is_used_again_does_not_change_what_was_done(make):
    env = make(facing("left: [self.previous_action]", "right: [time_left]"))
    env.reset(seed=0)
    action = np.full(5, 0.25)
    env.step({"left": action, "right": action})
    action[:] = 0.75
    assert near(seen(env)["left"], np.full(5, 0.25), 1e-6)


def test_the_time_left_runs_from_1_to_0(make):
    env = make(facing("left: [time_left]", "right: [time_left]"), horizon=4)
    observation, _ = env.reset(seed=0)
    shown = [observation["left"][0]]
    while env.agents:
        shown.append(env.step(still(env))[0]["left"][0])
    assert shown == [1.0, 0.75, 0.5, 0.25, 0.0]


DRAWER = """<?xml version="1.0"?>
<robot name="drawer">
  <link name="case">
    <inertial>
      <mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision><geometry><box size="0.3 0.3 0.02"/></geometry></collision>
  </link>
  <link name="tray">
    <inertial>
      <mass value="0.2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision><origin xyz="0 0 0.05"/><geometry><box size="0.2 0.2 0.02"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic">
    <parent link="case"/><child link="tray"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.2" effort="10" velocity="1"/>
  </joint>
</robot>
"""


def test_a_joint_of_an_articulated_object_is_a_channel(make):
    text = facing("left: [drawer.slide, drawer.tray.pose]", "right: [time_left]", extra="")
    thing = (
        "    drawer: {shape: {urdf: drawer.urdf}, fixed: true, position: [1, 1, 0.02], "
        "joints: {slide: 0.12}}\n"
    )
    env = make(text.replace("  sites:", thing + "  sites:"), files={"drawer.urdf": DRAWER})
    observation, _ = env.reset(seed=0)
    assert observation["left"][0] == pytest.approx(0.12, abs=2e-3)
    assert near(observation["left"][1:4], (1.12, 1.0, 0.02), 3e-3)


# --- form


@settings(max_examples=12, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2**31 - 1), scale=st.sampled_from([0.2, 1.0, 50.0]))
@pytest.mark.parametrize("task", LIBRARY)
def test_observations_are_in_their_spaces_whatever_is_done(task, seed, scale):
    env = _kept(task)
    views, _ = env.reset(seed=seed)
    rng = np.random.default_rng(seed)
    while True:
        for agent in env.possible_agents:
            assert env.observation_space(agent).contains(views[agent])
        assert env.state_space.contains(env.state())
        if not env.agents:
            return
        actions = {agent: rng.uniform(-scale, scale, 5) for agent in env.agents}
        views, rewards, *_ = env.step(actions)
        assert all(math.isfinite(reward) for reward in rewards.values())


_ENVS = {}


def _kept(task):
    if task not in _ENVS:
        _ENVS[task] = parallel_env(task, horizon=25)
    return _ENVS[task]


@pytest.fixture(scope="module", autouse=True)
def _closed():
    yield
    while _ENVS:
        _ENVS.popitem()[1].close()


@pytest.mark.parametrize("flat", [True, False])
def test_arrays_are_never_used_again(make, flat):
    env = make(facing(), flat=flat)
    actions = random_actions(make(facing()), 0, 3)
    kept = [env.reset(seed=0)[0]]
    for action in actions:
        parts = (
            action if flat else {a: {"arm": v[:-1], "gripper": v[-1:]} for a, v in action.items()}
        )
        kept.append(env.step(parts)[0])
    arrays = [
        array
        for views in kept
        for view in views.values()
        for array in (view.values() if isinstance(view, dict) else [view])
    ]
    arrays += [env.state(), env.state()]
    for number, array in enumerate(arrays):
        assert array.flags.writeable
        assert not any(np.shares_memory(array, other) for other in arrays[:number])


def test_writing_into_an_observation_changes_nothing_in_the_environment(make):
    env, twin = make(facing()), make(facing())
    env.reset(seed=0)[0]["left"][:] = 7.0
    twin.reset(seed=0)
    env.state()[:] = 7.0
    for action in random_actions(env, 0, 3):
        mine, theirs = env.step(action)[0], twin.step(action)[0]
        assert mine["left"].tobytes() == theirs["left"].tobytes()
        mine["left"][:] = 7.0
    assert env.state().tobytes() == twin.state().tobytes()


@pytest.mark.parametrize("task", [*LIBRARY, "made"])
def test_the_flat_vector_is_the_channels_one_after_the_other(make, task):
    text = EVERYTHING if task == "made" else task
    flat, split = make(text), make(text, flat=False)
    vectors, _ = flat.reset(seed=2)
    parts, _ = split.reset(seed=2)
    for action in random_actions(flat, 0, 4):
        vectors, *_ = flat.step(action)
        apart = {a: {"arm": v[:-1], "gripper": v[-1:]} for a, v in action.items()}
        parts, *_ = split.step(apart)
    for agent in flat.possible_agents:
        channels = flat.task.file.spec.observe[agent]
        joined = np.concatenate([parts[agent][channel] for channel in channels])
        assert joined.tobytes() == vectors[agent].tobytes()
        spaces = split.observation_space(agent)
        low = np.concatenate([spaces[channel].low for channel in channels])
        high = np.concatenate([spaces[channel].high for channel in channels])
        assert near(flat.observation_space(agent).low, low, 0.0)
        assert near(flat.observation_space(agent).high, high, 0.0)


# --- the critic's state


def test_the_state_is_what_the_task_lists_for_it(make):
    env = make(facing(extra="state: [block.position, left.tcp, time_left]\n"))
    observation, _ = env.reset(seed=0)
    assert env.state_space.shape == (11,)
    world = env.episode.world
    assert near(env.state()[:3], world.position("block"), 1e-6)
    assert near(env.state()[3:6], world.position("left.tcp"), 1e-6)
    assert env.state()[-1] == 1.0
    assert env.state().dtype == observation["left"].dtype == np.float32


def test_the_whole_state_tells_of_everything_that_moves(make):
    env = make(facing())
    world = env.episode.world
    for name in (*world.robots, *world.movable, *world.sites):
        env.reset(seed=0)
        before = env.state()
        disturb(env, name)
        world.refresh()
        assert env.state().tobytes() != before.tobytes(), name


def test_looking_at_the_state_changes_nothing(make):
    env = make(facing())
    env.reset(seed=0)
    before = digest(physical(env))
    first = env.state()
    assert env.state().tobytes() == first.tobytes()
    assert digest(physical(env)) == before


# --- noise


NOISE = """
observation_noise:
  left:
    block.position: {position_std: 0.01}
    self.tcp: {position_std: 0.004, angle_std_deg: 3}
    self.joints: {std: 0.02}
"""
SEEN = ("left: [self.joints, self.tcp, block.position, spot.position]", "right: [block.position]")


@pytest.fixture
def noisy_and_plain(make):
    return [make(facing(*SEEN, extra=noise), horizon=400) for noise in (NOISE, "")]


def test_noise_has_the_spread_that_the_task_says(noisy_and_plain):
    noisy, plain = noisy_and_plain
    for env in noisy_and_plain:
        env.reset(seed=0)
    views, truths = [], []
    while noisy.agents:
        action = still(noisy)
        views.append(noisy.step(action)[0]["left"])
        truths.append(plain.step(action)[0]["left"])
    views, truths = np.array(views, dtype=np.float64), np.array(truths, dtype=np.float64)
    off = views - truths
    for part, std in ((slice(0, 6), 0.02), (slice(6, 9), 0.004), (slice(13, 16), 0.01)):
        assert off[:, part].std() == pytest.approx(std, rel=0.1)
        assert abs(off[:, part].mean()) < 0.1 * std
    assert not off[:, 16:].any()
    turns = []
    for view, truth in zip(views, truths, strict=True):
        between = matrix(view[9:13]) @ matrix(truth[9:13]).T
        turns.append((between[2, 1] - between[1, 2], between[0, 2] - between[2, 0]))
        assert np.linalg.norm(view[9:13]) == pytest.approx(1.0, abs=1e-5)
        assert view[12] >= 0.0
    assert np.degrees(np.std(turns) / 2.0) == pytest.approx(3.0, rel=0.1)


def test_noise_is_drawn_anew_for_every_step_and_episode_and_repeats_with_the_seed(noisy_and_plain):
    noisy, _ = noisy_and_plain
    shown = {}
    for seed in (0, 1, 0):
        views = [noisy.reset(seed=seed)[0]["left"]]
        views += [noisy.step(still(noisy))[0]["left"] for _ in range(3)]
        stack = np.array(views)
        assert len({view[:6].tobytes() for view in views}) == 4
        if seed in shown:
            assert shown[seed].tobytes() == stack.tobytes()
        assert all(
            not near(stack[:, :6], other[:, :6], 1e-6) for s, other in shown.items() if s != seed
        )
        shown[seed] = stack


def test_noise_moves_nothing_and_reaches_only_whom_it_is_meant_for(noisy_and_plain):
    noisy, plain = noisy_and_plain
    for seed in range(3):
        views = [env.reset(seed=seed)[0] for env in noisy_and_plain]
        assert digest(physical(noisy)) == digest(physical(plain))
        for action in random_actions(noisy, seed, 3):
            views = [env.step(action)[0] for env in noisy_and_plain]
        assert views[0]["right"].tobytes() == views[1]["right"].tobytes()
        assert digest(physical(noisy)) == digest(physical(plain))
        assert noisy.state().tobytes() == plain.state().tobytes()


def test_noise_on_positions_may_be_added_to_that_of_the_task(make):
    noisy, plain = (
        make(facing(*SEEN, extra=NOISE), horizon=400, position_noise=std) for std in (0.003, 0.0)
    )
    offs = []
    for env in (noisy, plain):
        env.reset(seed=0)
    exact = make(facing(*SEEN), horizon=400)
    exact.reset(seed=0)
    while exact.agents:
        action = still(exact)
        truth = exact.step(action)[0]["left"]
        offs.append([env.step(action)[0]["left"] - truth for env in (noisy, plain)])
        assert digest(physical(noisy)) == digest(physical(exact))
    with_more, with_own = np.array(offs, dtype=np.float64).transpose(1, 0, 2)
    for part, own in ((slice(6, 9), 0.004), (slice(13, 16), 0.01), (slice(16, 19), 0.0)):
        assert with_more[:, part].std() == pytest.approx(np.hypot(own, 0.003), rel=0.1)
        assert with_own[:, part].std() == pytest.approx(own, rel=0.1)
    assert with_more[:, :6].std() == pytest.approx(0.02, rel=0.1)  # joints have the task's alone
    assert noisy.state().tobytes() == exact.state().tobytes()


@pytest.mark.parametrize("std", [-0.1, 1.5, float("nan")])
def test_noise_on_positions_has_a_size(make, std):
    with pytest.raises(UsageError, match=r"position_noise is .*; 0 to 1, in metres"):
        make("handover", position_noise=std)


def test_noise_does_not_leave_the_space(make):
    noise = "observation_noise: {left: {self.gripper: {std: 3}, time_left: {std: 2}}}\n"
    env = make(facing("left: [self.gripper, time_left]", "right: [time_left]", extra=noise))
    for seed in range(20):
        assert env.observation_space("left").contains(env.reset(seed=seed)[0]["left"])


def test_a_reach_above_the_table_is_seen_as_done(make):
    env = make("handover")
    env.reset(seed=0)
    goal = env.episode.world.position("stick.left_end")
    for _ in range(12):
        views, *_ = env.step(towards(env, {"left": (*goal[:2], goal[2] + 0.1)}, {}))
    assert near(views["left"][:3], (*goal[:2], goal[2] + 0.1), 3e-3)
    assert tcp(env, "left").position[2] > 0.4
    grasp(env, {"left": "stick.left_end"})
    assert env.episode.world.held("stick", "left")


def test_one_arm_alone_is_a_task_like_any_other(make):
    env = make(arm())
    views, _ = env.reset(seed=0)
    assert list(views) == ["arm"]
