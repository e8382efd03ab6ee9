"""The environments of all tasks against the checks that PettingZoo and Gymnasium ship."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import gymnasium
import numpy as np
import pytest
from env_tasks import LIBRARY, arm, facing, write_task
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, render_test, seed_test
from pettingzoo.test.state_test import test_state as check_state
from pettingzoo.test.state_test import test_state_space as check_state_space
from pettingzoo.utils.conversions import parallel_to_aec

import taskbuilder
import taskbuilder.gym
from taskbuilder.env.joint import JointEnv
from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import UsageError

# What the checks warn of although it is meant; everything else they say is an error.
EXCUSED = {
    "We recommend agents to be named in the format": "agents bear the names of the task's robots",
    "Agents have different observation space sizes": "agents see what their task lets them see",
    "Observations are different shapes": "likewise",
    "The observation contains negative numbers and is in the shape of a graphical": "never so here",
}
EXCUSED_UNNORMALISED = {
    "For Box action spaces, we recommend using a symmetric and normalized space": "physical units",
}
EXCUSED_DICT = {
    "Observation is not a NumPy array": "asked for as a dictionary",
    "Observation space for each agent probably should be": "likewise",
    "Action space for each agent probably should be": "likewise",
}
ID = {name: f"taskbuilder/{name.title().replace('_', '')}-v1" for name in LIBRARY}


@contextmanager
def excusing(*excused: dict[str, str]) -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for reasons in excused:
            for message in reasons:
                warnings.filterwarnings("ignore", message=f".*{message}")
        yield


# --- PettingZoo


@pytest.mark.parametrize("flat", [True, False])
@pytest.mark.parametrize("task", LIBRARY)
class TestPettingZoo:
    def test_the_parallel_api_is_as_it_should_be(self, task, flat):
        with excusing():
            env = parallel_env(task, flat=flat)
            parallel_api_test(env, num_cycles=120)
            env.close()

    def test_two_environments_with_one_seed_go_alike(self, task, flat):
        with excusing():
            parallel_seed_test(lambda: parallel_env(task, flat=flat), num_cycles=60)

    def test_the_turn_based_view_is_as_it_should_be(self, task, flat):
        with excusing(EXCUSED, {} if flat else EXCUSED_DICT):
            env = parallel_to_aec(parallel_env(task, flat=flat))
            api_test(env, num_cycles=110)
            env.close()

    def test_two_turn_based_views_with_one_seed_go_alike(self, task, flat):
        with excusing():
            seed_test(lambda: parallel_to_aec(parallel_env(task, flat=flat)), num_cycles=60)

    def test_its_state_is_in_its_space(self, task, flat):
        with excusing():
            env = parallel_env(task, flat=flat)
            check_state_space(env)
            check_state(parallel_to_aec(env), 60)
            env.reset(seed=1)
            assert env.state().dtype == np.float32
            assert env.state_space.contains(env.state())
            env.close()


@pytest.mark.parametrize("task", LIBRARY)
def test_it_renders_as_it_should(task):
    def make(render_mode):
        # the check asks for a window first, and throws that environment away
        mode = None if render_mode == "human" else render_mode
        return parallel_to_aec(parallel_env(task, render_mode=mode))

    with excusing():
        render_test(make)


def test_a_render_mode_that_is_not_there_is_refused():
    with pytest.raises(UsageError, match="rgb_array"):
        parallel_env("handover", render_mode="human")


def test_without_a_render_mode_there_is_no_picture(make):
    env = make(arm())
    env.reset(seed=0)
    assert env.render() is None


def test_spaces_are_the_same_objects_at_every_call(make):
    env = make(facing())
    for agent in env.possible_agents:
        assert env.observation_space(agent) is env.observation_space(agent)
        assert env.action_space(agent) is env.action_space(agent)


@pytest.mark.parametrize("flat", [True, False])
def test_spaces_can_be_pickled_and_copied(make, flat):
    env = make(facing(), flat=flat)
    for agent in env.possible_agents:
        for space in (env.observation_space(agent), env.action_space(agent), env.state_space):
            for twin in (pickle.loads(pickle.dumps(space)), copy.deepcopy(space)):
                assert twin == space
                assert space.contains(twin.sample())


def test_agents_are_the_robots_in_file_order(make):
    text = facing()
    swapped = text.replace("    left:", "    middle:").replace("    right:", "    left:")
    env = make(swapped.replace("    middle:", "    right:"))
    assert env.possible_agents == ["right", "left"]
    assert env.agents == []
    env.reset(seed=0)
    assert env.agents == ["right", "left"]


# --- Gymnasium


@pytest.mark.parametrize(
    "options", [{}, {"flat": False}, {"normalize": False}], ids=["flat", "dict", "physical"]
)
@pytest.mark.parametrize("task", LIBRARY)
def test_the_joint_view_is_as_it_should_be(task, options):
    with excusing({} if options.get("normalize", True) else EXCUSED_UNNORMALISED):
        env = gymnasium.make(ID[task], disable_env_checker=True, **options)
        check_env(env.unwrapped)
        env.close()


def test_gymnasium_makes_a_task_from_a_path(tmp_path):
    path = write_task(tmp_path, facing())
    with excusing():
        env = gymnasium.make("taskbuilder/Task-v0", task=str(path), horizon=7)
        env.reset(seed=0)
        steps = 1
        while not env.step(env.action_space.sample())[3]:
            steps += 1
        assert steps == 7
        check_env(env.unwrapped, skip_render_check=True)
        env.close()


def test_gymnasium_makes_a_task_by_name():
    with excusing():
        env = gymnasium.make("taskbuilder/Task-v0", task="handover", render_mode="rgb_array")
        env.reset(seed=0)
        assert env.render().dtype == np.uint8
        assert env.metadata["render_fps"] == 10
        assert isinstance(env.unwrapped, JointEnv)
        env.close()


def test_two_joint_views_with_one_seed_go_alike():
    envs = [JointEnv("handover") for _ in range(2)]
    for env in envs:
        env.reset(seed=3)
        env.action_space.seed(3)
    for _ in range(20):
        seen = [env.step(env.action_space.sample()) for env in envs]
        assert seen[0][0].tobytes() == seen[1][0].tobytes()
        assert seen[0][1:] == seen[1][1:]
    for env in envs:
        env.close()


def test_gymnasium_runs_several_joint_views_at_once():
    with excusing():
        envs = gymnasium.make_vec("taskbuilder/Handover-v1", num_envs=2, vectorization_mode="sync")
        observation, _ = envs.reset(seed=0)
        assert observation.shape == (2, *envs.single_observation_space.shape)
        envs.step(envs.action_space.sample())
        envs.close()


def printed(code: str) -> str:
    code = f"import sys, warnings\nwarnings.simplefilter('error')\n{code}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert not done.returncode, done.stderr
    return done.stdout


NAMES = """
import gymnasium
{registered}
env = gymnasium.make("{name}")
env.reset(seed=0)
print(env.action_space.shape, "taskbuilder/Handover-v1" in gymnasium.registry)
"""


def test_registering_is_an_import():
    registered = "import taskbuilder.gym; gymnasium.register_envs(taskbuilder.gym)"
    code = NAMES.format(registered=registered, name="taskbuilder/PickPushPlace-v1")
    assert printed(code) == "(10,) True\n"


def test_a_name_can_say_what_registers_it():
    code = NAMES.format(registered="", name="taskbuilder.gym:taskbuilder/PickPushPlace-v1")
    assert printed(code) == "(10,) True\n"


def test_importing_taskbuilder_imports_nothing_heavy_and_hooks_nothing():
    code = """
