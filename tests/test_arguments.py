"""Wrong arguments from Python are refused in words, before anything is done or written."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import taskbuilder
from taskbuilder.arguments import a_seed, several, whole
from taskbuilder.env.errors import ActionError
from taskbuilder.errors import UnknownNameError, UsageError


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set of one episode of reach."""
    folder = tmp_path_factory.mktemp("data") / "reach"
    taskbuilder.collect("reach", folder, episodes=1, jobs=1)
    return folder


@pytest.mark.parametrize("value", [3, np.int64(3), np.uint8(3)])
def test_a_whole_number_of_any_type_is_one(value):
    assert whole("episodes", value, 1, 3) == 3
    assert a_seed(value) == 3


@pytest.mark.parametrize("value", [True, 2.0, "3", None, [3], np.array([1, 2]), -1, 4])
def test_all_else_is_refused_by_its_name(value):
    with pytest.raises(UsageError, match=r"episodes is .*; a whole number from 0 to 3"):
        whole("episodes", value, 0, 3)


def test_a_text_is_no_sequence():
    assert several("cameras", ["front"]) == ("front",)
    with pytest.raises(
        UsageError, match=r'cameras is "front"; it is a tuple, such as \("front",\)'
    ):
        several("cameras", "front")
    with pytest.raises(UsageError, match=r"cameras is 5; it is a tuple"):
        several("cameras", 5)


COLLECTED: list[tuple[dict[str, Any], str]] = [
    ({"episodes": 0}, "episodes is 0; a whole number from 1"),
    ({"episodes": 2.5}, "episodes is 2.5; a whole number from 1"),
    ({"episodes": "2"}, "episodes is '2'; a whole number from 1"),
    ({"first_seed": 1.5}, "first_seed is 1.5; a whole number from 0"),
    ({"first_seed": -1}, "first_seed is -1; a whole number from 0"),
    ({"until_success": 1.5}, "until_success is 1.5; a whole number from 0"),
    ({"policy": []}, "there are no policies"),
    ({"license": None}, "the licence is None; a name, such as MIT"),
    ({"variations": [0.0]}, "reach has no variation 0.0; it has 0 to 2"),
    ({"variations": []}, 'there are no variations; name some, or "all"'),
    ({"jobs": 0}, "jobs is 0; a whole number from 1"),
    ({"depth": True}, "depth images are those of cameras"),
    ({"cameras": "front"}, 'cameras is "front"; it is a tuple'),
    ({"camera_size": 64}, "camera_size is 64; two whole numbers from 1 to 4096, in pixels"),
]


@pytest.mark.parametrize(("wrong", "said"), COLLECTED, ids=lambda value: str(value)[:30])
def test_nothing_is_collected_with_a_wrong_argument(wrong, said, tmp_path):
    with pytest.raises(UsageError, match=said):
        taskbuilder.collect("reach", tmp_path / "out", **{"episodes": 1, "jobs": 1, **wrong})
    assert not (tmp_path / "out").exists()


def test_no_tasks_are_none(tmp_path):
    with pytest.raises(UsageError, match=r"there are no tasks"):
        taskbuilder.collect([], tmp_path / "out")


