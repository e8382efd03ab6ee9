"""A film of an episode: an MP4, and a GIF for pages that take only pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.rollout.record import Rollout
from taskbuilder.visual.capture import FPS, Frame, capture_frames
from taskbuilder.visual.overlay import compose
from taskbuilder.visual.still import Pixels
from taskbuilder.visual.strip import fitting, shown_cameras
from taskbuilder.visual.video import GIF_COLORS, mp4, save_gif

Progress = Callable[[Iterable[Frame], int], Iterable[Frame]]

WIDTH = 480
"""Of a camera's picture, in pixels, where no size is asked for."""

HOLD_S = 1.0
"""How long the last frame stays."""

GIF_FPS = 12
MOST_GIF_FRAMES = 150
"""A longer episode has fewer frames a second in its GIF."""


def save_film(
    env: TaskEnv,
    rollout: Rollout,
    cameras: Sequence[str],
    stem: Path,
    *,
    size: tuple[int, int] | None = None,
    fps: int | None = None,
    gif: bool = True,
    gif_colors: int = GIF_COLORS,
    progress: Progress = lambda frames, _: frames,
) -> tuple[Path, ...]:
    """Replay an episode to its end and film it.

    Args:
        env: As for `replay`; may draw through OpenGL.
        rollout: The episode.
        cameras: Of the scene, each once, side by side if there are several; by default the first.
        stem: Path of the files without their endings.
        size: Width and height of each picture; by default 480 wide and as high as the first
            camera's proportions have it.
        fps: Frames a second; by default 24, or one a physics step where those are fewer.
        gif: Also write a GIF of every second frame or fewer.
        gif_colors: Size of the GIF's palette, at most 255; fewer colours make a smaller file.
        progress: Passes the frames on; given how many there will be, too.

    Returns:
        The files: an MP4, and the GIF.

    Raises:
        UsageError: The environment is of another task.
        UnknownNameError: The scene has no such camera.
        OSError: A file cannot be written; the other may be there.
    """
    fps = fps or min(FPS, env.task.file.spec.timing.physics_hz)
    cameras = shown_cameras(env, cameras)
    size = size or fitting(env.episode.world.scene.cameras[cameras[0]].size, WIDTH)
    length = round(rollout.seconds(rollout.steps) * fps)
    every = max(round(fps / GIF_FPS), -(-length // MOST_GIF_FRAMES), 1)
    kept: list[Pixels] = []
    times: list[float] = []
    film, picture = stem.with_name(f"{stem.name}.mp4"), stem.with_name(f"{stem.name}.gif")
    with mp4(film, fps=fps) as add:
        frames = capture_frames(env, rollout, cameras, size=size, fps=fps)
        for number, frame in enumerate(progress(frames, length + 1)):
            composed = compose(frame, rollout)
            add(composed)
            if gif and (number % every == 0 or number == length):
                kept.append(composed)
                times.append(frame.seconds)
        for _ in range(round(HOLD_S * fps)):
            add(composed)
    if not gif:
        return (film,)
    save_gif(picture, kept, times, hold_s=HOLD_S, colors=gif_colors)
    return film, picture
