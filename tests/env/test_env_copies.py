"""Copies of environments: each has a world of its own, or none is made."""

from __future__ import annotations

import copy
import os
import pickle
import subprocess
import sys
import traceback

import cloudpickle
import numpy as np
import pytest
from env_tasks import TWO, arm, digest, facing, moment, play, random_actions

from taskbuilder.env.joint import JointEnv
from taskbuilder.errors import ExplosionError, UsageError

WAYS = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
    "cloudpickle": lambda env: pickle.loads(cloudpickle.dumps(env)),
}
TEXT = facing(
    "left: [self.tcp, block.pose, time_left]",
    "right: [self.tcp, block.position]",
    extra="observation_noise: {right: {block.position: {position_std: 0.01}}}\n",
)

ways = pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)


@pytest.fixture
def copies():
    """Makes copies that are closed in the end."""
    made = []

    def make_copy(way, env):
        made.append(way(env))
        return made[-1]

    yield make_copy
    for env in made:
        env.close()


@ways
def test_a_copy_in_mid_episode_stands_where_the_original_does_and_goes_its_own_way(
    way, make, copies
):
    env = make(TEXT, TWO, variation="random", reward="local")
    env.reset(seed=3)
    env.reset()
    play(env, random_actions(env, 1, 5))
    before = digest(moment(env))
    other = copies(way, env)
    assert type(other) is type(env)
    assert other.episode.world.client is not env.episode.world.client
    assert digest(moment(env)) == digest(moment(other)) == before
    ahead = random_actions(env, 2, 3)
    played = play(other, ahead)
    assert digest(moment(env)) == before  # nothing of the original has moved
    assert played == play(env, ahead)
    assert digest(env.reset()) == digest(other.reset())  # the episodes after it are the same too
    assert play(env, ahead) == play(other, ahead)


@ways
def test_a_copy_between_episodes_has_the_next_ones_before_it(way, make, copies):
    env = make(arm(steps=3))
    new = copies(way, env)
    with pytest.raises(UsageError, match="reset"):
        new.save_state()
    env.reset(seed=4)
    play(env, random_actions(env, 1, 3))
    assert not env.agents
    over = copies(way, env)
    assert digest(moment(over)) == digest(moment(env))
    assert digest(env.reset()) == digest(over.reset())


@ways
def test_one_that_went_back_to_a_saved_state_is_copied_too(way, make, copies):
    env = make(TEXT)
    env.reset(seed=1)
    actions = random_actions(env, 1, 6)
    play(env, actions[:2])
    state = env.save_state()
    play(env, actions[2:])
    env.load_state(state)
    play(env, actions[:1])
    other = copies(way, env)
    assert digest(moment(other)) == digest(moment(env))
    assert play(other, actions[3:]) == play(env, actions[3:])


@ways
def test_copies_of_one_that_was_never_reset_have_episodes_of_their_own(way, make, copies):
    env = make(TEXT)
    one, other = copies(way, env), copies(way, env)
    assert len({digest(each.reset()) for each in (env, one, other)}) == 3
    assert digest(one.reset(seed=4)) == digest(other.reset(seed=4))


def test_a_copy_of_a_copy_is_whole(make, copies):
    env = make(TEXT)
    env.reset(seed=5)
    play(env, random_actions(env, 3, 2))
    other = copies(copy.deepcopy, copies(copy.deepcopy, env))
    assert digest(moment(other)) == digest(moment(env))
    assert other.task is env.task


@ways
def test_the_joint_view_is_copied_with_its_environment(way, make, copies, tmp_path):
    env = copies(lambda task: JointEnv(task, render_mode="rgb_array"), make(TEXT).task)
    env.reset(seed=2)
    env.step(env.action_space.sample())
    other = copies(way, env)
    assert other.parallel.episode.world.client is not env.parallel.episode.world.client
    action = env.action_space.sample()
    assert digest(*other.step(action)) == digest(*env.step(action))
    assert np.array_equal(other.render(), env.render())


def test_what_was_set_on_an_environment_goes_with_its_copy(make, copies):
    env = make(arm())
    env.label = ["mine"]
    other = copies(copy.deepcopy, env)
    assert other.label == ["mine"]
    assert other.label is not env.label