def test_a_refused_policy_leaves_the_folder_to_the_next_command(tmp_path):
    with pytest.raises(UsageError, match=r"was trained on handover, not on reach"):
        taskbuilder.collect("reach", tmp_path, policy="zoo:handover/cloned", episodes=1, jobs=1)
    assert len(taskbuilder.collect("reach", tmp_path, episodes=1, jobs=1)) == 1
    with pytest.raises(UsageError, match=r"begun in another way"):
        taskbuilder.collect("reach", tmp_path, episodes=2, jobs=1)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"episodes": 0}, "episodes is 0; a whole number from 1"),
        ({"first_seed": -4}, "first_seed is -4; a whole number from 0"),
        ({"jobs": 1.5}, "jobs is 1.5; a whole number from 1"),
    ],
)
def test_nothing_is_multiplied_with_a_wrong_argument(wrong, said, data, tmp_path):
    with pytest.raises(UsageError, match=said):
        taskbuilder.multiply(data, tmp_path / "out", **{"jobs": 1, **wrong})
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"episodes": 0}, "episodes is 0; a whole number from 1"),
        ({"episodes": 1.5}, "episodes is 1.5; a whole number from 1"),
        ({"seeds": [1.5]}, "a seed is a whole number from 0 to 2.*63 - 1, not 1.5"),
        ({"seeds": [-1]}, "a seed is a whole number"),
        ({"seeds": "12"}, 'seeds is "12"; it is a tuple'),
        ({"seeds": []}, "there are no seeds"),
        ({"seeds": [1, 2, 1]}, "the seed 1 is named twice"),
        ({"baselines": -1}, "baselines is -1; a whole number from 0"),
        ({"jobs": 0}, "jobs is 0; a whole number from 1"),
    ],
)
def test_nothing_is_evaluated_with_a_wrong_argument(wrong, said):
    with pytest.raises(UsageError, match=said):
        taskbuilder.evaluate("hold:reach", **wrong)


def test_a_policy_that_returns_nothing_is_no_policy_that_earns_nothing():
    def forgets(observations):
        del observations

    with pytest.raises(UsageError, match=r"forgets returned None after 0 of 20 control steps"):
        taskbuilder.evaluate(forgets, 1, task="reach", horizon=20)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"seed": 1.5}, "seed is 1.5; a whole number from 0"),
        ({"seed": [1, 2]}, r"seed is \[1, 2\]; a whole number from 0"),
        ({"steps": 2.5}, "steps is 2.5; a whole number from 1"),
        ({"workers": 0.5}, "workers is 0.5; 0 to "),
        ({"demos": -1}, "demos is -1; a whole number from 0"),
    ],
)
def test_nothing_is_trained_with_a_wrong_argument(wrong, said, tmp_path):
    pytest.importorskip("torch")
    with pytest.raises(UsageError, match=said):
        taskbuilder.train("reach", out=tmp_path / "run", **wrong)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"camera_size": (64, 32, 3)}, "camera_size is .*; two whole numbers"),
        ({"camera_size": "64x32"}, "camera_size is '64x32'; two whole numbers"),
        ({"variation": 1.0}, 'variation is 1.0; reach has 0 to 2, or "random"'),
        ({"variation": True}, "variation is True; reach has 0 to 2"),
        ({"cameras": "front"}, 'cameras is "front"; it is a tuple'),
        ({"flat": "yes"}, "flat is 'yes'; True or False"),
        ({"normalize": 0}, "normalize is 0; True or False"),
        ({"horizon": True}, "horizon is True; a whole number from 1"),
        ({"position_noise": "much"}, "position_noise is 'much'; 0 to 1, in metres"),
    ],
)
def test_no_environment_is_made_with_a_wrong_option(wrong, said):
    with pytest.raises(UsageError, match=said):
        taskbuilder.parallel_env("reach", **wrong)


@pytest.mark.parametrize("seed", [1.5, -1, True, 2**63, "1", [1]])
@pytest.mark.parametrize("make", [taskbuilder.parallel_env, taskbuilder.JointEnv])
def test_a_wrong_seed_is_refused_by_every_view(make: Callable[[str], Any], seed):
    with (
        closing(make("reach")) as env,
        pytest.raises(UsageError, match=r"a seed is a whole number"),
    ):
        env.reset(seed=seed)


def test_a_closed_environment_says_so_and_a_state_is_one_that_was_saved():
    env = taskbuilder.parallel_env("reach")
    env.reset(seed=0)
    with pytest.raises(UsageError, match=r"a state is what save_state returned, not bytes"):
        env.load_state(b"state")
    env.close()
    with pytest.raises(UsageError, match=r"this environment is closed; make another"):
        env.step({})


