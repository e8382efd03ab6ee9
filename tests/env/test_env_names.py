"""The names of numbers, and what wrappers and other libraries look for in an environment."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from env_tasks import LIBRARY, arm, facing

import taskbuilder.gym  # noqa: F401  # registers the tasks
from taskbuilder.env.joint import JointEnv

JOINTS = tuple(f"joint_{number}" for number in range(1, 7))

ACTIONS = {
    "arm: tcp_delta, turn: none": ("dx", "dy", "dz"),
    "arm: tcp_delta, turn: yaw": ("dx", "dy", "dz", "dyaw"),
    "arm: tcp_pose, turn: full": ("x", "y", "z", "rx", "ry", "rz"),
    "arm: tcp_path, turn: yaw": ("x", "y", "z", "yaw"),
    "arm: joint_delta": tuple(f"{joint}_delta" for joint in JOINTS),
    "arm: joint_position": JOINTS,
    "arm: joint_velocity": tuple(f"{joint}_velocity" for joint in JOINTS),
    "arm: joint_torque": tuple(f"{joint}_torque" for joint in JOINTS),
}


@pytest.mark.parametrize("task", LIBRARY)
@pytest.mark.parametrize("options", [{}, {"observe": "scene", "frame": "base"}])
@pytest.mark.parametrize("rotation", ["quaternion", "matrix"])
def test_every_number_has_a_name_of_its_own(make, task, options, rotation):
    env = make(task, rotation=rotation, **options)
    named = {**env.observation_names, "state": env.state_names}
    sizes = {agent: env.observation_space(agent).shape for agent in env.possible_agents}
    assert {who: (len(names),) for who, names in named.items()} == {
        **sizes,
        "state": env.state_space.shape,
    }
    assert all(len(set(names)) == len(names) for names in named.values())


@pytest.mark.parametrize(("action", "names"), ACTIONS.items())
def test_actions_are_named_as_their_mode_has_them(make, action, names):
    env = make(arm(action=action))
    assert env.action_names == {"arm": tuple(f"arm.{name}" for name in (*names, "gripper"))}
    assert env.action_space("arm").shape == (len(names) + 1,)


def test_a_named_number_is_what_its_name_says(make):
    observe = "observe: {arm: [self.joints, spot.position in self.tcp, self.previous_action]}\n"
    env = make(arm() + observe)
    names = env.observation_names["arm"]
    assert names[:6] == tuple(f"arm.{joint}" for joint in JOINTS)
    assert names[6:9] == ("spot.x in arm.tcp", "spot.y in arm.tcp", "spot.z in arm.tcp")
    assert names[9] == "arm.previous_dx"
    observations, _ = env.reset(seed=0)
    seen = dict(zip(names, observations["arm"], strict=True))
    joints, _ = env.episode.world.robots["arm"].arm_state()
    assert seen["arm.joint_3"] == np.float32(joints[2])
    inside = env.episode.world.pose("arm.tcp").inverse() @ env.episode.world.pose("spot")
    assert seen["spot.y in arm.tcp"] == np.float32(inside.position[1])


def test_the_joint_view_names_who_observes_and_who_acts(make):
    env = JointEnv("handover")
    assert len(env.observation_names) == env.observation_space.shape[0]
    assert len(set(env.observation_names)) == len(env.observation_names)
    assert env.observation_names[0] == "left/left.tcp.x"
    assert env.action_names[:5] == ("left.dx", "left.dy", "left.dz", "left.dyaw", "left.gripper")
    assert len(env.action_names) == env.action_space.shape[0]
    env.close()


# --- the instruction


def test_the_instruction_is_filled_in_and_drawn_by_the_seed(make):
    env = make("handover", variation=1)
    told = []
    for seed in (*range(12), 0):
        env.reset(seed=seed)
        told.append(env.task_description)
    assert told[0] == told[-1]
    assert 1 < len(set(told)) <= 5
    assert all("green stick" in text and "{" not in text for text in told)


def test_the_instruction_of_a_task_without_any_is_its_summary(make):
    env = make(facing())
    env.reset(seed=0)
    assert env.task_description == env.task.file.spec.summary


def test_the_joint_view_tells_the_instruction_at_reset():
    env = JointEnv("handover")
    for seed in range(3):
        _, info = env.reset(seed=seed)
        assert info["instruction"] == env.task_description
    assert "instruction" not in env.step(env.action_space.sample())[-1]
    env.close()


# --- what wrappers look for


def test_is_success_is_whether_the_episode_has_succeeded(make):
    env = make(arm(steps=3))
    _, infos = env.reset(seed=0)
    assert infos["arm"]["is_success"] == infos["arm"]["succeeded"] == 0.0


@pytest.mark.parametrize("options", [{}, {"horizon": 7}])
def test_the_length_of_episodes_is_where_wrappers_look(options):
    length = options.get("horizon", 50)
    env = gymnasium.make("taskbuilder/Handover-v1", **options)
    assert env.spec.max_episode_steps == length
    assert env.get_wrapper_attr("max_episode_steps") == length
    assert env.get_wrapper_attr("_max_episode_steps") == length
    assert env.get_wrapper_attr("task_description")
    again = gymnasium.make(env.spec)
    again.reset(seed=0)
    for _ in range(length):
        *_, truncated, _ = again.step(again.action_space.sample())
    assert truncated
    env.close()
    again.close()


def test_an_environment_that_gymnasium_did_not_make_has_no_spec():
    env = JointEnv("handover", horizon=9)
    assert env.spec is None
    assert env.max_episode_steps == 9
    env.close()


def test_several_at_once_tell_their_instructions():
    envs = gymnasium.make_vec("taskbuilder/Handover-v1", 2, vectorization_mode="sync")
    _, infos = envs.reset(seed=0)
    assert infos["instruction"].tolist() == list(envs.call("task_description"))
    envs.close()
