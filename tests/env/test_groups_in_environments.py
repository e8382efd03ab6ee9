"""Groups of objects in environments: what is observed of them, judged, saved and played."""

from __future__ import annotations

import pickle
from contextlib import closing

import numpy as np
import pytest
from env_tasks import arm, moment, physical, play, random_actions

from taskbuilder import make_vec
from taskbuilder.env.infos import make_info
from taskbuilder.schema.dump import as_yaml
from taskbuilder.task import load_task

MEMBERS = ("cubes_1", "cubes_2", "cubes_3")
OBJECTS = """\
  objects:
    cubes:
      shape: {box: [0.03, 0.03, 0.03]}
      mass: 0.02
      count: 3
      arrange: {line: 0.06}
      place: {center: [0.5, 0.3, 0.0152], size: [0.1, 0.1, 0], yaw_deg: [-45, 45]}
"""
GROUP = """\
observe: {arm: [cubes.position, "cubes.pose in self.tcp", cubes_2.position, time_left]}
observation_noise: {arm: {cubes.position: {std: 0.0}}}
expert:
  - arm: [{reach: cubes_2, above: 0.1, touching: [cubes]}]
"""
JUDGED = """
from taskbuilder.description import All, Any, Below, Count, Description, Moved, Paid


class Made(Description):
    moved = Moved("cubes", by=0.02)
    success = All(moved)
    failure = Any(Below("cubes", height=-0.1))
    reward = (Paid("moved", Count(moved)),)
"""


@pytest.fixture
def group(make):
    before, sites, after = arm(extra=GROUP).partition("  sites:")
    return lambda **options: make(before + OBJECTS + sites + after, JUDGED, **options)


def test_a_channel_of_a_group_lists_all_members_in_their_order(group):
    env = group(flat=False)
    seen, _ = env.reset(seed=1)
    world = env.episode.world
    positions = [world.position(name) for name in MEMBERS]
    assert seen["arm"]["cubes.position"] == pytest.approx(np.concatenate(positions), abs=1e-6)
    assert seen["arm"]["cubes.pose in self.tcp"].shape == (21,)
    assert env.observation_space("arm").contains(seen["arm"])
    assert env.observation_space("arm")["cubes.position"].shape == (9,)


def test_rotations_of_all_members_can_be_matrices(group):
    env = group(flat=False, rotation="matrix")
    seen, _ = env.reset(seed=1)
    assert seen["arm"]["cubes.pose in self.tcp"].shape == (27,)


def test_a_reward_counts_the_members(group):
    env = group()
    env.reset(seed=1)
    body = env.episode.world.objects["cubes_2"].body
    body.place(body.pose().moved((0.0, 0.1, 0.0)))
    env.episode.world.refresh()
    _, rewards, *_ = env.step(random_actions(env, 0, 1)[0])
    assert rewards["arm"] == pytest.approx(1.0)


def test_a_copy_and_a_worker_judge_the_same(group):
    env = group()
    actions = random_actions(env, 3, 4)
    with (
        closing(pickle.loads(pickle.dumps(env))) as other,
        closing(make_vec(env.task, 1, workers=1)) as vec,
    ):
        for each in (env, other, vec):
            each.reset(seed=3)
        assert play(other, actions) == play(env, actions)
        for action in actions:
            _, _, _, _, infos = vec.step({agent: a[None] for agent, a in action.items()})
        assert {key: infos[key][0] for key in env.info_keys} == make_info(env.episode)


def test_a_saved_state_goes_on_as_it_went(group):
    env = group()
    env.reset(seed=3)
    actions = random_actions(env, 3, 6)
    play(env, actions[:3])
    state = env.save_state()
    ahead = play(env, actions[3:]), moment(env)
    env.load_state(state)
    assert (play(env, actions[3:]), moment(env)) == ahead


def test_environments_of_one_task_agree_to_the_bit(group):
    one, other = group(), group()
    one.reset(seed=7)
    one.reset(seed=8)
    other.reset(seed=8)
    assert physical(one) == physical(other)


def test_the_file_is_shown_as_it_was_written(group):
    task = group().episode.task
    assert "count: 3" in as_yaml(task.file)
    assert "cubes_1" not in as_yaml(task.file)
    assert task.file.spec.expert[0]["arm"][0].touching == MEMBERS
    assert tuple(task.file.spec.scene.objects) == MEMBERS


def test_what_is_shown_is_the_same_task(group, tmp_path):
    task = group().episode.task
    again = tmp_path / "made.yaml"
    again.write_text(as_yaml(task.file), encoding="utf-8")
    (tmp_path / "made.py").write_text(task.file.entry.description_file.read_text())
    assert load_task(again).file.scenes == task.file.scenes
