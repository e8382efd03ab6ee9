"""Frames: when they are taken, what they show, and that taking them changes nothing."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from film_scenes import SMALL

from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import replay
from taskbuilder.visual.capture import capture_frames, take_picture
from taskbuilder.world.pictures import capture


def trace(env):
    """What a later control step depends on, as bytes."""
    world = env.episode.world
    joints = [(robot.arm_state(), robot.speeds()) for robot in world.robots.values()]
    poses = [world.pose(name) for name in (*world.objects, *world.sites)]
    return env.state().tobytes(), joints, poses, env.team_reward()


def test_an_episode_goes_as_it_went_while_it_is_filmed():
    """With a grasp and a handing over, between whose physics steps cameras look."""
    env = parallel_env("handover")
    player = Expert(env)
    plain: list[object] = []
    episode = player.play(0, watch=lambda played: plain.append(trace(played)))
    assert env.episode.outcome.conditions["handed_over"]
    filmed = []
    step = env.step

    def traced(actions):
        taken = step(actions)
        filmed.append(trace(env))
        return taken

    env.step = traced
    cameras = ["front", "right_wrist"]
    frames = sum(1 for _ in capture_frames(env, episode.until(30), cameras, size=(16, 12), fps=40))
    assert frames == 3 * 40 + 1
    assert filmed == plain[1:31]
    player.close()
    env.close()


def test_frames_come_at_an_even_rate(env, episode):
    frames = list(capture_frames(env, episode, ["front"], size=SMALL, fps=24))
    assert [frame.seconds for frame in frames] == pytest.approx([n / 24 for n in range(25)])
    assert [frame.step for frame in frames] == [n * 5 // 12 for n in range(25)]


@pytest.mark.parametrize("fps", [1, 7, 50])
def test_a_rate_that_does_not_fit_the_physics_takes_its_nearest_steps(env, episode, fps):
    *frames, last = capture_frames(env, episode, ["front"], size=SMALL, fps=fps)
    assert len(frames) == fps
    for number, frame in enumerate(frames):
        assert 0 <= frame.seconds - number / fps < 1 / 120
    assert last.seconds == pytest.approx(1.0)


def test_pictures_have_the_size_asked_for_or_that_of_their_camera(env, episode):
    asked, own = (
        next(capture_frames(env, episode, ["front", "wrist"], size=size)) for size in (SMALL, None)
    )
    assert {name: picture.shape for name, picture in asked.pictures.items()} == {
        "front": (24, 32, 3),
        "wrist": (24, 32, 3),
    }
    assert own.pictures["front"].shape == (48, 64, 3)


def test_what_moves_is_elsewhere_in_every_frame(env, episode):
    """The arm, the wrist's camera, and the marker that rides on the tool."""
    frames = list(capture_frames(env, episode.until(6), ["front", "wrist"], fps=60))[20:]
    for camera in ("front", "wrist"):
        pictures = [frame.pictures[camera] for frame in frames]
        same = [np.array_equal(a, b) for a, b in pairwise(pictures)]
        assert not any(same), camera


def test_frames_between_control_steps_lie_between_them(env, episode):
    frames = list(capture_frames(env, episode.until(7), ["front"], size=(240, 180), fps=30))[6:]
    columns = []
    for frame in frames:
        red, green, blue = np.moveaxis(frame.pictures["front"].astype(int), 2, 0)
        yellow = (red > 100) & (green > 100) & (blue < 60)
        columns.append(np.nonzero(yellow)[1].mean())
    ways = np.diff(columns)
    assert (ways > 0).all() or (ways < 0).all()
    assert abs(ways).max() < 3 * abs(ways).min()


def test_a_frame_of_a_control_step_shows_what_is_seen_after_it(env, episode):
    seen = []
    replay(env, episode, lambda e: seen.append(take_picture(e.episode.world, "wrist", SMALL)))
    frames = list(capture_frames(env, episode, ["wrist"], size=SMALL, fps=10))
    assert len(frames) == len(seen)
    for frame, picture in zip(frames, seen, strict=True):
        assert np.array_equal(frame.pictures["wrist"], picture)


def test_a_film_may_end_before_the_episode(env, episode):
    frames = list(capture_frames(env, episode.until(3), ["front"], size=SMALL, fps=20))
    assert frames[-1].seconds == pytest.approx(0.3)
    assert len(frames) == 7


def test_nobody_looks_on_once_a_film_is_over_or_given_up(env, episode):
    frames = capture_frames(env, episode, ["front"], size=SMALL)
    next(frames)
    assert env.episode.world.onlooker is not None
    frames.close()
    assert env.episode.world.onlooker is None
    list(capture_frames(env, episode, ["front"], size=SMALL, fps=2))
    assert env.episode.world.onlooker is None


@pytest.mark.parametrize("fps", [0, 121])
def test_a_rate_beyond_the_physics_is_refused(env, episode, fps):
    with pytest.raises(UsageError, match=f"fps is {fps}; from 1 to the 120 physics steps"):
        next(capture_frames(env, episode, ["front"], fps=fps))


def test_an_unknown_camera_is_refused(env, episode):
    with pytest.raises(UnknownNameError, match='no camera "frnt"; did you mean "front"'):
        list(capture_frames(env, episode.until(1), ["frnt"], size=SMALL))


def test_an_episode_of_another_task_is_not_filmed(env, episode):
    other = parallel_env("handover")
    with pytest.raises(UsageError, match="a rollout of sideways"):
        next(capture_frames(other, episode, ["front"]))
    other.close()


def test_edges_are_smooth_and_the_rest_is_as_it_was_drawn(env, episode):
    env.reset(seed=0)
    world = env.episode.world
    smooth = take_picture(world, "front", (160, 120))
    drawn = capture(world, world.camera("front", (160, 120)), shadow=True, studio=True).rgb
    changed = (smooth != drawn).any(axis=2)
    assert 0.01 < changed.mean() < 0.4
    assert abs(smooth.astype(int) - drawn).mean() < 4