def test_a_copy_is_unpacked_in_another_process(make, tmp_path):
    env = make(TEXT)
    env.reset(seed=3)
    play(env, random_actions(env, 1, 3))
    (tmp_path / "env.pickle").write_bytes(pickle.dumps(env))
    code = "import pickle, sys; env = pickle.load(open(sys.argv[1], 'rb')); print(env.state())"
    command = [sys.executable, "-c", code, str(tmp_path / "env.pickle")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == (f"{env.state()}\n", "")


def test_one_whose_task_has_changed_meanwhile_is_refused(make, tmp_path):
    env = make(arm())
    (tmp_path / "env.pickle").write_bytes(pickle.dumps(env))
    file = env.task.file.entry.description_file
    file.write_text(file.read_text().replace("0.01", "0.02"))
    code = "import pickle, sys; pickle.load(open(sys.argv[1], 'rb'))"
    command = [sys.executable, "-c", code, str(tmp_path / "env.pickle")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "made has changed since this copy was made; make it anew" in done.stderr


# Where no copy can be made


def reset(env):
    env.reset(seed=1)
    play(env, random_actions(env, 1, 2))


def exploded(env):
    reset(env)

    def burst(targets):
        raise ExplosionError("for a test")

    env.episode.world.step = burst
    play(env, random_actions(env, 1, 1))
    assert env.episode.exploded


def closed(env):
    env.close()


def meddled(env):
    reset(env)
    block = env.episode.world.objects["block"].body
    pose = block.pose()
    block.place(type(pose)((0.3, 0.3, 0.3), pose.quaternion))


REFUSED = {
    exploded: "diverged; reset it first",
    closed: "is closed; make another",
    meddled: "something else moved the world .*; reset the environment to go on",
}


@ways
@pytest.mark.parametrize("trouble", REFUSED, ids=lambda trouble: trouble.__name__)
def test_what_cannot_be_played_again_is_not_copied_and_says_so(trouble, way, make):
    env = make(TEXT)
    trouble(env)
    with pytest.raises(UsageError, match=REFUSED[trouble]):
        way(env)


def test_after_its_next_reset_it_can_be(make, copies):
    env = make(TEXT)
    meddled(env)
    reset(env)
    assert digest(moment(copies(copy.deepcopy, env))) == digest(moment(env))


@ways
@pytest.mark.parametrize(
    "part",
    [
        lambda env: env.episode,
        lambda env: env.episode.world,
        lambda env: env.episode.world.client,
        lambda env: env.episode.world.client.bullet,
    ],
    ids=["episode", "world", "client", "calls"],
)
def test_what_holds_the_physics_is_not_copied_by_itself(part, way, make):
    env = make(arm())
    env.reset(seed=1)
    with pytest.raises(UsageError, match=r"cannot be copied or pickled; .*copy the environment"):
        way(part(env))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@pytest.mark.parametrize(
    "use",
    [
        lambda env, actions: env.reset(seed=1),
        lambda env, actions: env.step(actions),
        lambda env, actions: env.save_state(),
        lambda env, actions: env.render(),
    ],
    ids=["reset", "step", "save_state", "render"],
)
def test_a_forked_process_is_told_to_make_its_own(use, make):
    env = make(TEXT)
    env.render_mode = "rgb_array"
    reset(env)
    (actions,) = random_actions(env, 1, 1)
    said = in_a_fork(lambda: use(env, actions))
    assert "in another process than the one that made it; make one there" in said
    env.step(actions)  # that of the process that made it is as before


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@ways
def test_a_forked_process_copies_what_its_parent_made(way, make):
    env = make(TEXT)
    reset(env)
    ahead = random_actions(env, 2, 3)
    played = in_a_fork(lambda: play(way(env), ahead))
    assert played == str(play(env, ahead))


def in_a_fork(do):
    """What a forked process makes of it, or the error that it met there, as text."""
    near, far = os.pipe()
    pid = os.fork()
    if pid == 0:
        try:
            said = str(do())
        except UsageError as error:
            said = str(error)
        except BaseException:
            said = traceback.format_exc()
        os.write(far, said.encode())
        os._exit(0)
    os.close(far)
    with os.fdopen(near) as file:
        said = file.read()
    os.waitpid(pid, 0)
    return said
