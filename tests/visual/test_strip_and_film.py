"""The film strip and the film of an episode, whole."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
import pytest
from film_scenes import SMALL
from PIL import Image

from taskbuilder.visual.film import HOLD_S, save_film
from taskbuilder.visual.keyframes import keyframes
from taskbuilder.visual.still import PAPER, save_image
from taskbuilder.visual.strip import film_strip
from taskbuilder.visual.video import frames_in

TITLE, TILE, CAPTION, MARGIN = 78, 400, 34, 24


def strip(env, episode, *cameras):
    return film_strip(env, episode, cameras, subtitle="As it went.", size=SMALL)


def captions(page, columns, width, height):
    """The captions of each tile of a page."""
    rows = (page.shape[0] - TITLE) // (height + CAPTION)
    for row in range(rows):
        bottom = TITLE + (row + 1) * (height + CAPTION)
        for column in range(columns):
            left = MARGIN + column * (width + MARGIN)
            yield page[bottom - CAPTION : bottom, left : left + width]


def ink(pixels):
    return int((pixels != PAPER).any(axis=2).sum())


def test_a_strip_of_one_camera_has_a_captioned_tile_for_every_moment(env, episode):
    moments = keyframes(episode)
    assert len(moments) == 8
    page = strip(env, episode, "front")
    assert page.shape == (TITLE + 2 * (300 + CAPTION), 4 * (TILE + MARGIN) + MARGIN, 3)
    written = [ink(caption) for caption in captions(page, 4, TILE, 300)]
    assert len(written) == 8
    assert all(written)
    plain = max(w for w, step in zip(written, moments, strict=True) if not said(episode, step))
    assert all(
        w > plain + 50 for w, step in zip(written, moments, strict=True) if said(episode, step)
    )


def said(episode, step):
    return step in episode.reached.values()


def test_a_strip_of_several_cameras_has_a_row_for_each(env, episode):
    page = strip(env, episode, "front", "wrist")
    assert page.shape == (TITLE + 2 * (195 + CAPTION), 8 * (260 + MARGIN) + MARGIN, 3)
    assert all(ink(caption) for caption in captions(page, 8, 260, 195))


def test_a_strip_shows_the_episode_move(env, episode):
    page = strip(env, episode, "front")
    tiles = [page[TITLE : TITLE + 300, 24 + 424 * n : 424 + 424 * n] for n in range(4)]
    assert not any(np.array_equal(a, b) for a, b in pairwise(tiles))


def test_the_same_episode_makes_the_same_strip(env, episode, tmp_path):
    first, second = (strip(env, episode, "front") for _ in range(2))
    assert np.array_equal(first, second)
    save_image(tmp_path / "strip.png", first)
    assert np.array_equal(cv2.imread(str(tmp_path / "strip.png"))[:, :, ::-1], first)


@pytest.mark.parametrize("cameras", [("front",), ("front", "wrist")])
def test_a_film_is_an_mp4_and_a_gif(cameras, env, episode, tmp_path):
    written = save_film(env, episode, cameras, tmp_path / "made.up", size=(64, 48))
    assert [file.name for file in written] == ["made.up.mp4", "made.up.gif"]
    assert sorted(tmp_path.iterdir()) == sorted(written)
    frames = round(24 * episode.seconds(episode.steps)) + 1 + round(24 * HOLD_S)
    assert frames_in(written[0]) == frames
    width = 64 if len(cameras) == 1 else 136
    _, first = cv2.VideoCapture(str(written[0])).read()
    assert first.shape[1] == width
    with Image.open(written[1]) as picture:
        assert picture.size == (width, first.shape[0])
        assert picture.n_frames == 13


def test_a_film_is_480_wide_in_the_proportions_of_its_camera(env, episode, tmp_path):
    mp4, _ = save_film(env, episode, ["front"], tmp_path / "film", fps=1)
    _, first = cv2.VideoCapture(str(mp4)).read()
    assert first.shape == (360 + 32, 480, 3)


def test_frames_are_counted_for_whoever_waits(env, episode, tmp_path):
    told = []

    def progress(frames, count):
        for frame in frames:
            told.append(count)
            yield frame

    save_film(env, episode, ["front"], tmp_path / "f", size=SMALL, progress=progress)
    assert told == [len(told)] * len(told)


def test_a_film_that_is_interrupted_leaves_nothing(env, episode, tmp_path):
    def interrupt(frames, _):
        for number, frame in enumerate(frames):
            if number == 5:
                raise KeyboardInterrupt
            yield frame

    with pytest.raises(KeyboardInterrupt):
        save_film(env, episode, ["front"], tmp_path / "f", size=SMALL, progress=interrupt)
    assert list(tmp_path.iterdir()) == []
    assert env.episode.world.onlooker is None
