"""What the joint view shows through cameras."""

from __future__ import annotations

import numpy as np
import pytest
from env_tasks import facing, write_task
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env

from taskbuilder.env import observing
from taskbuilder.env.joint import JointEnv
from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import UsageError

CAMERAS = """
  cameras:
    front: {position: [-0.1, -0.8, 0.9], look_at: [-0.1, 0, 0.4], size: [48, 36]}
    wrist: {mount: left.tcp, fov_deg: 75, size: [40, 30]}
  sites:"""


@pytest.fixture
def task(tmp_path):
    """Two robots: one observes its tool and both cameras, the other one camera alone."""
    left, right = "left: [self.tcp, front.rgb, wrist.rgb, front.depth]", "right: [front.rgb]"
    return write_task(tmp_path, facing(left, right).replace("\n  sites:", CAMERAS))


@pytest.fixture
def joint(task):
    """Makes joint environments."""
    made = []

    def make(**options):
        made.append(JointEnv(task, **options))
        return made[-1]

    yield make
    for env in made:
        env.close()


def test_numbers_are_in_one_array_and_each_camera_is_there_once(joint, task):
    env = joint()
    seen, _ = env.reset(seed=3)
    assert env.observation_space.contains(seen)
    assert {key: (array.shape, array.dtype) for key, array in seen.items()} == {
        "agent_pos": ((7,), np.float32),
        "pixels/front": ((36, 48, 3), np.uint8),
        "pixels/wrist": ((30, 40, 3), np.uint8),
        "depth/front": ((36, 48), np.float32),
    }
    apart = parallel_env(task)
    views, _ = apart.reset(seed=3)
    np.testing.assert_array_equal(seen["agent_pos"], views["left"]["vector"])
    np.testing.assert_array_equal(seen["pixels/front"], views["right"]["front.rgb"])
    apart.close()


def test_nested_cameras_are_a_dictionary_of_their_own(joint):
    flat, nested = joint(), joint(pixels="nested")
    one, other = flat.reset(seed=3)[0], nested.reset(seed=3)[0]
    assert nested.observation_space.contains(other)
    assert {key: set(other[key]) for key in ("pixels", "depth")} == {
        "pixels": {"front", "wrist"},
        "depth": {"front"},
    }
    np.testing.assert_array_equal(one["agent_pos"], other["agent_pos"])
    np.testing.assert_array_equal(one["pixels/wrist"], other["pixels"]["wrist"])


def test_an_action_is_one_array_with_cameras_too(joint):
    env = joint()
    assert isinstance(env.action_space, spaces.Box)
    check_env(env, skip_render_check=True)


def test_without_flat_it_is_by_robot(joint):
    env = joint(flat=False)
    seen, _ = env.reset(seed=3)
    assert set(seen) == {"left", "right"}
    assert set(seen["right"]) == {"front.rgb"}


def test_cameras_asked_for_by_an_option_are_there_once(joint):
    env = joint(cameras=("wrist",), camera_size=(16, 12))
    seen, _ = env.reset(seed=3)
    assert seen["pixels/wrist"].shape == (12, 16, 3)
    assert set(env.observation_space) == {
        "agent_pos",
        "pixels/front",
        "pixels/wrist",
        "depth/front",
    }


def test_a_camera_is_drawn_once_a_step_however_many_robots_look(joint, monkeypatch):
    drawn = []
    capture = observing.capture

    def counted(world, view, **options):
        drawn.append(view.fov_deg)
        return capture(world, view, **options)

    monkeypatch.setattr(observing, "capture", counted)
    env = joint()
    env.reset(seed=0)
    drawn.clear()
    env.step(env.action_space.sample())
    assert sorted(drawn) == [50.0, 75.0]


def test_a_saved_state_shows_the_same_again(joint):
    env = joint()
    env.reset(seed=1)
    state = env.save_state()
    first, *_ = env.step(np.ones(env.action_space.shape))
    env.load_state(state)
    again, *_ = env.step(np.ones(env.action_space.shape))
    for key, array in first.items():
        np.testing.assert_array_equal(array, again[key])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pixels": "lerobot"}, """pixels is 'lerobot'; "flat" or "nested\""""),
        ({"pixels": "nested", "flat": False}, "does not go with flat=False"),
    ],
)
def test_an_arrangement_that_there_is_not_is_refused(task, options, message):
    with pytest.raises(UsageError, match=message):
        JointEnv(task, **options)
