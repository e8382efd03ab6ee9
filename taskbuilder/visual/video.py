"""Films as files, written whole or not at all."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np

from taskbuilder.files import kept_aside, write_whole
from taskbuilder.quiet import captured
from taskbuilder.visual.still import Pixels

CODECS = ("vp09", "mp4v")
"""In the order in which they are tried: VP9 is what browsers play."""

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


class _Reel:
    """A video file that is being written."""

    def __init__(self, path: Path, fps: int) -> None:
        self._path, self._fps = path, fps
        self._writer: cv2.VideoWriter | None = None
        self._shape: tuple[int, ...] = ()
        self._count = 0

    def add(self, frame: Pixels) -> None:
        if self._writer is None:
            self._writer, self._shape = _open(self._path, self._fps, frame), frame.shape
        if frame.shape != self._shape:
            raise ValueError(f"a frame of shape {frame.shape} in a film of {self._shape}")
        self._writer.write(np.ascontiguousarray(frame[:, :, ::-1]))
        self._count += 1

    def stop(self) -> None:
        if self._writer is not None:
            with captured():
                self._writer.release()
            self._writer = None

    def finish(self) -> None:
        """Close the file, and see that it can be read."""
        if not self._count:
            raise ValueError("a film needs at least one frame")
        self.stop()
        found = frames_in(self._path)
        if found != self._count:
            raise OSError(f"{self._path.name}: {found} of {self._count} frames could be read back")


def _open(path: Path, fps: int, frame: Pixels) -> cv2.VideoWriter:
    height, width = frame.shape[:2]
    for codec in CODECS:
        with captured():  # a codec that is not there is complained of at length
            code = cv2.VideoWriter.fourcc(*codec)
            writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, code, float(fps), (width, height))
        if writer.isOpened():
            return writer
        writer.release()
    raise OSError(f"this build of OpenCV writes no MP4 with {' or '.join(CODECS)}")


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
    each = np.unique(pixels, axis=0)
    chroma = np.ptp(each, axis=1).astype(int)
    return np.vstack([pixels, np.resize(np.repeat(each, 1 + chroma, axis=0), pixels.shape)])[None]


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
