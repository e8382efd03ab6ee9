"""Robots without a gripper push and press, and are not told to hold anything."""

from __future__ import annotations

import math

import numpy as np
import pytest
from gymnasium import spaces
from test_expert_joints import BUTTON, URDFS
from written_experts import made

from taskbuilder.description.contact import Held
from taskbuilder.description.measures import GripperOpening
from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import FileError
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import replay

PUSHED = """
from taskbuilder.description import Bonus, Description, Distance, Near


class Made(Description):
    success = Near("block", "goal", within=0.3)
    reward = (Distance("carry", "block", "goal"), Bonus("there", success, 1.0))
"""


def pusher(folder, *stages, **scene):
    for file in URDFS.glob("hatch_by_a_button.urdf"):
        (folder / file.name).write_bytes(file.read_bytes())
    return made(folder, *stages, model="ur5e_pusher", description=PUSHED, **scene)


def played(folder, *stages, **scene):
    env = pusher(folder, *stages, **scene)
    expert = Expert(env)
    rollout = expert.play(0, finish=False)
    world = env.episode.world
    return env, expert, rollout, world


@pytest.mark.parametrize("to", [[-0.1, -0.05, 0.4], [0.1, 0.15, 0.4], [-0.25, 0.25, 0.4]])
def test_a_block_is_pushed_to_its_place(tmp_path, to):
    env, expert, rollout, world = played(tmp_path, f"arm: {{push: block, to: {to}}}")
    assert rollout.trouble is None
    x, y, _ = world.position("block")
    assert math.dist((x, y), to[:2]) < 0.021
    assert replay(env, rollout).equals(rollout)  # to the bit
    expert.close()
    env.close()


def test_it_presses_moves_and_goes_home(tmp_path):
    stages = ("arm: {press: button, to: 0.012}", "arm: {retreat: 0.05}", "arm: home")
    env, expert, rollout, world = played(tmp_path, *stages, "arm: {reach: spot}", objects=BUTTON)
    assert rollout.trouble is None
    assert math.dist(world.position("arm.tcp"), world.position("spot")) < 0.01
    expert.close()
    env.close()


def test_its_actions_and_observations_have_no_gripper(tmp_path):
    env = pusher(tmp_path, "arm: {reach: spot}")
    assert env.action_space("arm").shape == (4,)  # x, y, z and yaw
    episode = env.episode
    env.reset(seed=0)
    names = [reading.name for reading in env._observer._views["arm"].readings]
    assert "self.joints" in names
    assert not {"self.gripper", "self.holding"} & set(names)
    task = env.task
    env.close()
    parted = parallel_env(task, flat=False)
    space = parted.action_space("arm")
    assert isinstance(space, spaces.Dict)
    assert list(space.spaces) == ["arm"]
    parted.reset(seed=0)
    parted.step({"arm": {"arm": np.zeros(4, dtype=np.float32)}})
    assert parted.episode.previous_action("arm") == [0.0] * 4
    parted.close()
    assert episode.over


@pytest.mark.parametrize("observe", ["scene", "task"])
def test_it_is_observed_by_others_without_a_gripper(tmp_path, observe):
    other = """\
    right:
      model: ur5e
      base: {position: [0.6, 0, 0.4], rpy_deg: [0, 0, 180]}
"""
    env = pusher(tmp_path, "arm: home", robots=other, observe=observe)
    seen, _ = env.reset(seed=0)
    for agent in env.possible_agents:
        assert env.observation_space(agent).contains(seen[agent])
        names = [reading.name for reading in env._observer._views[agent].readings]
        own = "self" if agent == "right" else "right"
        assert "arm.gripper" not in names
        if observe == "scene":
            assert f"{own}.gripper" in names
    env.close()


def refusal(folder, *stages, **scene):
    with pytest.raises(FileError) as caught:
        pusher(folder, *stages, **scene)
    return [f"{each.code} {each.path}: {each.message}" for each in caught.value.findings]


@pytest.mark.parametrize(
    ("order", "said"),
    [
        (
            "{grasp: block.middle}",
            "grasp: arm is a ur5e_pusher, which has no gripper, and cannot grasp block.middle; to "
            "move block, write {push: block, to: ...}, or use a robot with a gripper",
        ),
        (
            "{bring: block, to: goal}",
            "bring: arm is a ur5e_pusher, which has no gripper, and cannot bring block to goal; to "
            "move block, write {push: block, to: ...}",
        ),
        (
            "release",
            "release: arm is a ur5e_pusher, which has no gripper, and cannot release; leave it out",
        ),
        (
            "{close: nothing}",
            "close: arm is a ur5e_pusher, which has no gripper, and cannot close nothing; leave it "
            "out",
        ),
    ],
)
def test_it_is_not_told_to_hold_anything(tmp_path, order, said):
    assert refusal(tmp_path, f"arm: {order}") == [f"TB216 expert[0].arm.{said}"]


def test_it_holds_no_load_together_and_has_no_gripper_to_set(tmp_path):
    other = "    right: {model: ur5e, base: {position: [0.6, 0, 0.4], rpy_deg: [0, 0, 180]}}\n"
    together = "{together: [arm, right], bring: block, to: goal}"
    (found,) = refusal(tmp_path, together, robots=other)
    assert found.startswith("TB216 expert[0].together: arm is a ur5e_pusher, which has no gripper,")
    (found,) = refusal(tmp_path, "arm: home", action="gripper: binary")
    assert found == (
        "TB216 scene.robots.arm.action.gripper: arm is a ur5e_pusher, which has no gripper; leave "
        "gripper out"
    )


def test_nothing_is_said_of_what_it_holds(tmp_path):
    env = pusher(tmp_path, "arm: home")
    names = env.task.file.names
    for node in (Held("block", by="arm"), Held("block", by=("arm",)), GripperOpening("arm")):
        assert list(node.problems(names)) == ["arm has no gripper and never holds anything"]
    assert not list(Held("block").problems(names))
    env.reset(seed=0)
    assert not env.episode.world.held("block", "arm")
    env.close()
