"""What agents see through cameras."""

from __future__ import annotations

import numpy as np
import pytest
from env_tasks import facing, random_actions, still

from taskbuilder.errors import FileError, UsageError

SIZE = (48, 36)
CAMERAS = """
  cameras:
    front: {position: [-0.1, -0.8, 0.9], look_at: [-0.1, 0, 0.4], size: [48, 36]}
    wrist: {mount: left.tcp, fov_deg: 75, size: [40, 30]}
"""
ALL = "[self.tcp, front.rgb, front.depth, front.mask, front.points, wrist.rgb]"


def scene(*observe: str, extra: str = "") -> str:
    text = facing(*observe, extra=extra)
    return text.replace("  sites:", CAMERAS.strip("\n") + "\n  sites:")


@pytest.mark.parametrize("flat", [True, False])
def test_images_have_the_shapes_and_ranges_of_their_spaces(make, flat):
    env = make(scene(f"left: {ALL}", "right: [self.tcp]"), flat=flat)
    views, _ = env.reset(seed=0)
    found = views["left"]
    space = env.observation_space("left")
    assert space.contains(found)
    expected = {
        "front.rgb": ((36, 48, 3), np.uint8),
        "front.depth": ((36, 48), np.float32),
        "front.mask": ((36, 48), np.int16),
        "front.points": ((36 * 48, 3), np.float32),
        "wrist.rgb": ((30, 40, 3), np.uint8),
        "vector" if flat else "self.tcp": ((7,), np.float32),
    }
    assert {key: (array.shape, array.dtype) for key, array in found.items()} == expected
    assert set(space) == set(expected)
    assert isinstance(views["right"], np.ndarray) == flat
    assert np.ptp(found["front.rgb"]) > 50
    assert np.ptp(found["wrist.rgb"]) > 20


def test_points_lie_on_what_the_mask_says_is_there(make):
    env = make(scene(f"left: {ALL}", "right: [self.tcp]"))
    views, _ = env.reset(seed=0)
    found = views["left"]
    points = found["front.points"].reshape(36, 48, 3)
    world = env.episode.world
    for name, half in (("block", (0.03, 0.02, 0.02)), ("post", (0.05, 0.015, 0.19))):
        body = world.objects[name].body
        on = points[found["front.mask"] == env.mask_names.index(name)]
        assert len(on) > 1
        own = np.array([body.pose().inverse().apply(tuple(point)) for point in on.tolist()])
        off = np.abs(own) - half
        assert off.max() < 0.01, name  # inside the box, and on its surface
        assert np.abs(off.max(axis=1)).max() < 0.01, name
    floor = points[found["front.mask"] == env.mask_names.index("world.floor")]
    assert len(floor) > 100
    assert np.abs(floor[:, 2]).max() < 0.02


def test_depth_is_measured_along_the_line_of_sight(make):
    env = make(scene(f"left: {ALL}", "right: [self.tcp]"))
    views, _ = env.reset(seed=0)
    eye, aim = np.array((-0.1, -0.8, 0.9)), np.array((-0.1, 0.0, 0.4))
    forward = (aim - eye) / np.linalg.norm(aim - eye)
    along = ((views["left"]["front.points"] - eye) @ forward).reshape(36, 48)
    depth = views["left"]["front.depth"]
    shown = depth < 10.0  # and not the background, which is at the far plane
    assert shown.mean() > 0.5
    assert np.abs(along - depth)[shown].max() < 1e-3


def test_a_wrist_camera_moves_with_the_wrist_and_a_fixed_one_does_not(make):
    env = make(scene("left: [wrist.points, front.points]", "right: [self.tcp]"))
    first, _ = env.reset(seed=0)
    push = still(env)
    push["left"][:3] = (-0.5, 0.0, 1.0)
    for _ in range(4):
        views, *_ = env.step(push)
    floor = first["left"]["front.points"][-48:]
    assert np.abs(views["left"]["front.points"][-48:] - floor).max() < 1e-3
    assert np.abs(views["left"]["wrist.points"] - first["left"]["wrist.points"]).max() > 0.05


def test_an_agent_may_see_by_a_camera_alone(make):
    for flat in (True, False):
        env = make(scene("left: [front.rgb]", "right: [self.tcp]"), flat=flat)
        views, _ = env.reset(seed=0)
        assert env.observation_space("left").contains(views["left"])
        assert views["left"]["front.rgb"].shape == (36, 48, 3)


def test_every_agent_sees_the_cameras_that_are_asked_for(make):
    env = make(
        scene("left: [self.tcp]", "right: [front.rgb]"), cameras=("front",), camera_size=(20, 16)
    )
    views, _ = env.reset(seed=0)
    for agent in env.possible_agents:
        assert views[agent]["front.rgb"].shape == (16, 20, 3)
        assert env.observation_space(agent).contains(views[agent])
    assert views["left"]["front.rgb"].tobytes() == views["right"]["front.rgb"].tobytes()
    assert not np.shares_memory(views["left"]["front.rgb"], views["right"]["front.rgb"])


def test_looking_changes_nothing_in_what_happens(make):
    seeing = make(scene(f"left: {ALL}", "right: [self.tcp]"))
    blind = make(scene("left: [self.tcp]", "right: [self.tcp]"))
    for env in (seeing, blind):
        env.reset(seed=0)
    for action in random_actions(blind, 0, 5):
        one, other = seeing.step(action)[0], blind.step(action)[0]
        assert one["left"]["vector"].tobytes() == other["left"].tobytes()
        assert seeing.state().tobytes() == blind.state().tobytes()


def test_pictures_repeat_with_the_seed(make):
    env = make(scene(f"left: {ALL}", "right: [self.tcp]"))
    shown = []
    for seed in (0, 1, 0):
        env.reset(seed=seed)
        views, *_ = env.step(still(env))
        shown.append(views["left"])
    for key, array in shown[0].items():
        assert array.tobytes() == shown[2][key].tobytes(), key
    assert shown[0]["front.rgb"].tobytes() != shown[1]["front.rgb"].tobytes()


def test_rendering_shows_the_camera_that_was_asked_for(make):
    text = scene("left: [self.tcp]", "right: [self.tcp]")
    first, wrist = (
        make(text, render_mode="rgb_array"),
        make(text, render_mode="rgb_array", render_camera="wrist"),
    )
    for env in (first, wrist):
        env.reset(seed=0)
    assert first.render().shape == (36, 48, 3)
    assert wrist.render().shape == (30, 40, 3)


def test_a_camera_that_is_not_there_is_named(make):
    text = scene("left: [self.tcp]", "right: [self.tcp]")
    for options in ({"cameras": ("frnot",)}, {"render_camera": "frnot"}):
        with pytest.raises(UsageError, match='did you mean "front"'):
            make(text, **options)


def test_the_state_of_a_critic_is_made_of_numbers(make):
    with pytest.raises((UsageError, FileError), match=r"camera|front\.rgb"):
        make(scene("left: [self.tcp]", "right: [self.tcp]", extra="state: [front.rgb]\n"))
