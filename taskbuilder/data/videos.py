"""Videos of episodes: colour in H.264, depth in FFV1, made and read in memory.

Both are lossless. Policies learn from recorded images and are evaluated on those of the
environment, and in small images what a lossy codec does to colours is as large as a small object:
after training on them, policies did not find it. Rendered images are plain, so that two to four
times the space of a lossy video suffices. Depth is 16-bit grey, in millimetres, at most 65.5 m.
"""

from __future__ import annotations

import errno
import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import TaskbuilderError
from taskbuilder.extras import extra_needed

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
    with extra_needed("data", "recording cameras"):
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
    with extra_needed("data", "recording cameras"):
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


class VideoSize(NamedTuple):
    """What a video must be, as its data set says.

    Attributes:
        width: Width in pixels.
        height: Height in pixels.
        frames: Number of images.
    """

    width: int
    height: int
    frames: int

    @property
    def decoded_bytes(self) -> int:
        """Bytes of all colour images."""
        return self.width * self.height * self.frames * 3

    @property
    def largest_file(self) -> int:
        """Most bytes that its file can have."""
        return min(2 * self.decoded_bytes + (1 << 20), _LARGEST_FILE)


def images_of(content: bytes, size: VideoSize) -> Iterator[Frames]:
    """The images of a colour video, one after the other: (height, width, 3) uint8 each.

    Args:
        content: The file.
        size: What the video must be.

    Raises:
        VideoError: It is damaged, or not what it must be.
        UsageError: PyAV is not installed.
    """
    # The format they are stored in: a conversion by FFmpeg would start threads for every image.
    return (frame.to_ndarray(format="gbrp") for frame in _frames(content, _COLOUR, size))


def depths_of(content: bytes, size: VideoSize) -> Iterator[NDArray[np.float32]]:
    """The images of a depth video, one after the other, in metres: (height, width) float32 each.

    Raises:
        VideoError: It is damaged, or not what it must be.
        UsageError: PyAV is not installed.
    """
    for frame in _frames(content, _DEPTH, size):
        yield frame.to_ndarray(format="gray16le").astype(np.float32) / np.float32(1000.0)


def stacked(images: Iterator[NDArray[Any]], size: VideoSize) -> NDArray[Any]:
    """All images of a video as one array: (frames, height, width, ...).

    Raises:
        VideoError: The video is damaged, not what it must be, or too large for this.
    """
    if size.decoded_bytes > LARGEST_STACK:
        raise VideoError(
            f"{size.frames} images of {size.width}x{size.height} pixels do not fit into "
            f"{LARGEST_STACK >> 20} MiB; read them one after the other"
        )
    return np.stack(list(images))


def check_header(content: bytes, size: VideoSize, *, depth: bool = False) -> None:
    """Check what the header of a video says.

    Args:
        content: The file.
        size: What the video must be.
        depth: Whether it is a depth video.

    Raises:
        VideoError: It is damaged, or not what it must be.
        UsageError: PyAV is not installed.
    """
    with extra_needed("data", "reading cameras"):
        import av
    try:
        with _opened(content, _DEPTH if depth else _COLOUR, size):
            pass
    except (av.FFmpegError, *_DAMAGED) as error:
        raise VideoError(_damaged(error)) from None


def _damaged(error: Exception) -> str:
    """What is wrong with a video, without the number and the empty file name of FFmpeg's errors."""
    return f"a video is damaged ({getattr(error, 'strerror', None) or error})"


class _Kind(NamedTuple):
    container: str
    codec: str
    format: str


_COLOUR, _DEPTH = _Kind("mp4", "h264", "gbrp"), _Kind("matroska", "ffv1", "gray16le")

LARGEST_STACK = 1 << 30
"""Most bytes of images that are held in memory at a time."""

LARGEST_SIDE = 2048
"""Most pixels of the width and the height of a video."""

_LARGEST_FILE = 128 << 20


def _frames(content: bytes, kind: _Kind, size: VideoSize) -> Iterator[Any]:
    with extra_needed("data", "reading cameras"):
        import av
    count = 0
    try:
        with _opened(content, kind, size) as file:
            for frame in file.decode(video=0):
                count += 1
                shape = frame.width, frame.height, frame.format.name
                if shape != (size.width, size.height, kind.format):
                    raise VideoError(_not_as_recorded("{}x{} pixels of {}".format(*shape), size))
                if count > size.frames:
                    raise VideoError(_not_as_recorded("more images", size))
                yield frame
    except (av.FFmpegError, *_DAMAGED) as error:
        raise VideoError(_damaged(error)) from None
    if count < size.frames:
        raise VideoError(_not_as_recorded(f"{count} images", size))


