"""Films as files, written whole or not at all."""

from __future__ import annotations

import io
import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np

from taskbuilder.files import kept_aside, write_whole
from taskbuilder.quiet import HINTS, captured
from taskbuilder.visual.still import Pixels

CODECS = ("vp09", "mp4v")
"""Of OpenCV, where PyAV is not installed, in the order in which they are tried: browsers play VP9.

OpenCV's packages have no H.264. With PyAV, films are H.264, which is written twenty times as fast.
"""

HOW_TO_GET_H264 = 'pip install "taskbuilder[film]"'

_log = logging.getLogger(HINTS)

_H264 = {
    "crf": "18",  # what differs from the frames is not seen
    "preset": "veryfast",
    "x264-params": "threads=1:sliced-threads=0",  # or the bytes would depend on the machine
}

GIF_COLORS = 255  # one of 256 is left for what has not changed
_SAMPLES = 12  # frames that choose a GIF's colours


@contextmanager
def mp4(path: Path, *, fps: int) -> Iterator[Callable[[Pixels], None]]:
    """Write an MP4 frame by frame; the file is there once the block has ended well.

    ::

        with mp4(path, fps=30) as add:
            add(frame)

    All frames have the size of the first; width and height should be even.

    Args:
        path: The file.
        fps: Frames a second.

    Raises:
        OSError: It cannot be written, or no codec is there.
        ValueError: There was no frame, or one of another size.
    """
    with kept_aside(path, f".{path.stem}", ".mp4") as aside:
        reel = _Reel(aside, fps)
        try:
            yield reel.add
            reel.finish()
        finally:
            reel.stop()


class _FilmWriter(Protocol):
    """Writes frames of one size to a file."""

    def write(self, frame: Pixels) -> None:
        """Add a frame."""

    def close(self) -> None:
        """Complete the file."""


class _Reel:
    """A video file that is being written."""

    def __init__(self, path: Path, fps: int) -> None:
        self._path, self._fps = path, fps
        self._writer: _FilmWriter | None = None
        self._shape: tuple[int, ...] = ()
        self._count = 0

    def add(self, frame: Pixels) -> None:
        if self._writer is None:
            self._writer, self._shape = _open(self._path, self._fps, frame), frame.shape
        if frame.shape != self._shape:
            raise ValueError(f"a frame of shape {frame.shape} in a film of {self._shape}")
        self._writer.write(frame)
        self._count += 1

    def stop(self) -> None:
        if self._writer is not None:
            self._writer.close()
            self._writer = None

    def finish(self) -> None:
        """Close the file, and see that it can be read."""
        if not self._count:
            raise ValueError("a film needs at least one frame")
        self.stop()
        found = frames_in(self._path)
        if found != self._count:
            raise OSError(f"{self._path.name}: {found} of {self._count} frames could be read back")


def _open(path: Path, fps: int, frame: Pixels) -> _FilmWriter:
    try:
        import av

        av.Codec("libx264", "w")
    except (ImportError, ValueError):  # not installed, or built without this codec
        _say_how_to_get_h264()
        return _OpenCV(path, fps, frame)
    return _PyAV(path, fps, frame)


@cache
def _say_how_to_get_h264() -> None:
    """Say it once."""
    _log.warning("films are VP9; with %s they are H.264, written much faster", HOW_TO_GET_H264)


class _PyAV:
    """Writes H.264."""

    def __init__(self, path: Path, fps: int, frame: Pixels) -> None:
        import av

        self._av, self._fps, self._count = av, fps, 0
        # bitexact: the file does not tell when it was made; faststart: it plays while it loads.
        flags = {"fflags": "+bitexact", "movflags": "+faststart"}
        self._file = av.open(str(path), "w", format="mp4", options=flags)
        stream: Any = self._file.add_stream("libx264", rate=fps, options=_H264)
        stream.height, stream.width = frame.shape[:2]
        stream.pix_fmt = "yuv420p"
        stream.codec_context.thread_count = 1
        stream.codec_context.flags |= int(av.codec.context.Flags.bitexact)
        self._stream = stream

    def write(self, frame: Pixels) -> None:
        image = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")
        image.pts, image.time_base = self._count, Fraction(1, self._fps)
        self._count += 1
        self._file.mux(self._stream.encode(image))

    def close(self) -> None:
        try:
            self._file.mux(self._stream.encode(None))
        finally:
            self._file.close()