before = [*sys.meta_path], [*sys.path_hooks], [*sys.path]
import taskbuilder
print({"gymnasium", "numpy", "pydantic", "matplotlib"} & {*sys.modules})
assert before == (sys.meta_path, sys.path_hooks, sys.path)
import gymnasium
print([name for name in gymnasium.registry if name.startswith("taskbuilder")])
"""
    assert printed(code) == "set()\n[]\n"


def test_environments_and_learning_load_nothing_that_draws_on_paper():
    code = """
import taskbuilder.env.vector, taskbuilder.env.joint, taskbuilder.policies.grammar
import taskbuilder.visual.film
import taskbuilder.evaluation.arms, taskbuilder.validate.runner, taskbuilder.validate.html.files
print({"matplotlib", "PIL"} & {*sys.modules})
"""
    assert printed(code) == "set()\n"


def test_the_joint_view_is_the_multi_agent_one_side_by_side():
    joint, parallel = taskbuilder.JointEnv("handover"), parallel_env("handover")
    seen, _ = joint.reset(seed=5)
    apart, _ = parallel.reset(seed=5)
    rng = np.random.default_rng(0)
    for _ in range(5):
        assert seen.tobytes() == np.concatenate([apart["left"], apart["right"]]).tobytes()
        action = rng.uniform(-1, 1, 10)
        seen, reward, *_ = joint.step(action)
        apart, rewards, *_ = parallel.step({"left": action[:5], "right": action[5:]})
        assert reward == rewards["left"]
    joint.close()
    parallel.close()