@pytest.mark.parametrize(
    ("action", "said"),
    [
        (np.zeros(4, complex), "an array of complex128, not numbers"),
        ("up", "is str, not numbers"),
        (object(), "is object, not numbers"),
    ],
)
def test_an_action_of_no_numbers_names_what_it_is(action, said):
    with closing(taskbuilder.parallel_env("reach")) as env:
        env.reset(seed=0)
        with pytest.raises(ActionError, match=said):
            env.step({env.possible_agents[0]: action})


def test_who_plays_has_reset_and_act():
    with closing(taskbuilder.parallel_env("reach")) as env:
        for wrong in ("expert", taskbuilder.parse_policy("expert")):
            with pytest.raises(UsageError, match=r"which has no reset and act"):
                taskbuilder.play(env, wrong, 0)
    with pytest.raises(UsageError, match=r"an expert plays in a TaskEnv, .* not str"):
        taskbuilder.Expert("reach")


def test_a_replay_has_the_options_of_its_rollout():
    with closing(taskbuilder.parallel_env("reach", horizon=5)) as env:
        rollout = taskbuilder.play(env, taskbuilder.parse_policy("hold").make(env), 0)
    for other in ({"variation": 1, "horizon": 5}, {"horizon": 6}, {}):
        with (
            closing(taskbuilder.parallel_env("reach", **other)) as env,
            pytest.raises(
                UsageError, match=r"the rollout was recorded with (variation=0|horizon=5)"
            ),
        ):
            taskbuilder.replay(env, rollout)


def test_a_wrapper_that_is_none_is_named():
    for wrap, said in ((None, "wrap is None"), (lambda env: None, "wrap returned None")):
        with pytest.raises(UsageError, match=said):
            taskbuilder.make_vec("reach", 1, wrap=wrap)
    with pytest.raises(UsageError, match=r"workers cannot import wrap \("):
        taskbuilder.make_vec("reach", 1, 1, wrap=lambda env: env)
    with pytest.raises(UsageError, match=r"num_envs is 2.0; a whole number from 1"):
        taskbuilder.make_vec("reach", 2.0)


def test_a_data_set_is_made_from_for_a_task_that_it_has(data):
    with pytest.raises(UsageError, match=r"has no episodes of press_button; it has: reach"):
        taskbuilder.make_from(data, task="press_button")
    with pytest.raises(UsageError, match=r"dataset.json is a file; name the folder of a data set"):
        taskbuilder.load_dataset(data / "dataset.json")
    with pytest.raises(UsageError, match=r"there is no folder"):
        taskbuilder.load_dataset(data / "nowhere")


def test_folders_that_are_no_runs_are_told_apart(data, tmp_path):
    with pytest.raises(UsageError, match=r"is a data set; it has no run.json and no policy.npz"):
        taskbuilder.load_policy(str(data))
    with pytest.raises(UsageError, match=r"is no training run; it has no run.json"):
        taskbuilder.load_policy(str(tmp_path))
    (tmp_path / "checkpoints").mkdir()
    (tmp_path / "run.json").write_text("{}")
    (tmp_path / "checkpoints" / "step-000000020.npz").write_bytes(b"")
    with pytest.raises(UsageError, match=r"is a checkpoint, from which training is resumed"):
        taskbuilder.load_policy(str(tmp_path / "checkpoints" / "step-000000020.npz"))


def test_a_run_goes_to_a_folder_of_its_own(data):
    pytest.importorskip("torch")
    before = sorted(file.name for file in data.iterdir())
    with pytest.raises(UsageError, match=r"holds other files \(.*\); name a new or empty folder"):
        taskbuilder.train(data=data, algorithm="bc", steps=1, out=data)
    assert sorted(file.name for file in data.iterdir()) == before


def test_the_name_of_no_policy_is_told():
    with pytest.raises(UnknownNameError, match=r"no policy"):
        taskbuilder.parse_policy("exprt")
