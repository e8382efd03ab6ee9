"""What environments refuse: with an error that says who and what, and nothing has changed."""

from __future__ import annotations

import math

import gymnasium
import numpy as np
import pytest
from env_tasks import digest, facing, moment, play, random_actions, still

import taskbuilder.gym  # noqa: F401  # registers the tasks
from taskbuilder.env.errors import ActionError, AgentError, EpisodeOverError
from taskbuilder.env.joint import JointEnv
from taskbuilder.errors import TaskbuilderError, UnknownNameError, UsageError

FINE = np.zeros(5)


def with_number(value):
    wrong = FINE.copy()
    wrong[2] = value
    return wrong


BAD_ACTIONS = {
    "not a number": with_number(math.nan),
    "infinite": with_number(math.inf),
    "minus infinity": with_number(-math.inf),
    "float32 nan": np.full(5, np.nan, dtype=np.float32),
    "too short": np.zeros(4),
    "too long": np.zeros(6),
    "two dimensions": np.zeros((1, 5)),
    "a number": 0.5,
    "nothing": None,
    "list with nothing": [None] * 5,
    "text": "hello",
    "list of text": ["0.1", "0.1", "0.1", "0.1", "0.1"],
    "bytes": np.array([b"1"] * 5),
    "ragged": [[1.0], [1.0, 2.0], 1.0, 1.0, 1.0],
    "object": object(),
    "objects": np.array([object()] * 5),
    "mapping": {"arm": np.zeros(4), "gripper": np.zeros(1)},
    "set": {1.0, 2.0, 3.0, 4.0, 5.0},
    "complex": np.full(5, 1.0 + 2.0j),
    "dates": np.full(5, np.datetime64("2020-01-01")),
    "empty": np.zeros(0),
}

BAD_PARTS = {
    "flat": np.zeros(5),
    "without gripper": {"arm": np.zeros(4)},
    "one too many": {"arm": np.zeros(4), "gripper": np.zeros(1), "base": np.zeros(1)},
    "arm too long": {"arm": np.zeros(5), "gripper": np.zeros(1)},
    "gripper not a number": {"arm": np.zeros(4), "gripper": np.array([math.nan])},
    "gripper a number": {"arm": np.zeros(4), "gripper": 1.0},
    "nothing": None,
    "text": "arm",
}


def steps_like(env, twin, actions):
    """Whether both environments go on alike."""
    return play(env, actions) == play(twin, actions) and digest(moment(env)) == digest(moment(twin))


@pytest.fixture
def pair(make):
    """Two environments in the same moment, one to be abused."""
    envs = [make(facing()) for _ in range(2)]
    for env in envs:
        env.reset(seed=0)
        env.step(random_actions(env, 0, 1)[0])
    return envs


@pytest.mark.parametrize("agent", ["left", "right"])
@pytest.mark.parametrize("kind", BAD_ACTIONS)
def test_an_action_that_is_not_in_the_space_is_refused(pair, kind, agent):
    env, twin = pair
    before = digest(moment(env))
    actions = still(env) | {agent: BAD_ACTIONS[kind]}
    with pytest.raises(ActionError, match=f"the action of {agent} .*must be in Box") as caught:
        env.step(actions)
    assert caught.value.agent == agent
    assert caught.value.space is env.action_space(agent)
    assert isinstance(caught.value, TaskbuilderError)
    assert digest(moment(env)) == before
    assert steps_like(env, twin, random_actions(env, 1, 3))


@pytest.mark.parametrize("kind", BAD_PARTS)
def test_an_action_in_parts_that_is_not_in_the_space_is_refused(make, kind):
    env = make(facing(), flat=False)
    env.reset(seed=0)
    before = digest(moment(env))
    fine = {"arm": np.zeros(4), "gripper": np.zeros(1)}
    with pytest.raises(ActionError, match="the action of right") as caught:
        env.step({"left": fine, "right": BAD_PARTS[kind]})
    assert caught.value.agent == "right"
    assert digest(moment(env)) == before
    env.step({"left": fine, "right": fine})


@pytest.mark.parametrize(
    "action",
    [FINE.astype(np.float32), FINE.astype(int), FINE.tolist(), tuple(FINE), FINE.astype(bool)],
    ids=["float32", "int", "list", "tuple", "bool"],
)
def test_numbers_of_any_kind_will_do(pair, action):
    env, twin = pair
    for one, value in ((env, action), (twin, FINE)):
        one.step({"left": value, "right": value})
    assert digest(moment(env)) == digest(moment(twin))


AGENTS = {
    "nobody": ({}, "no action for left, right"),
    "one is missing": ({"left": FINE}, "no action for right"),
    "one too many": ({"left": FINE, "right": FINE, "middle": FINE}, "no agent middle"),
    "misspelt": ({"left": FINE, "rihgt": FINE}, "no action for right; no agent rihgt"),
    "by number": ({0: FINE, 1: FINE}, "no agent 0, 1"),
}


@pytest.mark.parametrize("kind", AGENTS)
def test_actions_for_other_agents_are_refused(pair, kind):
    env, twin = pair
    actions, message = AGENTS[kind]
    before = digest(moment(env))
    with pytest.raises(AgentError, match=message) as caught:
        env.step(actions)
    assert "the agents are left, right" in str(caught.value)
    assert digest(moment(env)) == before
    assert steps_like(env, twin, random_actions(env, 1, 3))