class _OpenCV:
    """Writes the first of `CODECS` that is there.

    Raises:
        OSError: None is.
    """

    def __init__(self, path: Path, fps: int, frame: Pixels) -> None:
        height, width = frame.shape[:2]
        for codec in CODECS:
            with captured():  # a codec that is not there is complained of at length
                code = cv2.VideoWriter.fourcc(*codec)
                size = (width, height)
                writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, code, float(fps), size)
            if writer.isOpened():
                self._writer = writer
                return
            writer.release()
        raise OSError(f"this build of OpenCV writes no MP4 with {' or '.join(CODECS)}")

    def write(self, frame: Pixels) -> None:
        self._writer.write(np.ascontiguousarray(frame[:, :, ::-1]))

    def close(self) -> None:
        with captured():
            self._writer.release()


def frames_in(path: Path) -> int:
    """How many frames of a film can be read."""
    with captured():
        film = cv2.VideoCapture(str(path))
        count = 0
        while film.grab():
            count += 1
        film.release()
    return count


def _weighted(sample: Pixels) -> Pixels:
    """The pixels, and again as many, in which each colour has a share that grows with its chroma.

    By their number alone, walls and tables would get all of a small palette, and a cube of a few
    pixels would lose its colour.
    """
    pixels = sample.reshape(-1, 3)
    each = _colors(pixels)
    chroma = np.ptp(each, axis=1).astype(int)
    return np.vstack([pixels, np.resize(np.repeat(each, 1 + chroma, axis=0), pixels.shape)])[None]


def _colors(pixels: Pixels) -> Pixels:
    """The different colours of pixels, sorted; a table of all colours finds them fastest.

    Args:
        pixels: (count, 3).
    """
    seen = np.zeros(1 << 24, dtype=np.bool_)
    red, green, blue = pixels.astype(np.uint32).T
    seen[red << 16 | green << 8 | blue] = True
    found = np.flatnonzero(seen)
    return np.stack([found >> 16, found >> 8, found], axis=1).astype(np.uint8)


def save_gif(
    path: Path,
    frames: Sequence[Pixels],
    times_s: Sequence[float],
    *,
    hold_s: float,
    colors: int = GIF_COLORS,
) -> None:
    """Write a GIF that plays over and over, whole or not at all.

    One palette serves all frames, and nothing is dithered: what does not move then stays the same
    to the bit, and takes hardly any room in the file.

    Args:
        path: The file.
        frames: All of one size, RGB.
        times_s: When each is shown.
        hold_s: How long the last is shown.
        colors: Size of the palette, at most `GIF_COLORS`.

    Raises:
        OSError: It cannot be written.
    """
    from PIL import Image  # films without a GIF do without it

    # GIF counts hundredths of a second: each time is rounded, not each pause, so that none adds up.
    ticks = [round(100 * time) for time in (*times_s, times_s[-1] + hold_s)]
    pauses = [10 * (end - start) for start, end in pairwise(ticks)]
    step = -(-len(frames) // _SAMPLES)
    sample = Image.fromarray(_weighted(np.vstack([*frames[::step], frames[-1]])))
    palette = sample.quantize(colors, method=Image.Quantize.MEDIANCUT)
    first, *others = (
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    )
    file = io.BytesIO()
    first.save(
        file,
        "GIF",
        save_all=True,
        append_images=others,
        duration=pauses,
        loop=0,
        disposal=1,
        optimize=True,
        palette=bytes(palette.getpalette() or ()),
    )
    write_whole(path, file.getvalue())