@contextmanager
def _opened(content: bytes, kind: _Kind, size: VideoSize) -> Iterator[Any]:
    """Open a video that may come from anybody, and check what its header says.

    FFmpeg guesses the format of a file unless it is named, and a playlist would have it open other
    files or ports. It reads here from memory, as one format, and whatever it wants to open besides
    is refused. It decodes a few images to find out what they are, so that their size is limited
    before it begins: to what was recorded, and a margin for how FFmpeg aligns rows.
    """
    import av

    limits = {"max_pixels": str((size.width + 128) * (size.height + 128)), "threads": "1"}
    with av.open(
        io.BytesIO(content),
        "r",
        format=kind.container,
        options=limits,  # of the streams, too
        container_options={**_LIMITS, **_NO_REFERENCES.get(kind.container, {})},
        io_open=_refuse,
    ) as file:
        streams = [(stream.type, _codec(stream)) for stream in file.streams]
        if streams != [("video", kind.codec)]:
            listed = ", ".join(f"{type_} ({codec})" for type_, codec in streams) or "nothing"
            raise VideoError(
                f"a video is damaged: it has {listed}; one {kind.codec} video is right"
            )
        stream = file.streams.video[0]
        context = stream.codec_context
        if (context.width, context.height) != (size.width, size.height):
            raise VideoError(_not_as_recorded(f"{context.width}x{context.height} pixels", size))
        if stream.frames and stream.frames != size.frames:
            raise VideoError(_not_as_recorded(f"{stream.frames} images", size))
        context.options = limits
        context.thread_count = 1
        yield file


def _codec(stream: Any) -> str:
    """The codec of a stream; one that PyAV does not know has no context."""
    return stream.codec_context.name if stream.codec_context is not None else "unknown"


_DAMAGED = (IndexError, MemoryError, OSError, OverflowError, ValueError)
"""What PyAV raises of a damaged video besides its own errors."""

_LIMITS = {"max_streams": "1", "protocol_whitelist": "none"}
_NO_REFERENCES = {"mp4": {"enable_drefs": "0", "use_absolute_path": "0"}}
"""References of MP4 files to images that are in other files."""


def _refuse(*_: object) -> None:
    raise PermissionError(errno.EACCES, "a video must not open other files")


def _not_as_recorded(what: str, size: VideoSize) -> str:
    right = f"{size.frames} images of {size.width}x{size.height} pixels"
    return f"a video has {what}; {right} were recorded"


def png(image: Frames) -> bytes:
    """A PNG file of a colour image: (height, width, 3)."""
    import cv2

    _, content = cv2.imencode(".png", np.ascontiguousarray(image[:, :, ::-1]))
    return content.tobytes()


def joined(
    contents: Sequence[tuple[bytes, VideoSize]], fps: int, *, without_last: bool = False
) -> bytes:
    """One MP4 file of several, one after the other, without encoding them anew.

    Args:
        contents: Videos of `encoded`, and what each must be; all have one width and height.
        fps: Frames a second.
        without_last: Leave out the last frame of each.

    Raises:
        VideoError: One of them is damaged.
    """
    with extra_needed("data", "exporting cameras"):
        import av
    file = io.BytesIO()
    frames = 0
    try:
        with av.open(file, "w", format="mp4", options={"fflags": "+bitexact"}) as output:
            stream: Any = None
            for content, size in contents:
                with _opened(content, _COLOUR, size) as source:
                    if stream is None:
                        template = source.streams.video[0]
                        stream = output.add_stream_from_template(template, opaque=True)
                    packets = list(_packets(source))
                    for packet in packets[: -1 if without_last else None]:
                        tick = Fraction(1, fps) / packet.time_base
                        packet.pts = packet.dts = int(frames * tick)  # no frame refers to a later
                        packet.stream = stream
                        output.mux(packet)
                        frames += 1
    except (av.FFmpegError, *_DAMAGED) as error:
        raise VideoError(_damaged(error)) from None
    return file.getvalue()


def _packets(source: Any) -> Iterator[Any]:
    return (packet for packet in source.demux(video=0) if packet.dts is not None)