@pytest.mark.parametrize("actions", [None, 3, "left", [FINE, FINE]])
def test_actions_that_are_no_mapping_are_refused(pair, actions):
    env, twin = pair
    with pytest.raises(AgentError, match="left, right"):
        env.step(actions)
    assert steps_like(env, twin, random_actions(env, 1, 3))


def test_a_step_before_the_first_reset_is_refused(make):
    env, twin = make(facing()), make(facing())
    with pytest.raises(EpisodeOverError, match="reset"):
        env.step({"left": FINE, "right": FINE})
    for one in (env, twin):
        one.reset(seed=0)
    assert steps_like(env, twin, random_actions(env, 1, 3))


def test_a_step_after_the_end_is_refused(make):
    env, twin = make(facing(), horizon=2), make(facing(), horizon=2)
    for one in (env, twin):
        one.reset(seed=0)
        while one.agents:
            one.step(still(one))
    before = digest(moment(env))
    for actions in ({"left": FINE, "right": FINE}, {}):
        with pytest.raises(EpisodeOverError, match="reset"):
            env.step(actions)
    assert digest(moment(env)) == before
    for one in (env, twin):
        one.reset()
    # the seeds of the two come from one generator each, seeded alike
    assert steps_like(env, twin, random_actions(env, 1, 2))


def test_there_is_nothing_to_save_before_the_first_reset(make):
    with pytest.raises(UsageError, match="reset"):
        make(facing()).save_state()


@pytest.mark.parametrize("call", ["reset", "step", "state", "render", "save_state", "load_state"])
def test_a_closed_environment_refuses_everything_but_being_closed(make, call):
    env = make(facing(), render_mode="rgb_array")
    env.reset(seed=0)
    state = env.save_state()
    env.close()
    arguments = {"step": ({"left": FINE, "right": FINE},), "load_state": (state,)}.get(call, ())
    with pytest.raises(UsageError, match=r"closed|reset"):
        getattr(env, call)(*arguments)
    env.close()
    assert env.agents == []
    assert env.action_space("left").shape == (5,)


@pytest.mark.parametrize("seed", [-1, 1.5, "three"])
def test_a_seed_that_is_none_is_refused_and_nothing_has_changed(pair, seed):
    env, twin = pair
    before = digest(moment(env))
    with pytest.raises((UsageError, ValueError, TypeError)):
        env.reset(seed=seed)
    assert digest(moment(env)) == before
    assert steps_like(env, twin, random_actions(env, 1, 3))


# --- the joint view


@pytest.mark.parametrize("kind", [kind for kind in BAD_ACTIONS if kind != "mapping"])
def test_the_joint_view_refuses_what_is_not_in_its_space(kind):
    env = JointEnv("handover")
    env.reset(seed=0)
    bad = BAD_ACTIONS[kind]
    if isinstance(bad, np.ndarray) and bad.shape == (5,):
        bad = np.concatenate([bad, bad])
    elif isinstance(bad, list):
        bad = bad + bad
    before = digest(moment(env.parallel))
    with pytest.raises(ActionError, match=r"the action of .* must be in Box"):
        env.step(bad)
    assert digest(moment(env.parallel)) == before
    env.close()


@pytest.mark.parametrize("bad", [None, np.zeros(10), "left", {"left": FINE}, [FINE, FINE]])
def test_the_joint_view_in_parts_refuses_what_is_not_in_its_space(bad):
    env = JointEnv("handover", flat=False)
    env.reset(seed=0)
    before = digest(moment(env.parallel))
    with pytest.raises((ActionError, AgentError)):
        env.step(bad)
    assert digest(moment(env.parallel)) == before
    env.step(env.action_space.sample())
    env.close()


def test_gymnasium_is_told_of_a_task_that_is_not_there():
    with pytest.raises(UnknownNameError, match="handover"):
        gymnasium.make("taskbuilder/Task-v0", task="handovr")


# --- options


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"reward": "teem"}, 'did you mean "team"'),
        ({"horizon": 0}, "horizon is 0"),
        ({"horizon": 2.5}, "horizon is 2.5"),
        ({"control_hz": -1}, "control_hz is -1"),
        ({"control_hz": 7}, "does not divide physics_hz 120 of made; 6 does"),
        ({"variation": 3}, "variation is 3"),
        ({"variation": "some"}, "variation is 'some'"),
        ({"cameras": ("nowhere",)}, "nowhere"),
        ({"camera_size": (0, 10)}, "camera_size"),
        ({"observe": "scen"}, 'observe "scen": did you mean "scene"'),
        ({"frame": "world"}, 'frame "world": one of: task, base'),
        ({"rotation": "matrx"}, 'rotation "matrx": did you mean "matrix"'),
        ({"rotation": None}, 'rotation "None": one of: quaternion, matrix'),
        ({"renderer": "crayon"}, "crayon"),
        ({"render_mode": "human"}, "human"),
        ({"horizn": 5}, "horizn"),
    ],
)
def test_an_option_that_does_not_fit_is_refused(make, options, message):
    with pytest.raises(UsageError, match=message):
        make(facing(), **options)
