"""MP4 and GIF files: what is read back, and what is left when writing fails."""

from __future__ import annotations

import subprocess
import sys

import cv2
import numpy as np
import pytest
from PIL import Image

from taskbuilder.visual import video
from taskbuilder.visual.video import frames_in, mp4, save_gif


def moving(count, size=(64, 48)):
    """A dark square that moves to the right on light ground."""
    frames = []
    for number in range(count):
        frame = np.full((size[1], size[0], 3), (200, 210, 220), dtype=np.uint8)
        frame[20:30, 2 * number : 2 * number + 10] = (160, 30, 20)
        frames.append(frame)
    return frames


@pytest.fixture(params=["PyAV", "OpenCV alone"])
def writer(request, monkeypatch):
    """What writes films: PyAV where it is installed, as here, and OpenCV where it is not."""
    if request.param == "OpenCV alone":
        monkeypatch.setitem(sys.modules, "av", None)
    return request.param


def write(path, frames, fps=24):
    with mp4(path, fps=fps) as add:
        for frame in frames:
            add(frame)


@pytest.mark.usefixtures("writer")
def test_a_film_reads_back_frame_by_frame(tmp_path):
    frames = moving(12)
    write(tmp_path / "film.mp4", frames)
    film = cv2.VideoCapture(str(tmp_path / "film.mp4"))
    assert film.get(cv2.CAP_PROP_FPS) == pytest.approx(24)
    for frame in frames:
        there, read = film.read()
        assert there
        assert read.shape == (48, 64, 3)
        assert abs(read[:, :, ::-1].astype(int) - frame).mean() < 6  # and red is not blue
    assert not film.read()[0]
    assert [file.name for file in tmp_path.iterdir()] == ["film.mp4"]


@pytest.mark.parametrize(
    ("writer", "codec"), [("PyAV", "avc1"), ("OpenCV alone", "vp09")], indirect=["writer"]
)
def test_films_are_in_a_format_that_browsers_play(writer, codec, tmp_path):
    write(tmp_path / "film.mp4", moving(3))
    film = cv2.VideoCapture(str(tmp_path / "film.mp4"))
    written = int(film.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little").decode().lower()
    assert written in {"avc1": ("avc1", "h264"), "vp09": ("vp09", "vp90")}[codec]


def test_a_film_is_the_same_to_the_bit_each_time(tmp_path):
    for name in ("one", "two"):
        write(tmp_path / f"{name}.mp4", moving(5))
    assert (tmp_path / "one.mp4").read_bytes() == (tmp_path / "two.mp4").read_bytes()


def test_the_colours_of_a_palette_are_those_that_are_there():
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 6, (500, 3), dtype=np.uint8) * np.uint8(51)
    found = video._colors(pixels)
    assert found.dtype == np.uint8
    assert np.array_equal(found, np.unique(pixels, axis=0))


def test_a_film_can_be_read_by_all(tmp_path):
    write(tmp_path / "film.mp4", moving(2))
    assert (tmp_path / "film.mp4").stat().st_mode & 0o777 == 0o644


@pytest.mark.usefixtures("writer")
@pytest.mark.parametrize("problem", [KeyboardInterrupt, RuntimeError])
def test_a_film_that_is_cut_short_is_not_there(problem, tmp_path):
    (tmp_path / "film.mp4").write_bytes(b"old")

    def cut_short():
        yield from moving(5)
        raise problem

    with pytest.raises(problem):
        write(tmp_path / "film.mp4", cut_short())
    assert [file.name for file in tmp_path.iterdir()] == ["film.mp4"]
    assert (tmp_path / "film.mp4").read_bytes() == b"old"


def test_a_film_that_cannot_be_read_back_is_not_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(video, "frames_in", lambda _: 3)
    with pytest.raises(OSError, match=r"3 of 4 frames could be read back"):
        write(tmp_path / "film.mp4", moving(4))
    assert list(tmp_path.iterdir()) == []


def test_another_codec_is_taken_without_a_word_where_the_first_is_missing(
    tmp_path, monkeypatch, capfd
):
    monkeypatch.setitem(sys.modules, "av", None)
    monkeypatch.setattr(video, "CODECS", ("avc1", "mp4v"))
    write(tmp_path / "film.mp4", moving(4))
    assert frames_in(tmp_path / "film.mp4") == 4
    assert capfd.readouterr() == ("", "")


def test_without_any_codec_there_is_no_film(tmp_path, monkeypatch, capfd):
    monkeypatch.setitem(sys.modules, "av", None)
    monkeypatch.setattr(video, "CODECS", ("zzzz",))
    with pytest.raises(OSError, match="writes no MP4 with zzzz"):
        write(tmp_path / "film.mp4", moving(4))
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


