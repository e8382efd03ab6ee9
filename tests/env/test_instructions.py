"""Instructions name what the episode drew, in all views of an environment."""

from __future__ import annotations

from contextlib import closing

import gymnasium
import numpy as np
import pytest
from env_tasks import facing, write_task
from pettingzoo.utils.conversions import parallel_to_aec

from taskbuilder import JointEnv, load_task, make_vec, parallel_env
from taskbuilder.schema.instructions import fill, longest_instruction
from taskbuilder.schema.values import PALETTE

COLORS = {"yellow": "yellow", "[0.2, 0.4, 0.9]": "blue", '"#ff8800"': "orange"}
"""Colours as a task file writes them, and what an instruction calls them."""

WORDS = f"""
instructions: ["take the {{block.color}} block of {{block.mass}} kg"]
variations:
  - {{block.color: [0.1, 0.9, 0.1]}}
randomize:
  block.color: {{choice: [{", ".join(COLORS)}]}}
  block.mass: {{uniform: [0.1, 0.2]}}
"""
TEXT = facing(extra=WORDS)
BALLS = (
    "    balls: {count: 2, arrange: {line: 0.1}, shape: {sphere: 0.02}, mass: 0.1, color: white, "
    "position: [0.3, 0.4, 0.02]}\n  sites:\n"
)


def words_of(env) -> str:
    """What the instruction of an episode has to be, from the colours of the physics engine."""
    block = env.episode.world.objects["block"].body
    red, green, blue, _ = block.colors()[-1]
    name = {
        (0.93, 0.78, 0.18): "yellow",
        (0.2, 0.4, 0.9): "blue",
        (1.0, 0.53, 0.0): "orange",
    }[round(red, 2), round(green, 2), round(blue, 2)]
    return f"take the {name} block of {env.episode.quantities['block.mass']:.3g} kg"


def test_every_view_names_what_was_drawn(tmp_path):
    path = write_task(tmp_path, TEXT)
    task = load_task(path)
    expected = {}
    with closing(parallel_env(task, randomize=True)) as env:
        for seed in range(8):
            _, infos = env.reset(seed=seed)
            expected[seed] = words_of(env)
            assert {info["instruction"] for info in infos.values()} == {expected[seed]}
            assert env.task_description == expected[seed]
            assert "instruction" not in env.step(actions(env))[-1]["left"]
        turns = parallel_to_aec(env)
        turns.reset(seed=3)
        assert turns.last()[-1]["instruction"] == expected[3]
    assert len({text.split()[2] for text in expected.values()}) == len(COLORS)
    with closing(JointEnv(task, randomize="all")) as joint:
        for seed, text in expected.items():
            assert joint.reset(seed=seed)[1]["instruction"] == joint.task_description == text
    for workers in (0, 1):
        with closing(make_vec(task, 4, workers, randomize=True, horizon=2)) as envs:
            _, infos = envs.reset(seed=0)
            assert infos["instruction"].tolist() == [expected[seed] for seed in range(4)]
    gym = gymnasium.make("taskbuilder.gym:taskbuilder/Task-v0", task=str(path), randomize=True)
    assert gym.reset(seed=2)[1]["instruction"] == expected[2]
    gym.close()


def actions(env):
    return {agent: np.zeros(env.action_space(agent).shape) for agent in env.agents}


@pytest.mark.parametrize("autoreset", ["SameStep", "NextStep"])
def test_vector_infos_name_the_instructions_of_episodes_that_begin(tmp_path, autoreset):
    task = load_task(write_task(tmp_path, TEXT))
    seen = []
    for workers in (0, 2):
        with closing(
            make_vec(task, 2, workers, autoreset=autoreset, randomize=True, horizon=2)
        ) as envs:
            envs.reset(seed=5)
            still = {agent: space.sample() * 0 for agent, space in envs.action_space.items()}
            told = [envs.step(still)[-1] for _ in range(6)]
        begun = [n for n, infos in enumerate(told) if "instruction" in infos]
        assert begun == ([1, 3, 5] if autoreset == "SameStep" else [2, 5])
        assert all(told[n]["_instruction"].all() for n in begun)
        seen.append([told[n]["instruction"].tolist() for n in begun])
    assert seen[0] == seen[1]
    assert len({text for texts in seen[0] for text in texts}) > 1


def test_colours_in_numbers_get_the_nearest_name(make):
    env = make(TEXT, variation=1)
    env.reset(seed=0)
    assert env.task_description.startswith("take the green block of 0.1 kg")


def test_a_saved_state_keeps_its_words(make):
    env = make(TEXT, randomize=True)
    env.reset(seed=0)
    state, text = env.save_state(), env.task_description
    seed = next(s for s in range(1, 20) if env.reset(seed=s)[1]["left"]["instruction"] != text)
    assert seed
    env.load_state(state)
    assert env.task_description == text


@pytest.mark.parametrize("name", ["balls", "balls_2"])
def test_members_of_a_group_have_the_colour_that_it_drew(make, name):
    scene = make(facing().replace("  sites:\n", BALLS)).task.file.spec.scene
    assert fill(f"{{{name}.color}} of {{balls.count}}", scene) == "white of 2"
    assert fill(f"{{{name}.color}}", scene, {"balls.color": "pink"}) == "pink"


def test_no_instruction_is_longer_than_the_bound(make):
    file = make(TEXT).task.file
    bound = longest_instruction(file.spec, file.scenes)
    for scene in file.scenes:
        for color in PALETTE:
            drawn = {"block.color": color, "block.mass": 0.123456789}
            assert len(fill(file.spec.instructions[0], scene, drawn).encode()) <= bound
