"""Videos of episodes: colour in H.264, depth in FFV1, made and read in memory.

Both are lossless. Policies learn from recorded images and are evaluated on those of the
environment, and in small images what a lossy codec does to colours is as large as a small object:
after training on them, policies did not find it. Rendered images are plain, so that two to four
times the space of a lossy video suffices. Depth is 16-bit grey, in millimetres, at most 65.5 m.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.data.extras import extra_needed
from taskbuilder.errors import TaskbuilderError

Frames = NDArray[np.uint8]

VIDEO, DEPTH = ".mp4", ".depth.mkv"
"""How the files of a camera end."""

_LOSSLESS = {
    "qp": "0",
    "preset": "slower",  # takes 0.3 ms a frame more than the fastest, and 30 % less space
    "g": "30",  # a key frame every 30 frames: what reads one frame decodes at most 29 others
    "bf": "0",
    "x264-params": "threads=1:sliced-threads=0",  # or the bytes would depend on the machine
}


class VideoError(TaskbuilderError):
    """A video cannot be read."""


def require_video() -> None:
    """Check that videos can be made here.

    Raises:
        UsageError: PyAV is not installed.
    """
    with extra_needed("recording cameras"):
        import av  # noqa: F401  # only to see whether it is installed


def encoded(frames: Sequence[Frames], fps: int) -> bytes:
    """An MP4 file of colour images.

    Args:
        frames: (height, width, 3) each.
        fps: Frames a second.
    """
    return _written(frames, fps, "mp4", "libx264rgb", ("rgb24", "rgb24"), _LOSSLESS)


def encoded_depth(depths: Sequence[NDArray[np.float32]], fps: int) -> bytes:
    """A Matroska file of depth images.

    Args:
        depths: (height, width) each, in metres.
        fps: Frames a second.
    """
    frames = [np.clip(np.rint(depth * 1000.0), 0, 65535).astype(np.uint16) for depth in depths]
    options = {"threads": "1", "level": "3", "slicecrc": "1"}
    return _written(frames, fps, "matroska", "ffv1", ("gray16le", "gray16le"), options)


def _written(
    frames: Sequence[NDArray[Any]],
    fps: int,
    container: str,
    codec: str,
    formats: tuple[str, str],
    options: dict[str, str],
) -> bytes:
    with extra_needed("recording cameras"):
        import av
    file = io.BytesIO()
    # bitexact: the file does not tell when it was made.
    with av.open(file, "w", format=container, options={"fflags": "+bitexact"}) as output:
        stream: Any = output.add_stream(codec, rate=fps, options=options)
        stream.height, stream.width = frames[0].shape[:2]
        stream.pix_fmt = formats[1]
        stream.codec_context.thread_count = 1
        stream.codec_context.flags |= int(av.codec.context.Flags.bitexact)
        for number, image in enumerate(frames):
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format=formats[0])
            frame.pts, frame.time_base = number, Fraction(1, fps)
            output.mux(stream.encode(frame))
        output.mux(stream.encode(None))
    return file.getvalue()


def decoded(content: bytes) -> Frames:
    """The images of a colour video: (frames, height, width, 3) uint8.

    Raises:
        VideoError: It is damaged.
        UsageError: PyAV is not installed.
    """
    # The format they are stored in: a conversion by FFmpeg would start threads for every image.
    return np.stack([frame.to_ndarray(format="gbrp") for frame in _frames(content)])


def decoded_depth(content: bytes) -> NDArray[np.float32]:
    """The images of a depth video, in metres: (frames, height, width) float32.

    Raises:
        VideoError: It is damaged.
        UsageError: PyAV is not installed.
    """
    frames = [frame.to_ndarray(format="gray16le") for frame in _frames(content)]
    return np.stack(frames).astype(np.float32) / np.float32(1000.0)


def _frames(content: bytes) -> list[Any]:
    with extra_needed("reading cameras"):
        import av
    try:
        with av.open(io.BytesIO(content), "r") as file:
            file.streams.video[0].thread_count = 1
            found = list(file.decode(video=0))
    except (av.FFmpegError, IndexError) as error:
        raise VideoError(f"a video is damaged ({error})") from None
    if not found:
        raise VideoError("a video has no frames")
    return found


def png(image: Frames) -> bytes:
    """A PNG file of a colour image: (height, width, 3)."""
    import cv2

    _, content = cv2.imencode(".png", np.ascontiguousarray(image[:, :, ::-1]))
    return content.tobytes()


def joined(contents: Sequence[bytes], fps: int, *, without_last: bool = False) -> bytes:
    """One MP4 file of several, one after the other, without encoding them anew.

    Args:
        contents: Videos of `encoded`, of one size.
        fps: Frames a second.
        without_last: Leave out the last frame of each.

    Raises:
        VideoError: One of them is damaged.
    """
    with extra_needed("exporting cameras"):
        import av
    file = io.BytesIO()
    shown = 0
    try:
        with av.open(file, "w", format="mp4", options={"fflags": "+bitexact"}) as output:
            stream: Any = None
            for content in contents:
                with av.open(io.BytesIO(content), "r") as source:
                    if stream is None:
                        template = source.streams.video[0]
                        stream = output.add_stream_from_template(template, opaque=True)
                    packets = list(_packets(source))
                    for packet in packets[: -1 if without_last else None]:
                        tick = Fraction(1, fps) / packet.time_base
                        packet.pts = packet.dts = int(shown * tick)  # no frame refers to a later
                        packet.stream = stream
                        output.mux(packet)
                        shown += 1
    except av.FFmpegError as error:
        raise VideoError(f"a video is damaged ({error})") from None
    return file.getvalue()


def _packets(source: Any) -> Iterator[Any]:
    return (packet for packet in source.demux(video=0) if packet.dts is not None)