def test_films_without_pyav_say_once_how_to_get_h264(tmp_path, monkeypatch, caplog):
    monkeypatch.setitem(sys.modules, "av", None)
    video._say_how_to_get_h264.cache_clear()
    for name in ("one", "two"):
        write(tmp_path / f"{name}.mp4", moving(2))
    (record,) = caplog.records
    assert 'pip install "taskbuilder[film]"' in record.getMessage()


def test_frames_of_another_size_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"shape \(24, 32, 3\) in a film of \(48, 64, 3\)"):
        write(tmp_path / "film.mp4", [*moving(1), *moving(1, (32, 24))])
    with pytest.raises(ValueError, match="at least one frame"):
        write(tmp_path / "film.mp4", [])
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_film_has_no_frames(tmp_path, capfd):
    (tmp_path / "film.mp4").write_text("no film")
    assert frames_in(tmp_path / "film.mp4") == 0
    assert capfd.readouterr() == ("", "")


def gif(path):
    with Image.open(path) as picture:
        frames = []
        pauses = []
        for number in range(picture.n_frames):
            picture.seek(number)
            frames.append(np.array(picture.convert("RGB")))
            pauses.append(picture.info["duration"])
        return frames, pauses, picture.info.get("loop")


def test_a_gif_reads_back_and_plays_over_and_over(tmp_path):
    frames = moving(7)
    save_gif(tmp_path / "film.gif", frames, [n / 12 for n in range(7)], hold_s=1.0)
    read, pauses, loop = gif(tmp_path / "film.gif")
    assert len(read) == 7
    for frame, found in zip(frames, read, strict=True):
        assert abs(found.astype(int) - frame).max() <= 8
    assert pauses[-1] == 1000
    assert sum(pauses[:-1]) == 500  # no rounding adds up
    assert loop == 0


def test_a_gif_that_cannot_be_finished_is_not_begun(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError("the disk is full")

    monkeypatch.setattr(type(tmp_path), "replace", fail)
    with pytest.raises(OSError, match="full"):
        save_gif(tmp_path / "film.gif", moving(2), [0.0, 0.1], hold_s=1.0)
    assert list(tmp_path.iterdir()) == []


def test_what_stands_still_takes_no_room_in_a_gif(tmp_path):
    rng = np.random.default_rng(0)
    still = rng.integers(0, 255, (48, 64, 3), dtype=np.uint8)
    for count in (1, 20):
        frames = [still.copy() for _ in range(count)]
        for number, frame in enumerate(frames):
            frame[0, number] = 0
        save_gif(tmp_path / f"{count}.gif", frames, [n / 12 for n in range(count)], hold_s=1.0)
    one, twenty = ((tmp_path / f"{count}.gif").stat().st_size for count in (1, 20))
    assert twenty < 1.5 * one


def test_what_a_killed_film_left_is_swept_up_by_the_next(tmp_path):
    left = [tmp_path / name for name in (".film.0123abcd.mp4", ".film.gif.0123abcd")]
    others = [tmp_path / name for name in (".film.mp4", ".movie.0123abcd.mp4", ".film.0123.mp4")]
    for file in (*left, *others):
        file.write_bytes(b"half")
    write(tmp_path / "film.mp4", moving(2))
    save_gif(tmp_path / "film.gif", moving(2), [0.0, 0.1], hold_s=0.1)
    found = {file.name for file in tmp_path.iterdir()}
    assert found == {"film.mp4", "film.gif", *(file.name for file in others)}


def test_a_film_that_another_process_still_writes_is_left_alone(tmp_path):
    with mp4(tmp_path / "film.mp4", fps=24) as add:
        add(moving(1)[0])
        write(tmp_path / "film.mp4", moving(2))  # locks are a file's, so this is as another process
        assert len(list(tmp_path.glob(".film.*"))) == 1
    assert frames_in(tmp_path / "film.mp4") == 1


def test_a_process_that_is_killed_in_a_film_leaves_nothing_for_good(tmp_path):
    code = (
        "import os, sys; from pathlib import Path; from taskbuilder.visual.video import mp4\n"
        "with mp4(Path(sys.argv[1]), fps=24): os.kill(os.getpid(), 9)\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "film.mp4")]
    assert subprocess.run(command, check=False).returncode == -9
    assert len(list(tmp_path.glob(".film.*"))) == 1
    write(tmp_path / "film.mp4", moving(2))
    assert [file.name for file in tmp_path.iterdir()] == ["film.mp4"]
