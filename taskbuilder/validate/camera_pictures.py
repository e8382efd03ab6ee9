"""Observed pictures, compared with what their cameras see."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from taskbuilder.cameras import CameraView, Image
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.env.spaces import image_values
from taskbuilder.schema.channels import CAMERA_QUANTITIES, Channel
from taskbuilder.world.pictures import capture

MOVED = 0.05
"""How far something in a picture must move, as a share of its height, to change it for sure."""

MOVED_PIXELS = 2.0
"""The same in pixels; both count."""

_QUANTITIES = {"pixels": "rgb"}
"""What a joint observation calls images, where it is not the quantity of the channel."""

_NONE = np.zeros(0)


class CameraPictures:
    """Compares observed pictures with new ones.

    Args:
        env: The environment of the cameras.
        most: Number of steps whose pictures are compared, as drawing them takes time.
    """

    def __init__(self, env: TaskEnv, most: int) -> None:
        self._env = env
        self._most = most
        self._firsts: dict[str, tuple[NDArray[Any], NDArray[np.float64]]] = {}
        self._still: dict[str, float] = {}
        self._steps: dict[str, int] = {}

    def compare(self, agent: str, seen: Any, where: str) -> Iterator[tuple[str, str]]:
        """The camera channels that differ from what their cameras see, and how, in words.

        Args:
            agent: The agent.
            seen: What it observes.
            where: The seed and the step, in words.
        """
        steps = self._steps[agent] = self._steps.get(agent, 0) + 1
        drawn: dict[str, tuple[Image, CameraView]] = {}
        for channel, picture in pictures_in(seen):
            camera, name = channel.subject, f"{channel.subject}.{channel.quantity}"
            if camera not in self._env.episode.world.scene.cameras:
                continue
            self.note(f"{agent}: {name}", picture, self._view(camera))
            if steps > self._most:
                continue
            drawn[camera] = drawn.get(camera) or self._drawn(camera)
            expected = image_values(channel, *drawn[camera])
            if picture.shape != expected.shape:
                continue  # a wrapper gives other pictures, in a space of its own
            if not same_picture(picture, expected):
                yield (
                    f"{agent}: {name}",
                    f"{agent} sees another picture in {name} than its camera {where}; draw it anew "
                    "in every step",
                )

    def note(self, name: str, picture: NDArray[Any], view: CameraView) -> None:
        """Note whether a picture is still the first one, although things in it have moved."""
        points = self._points(view)
        if name not in self._firsts:
            self._firsts[name] = picture.copy(), points
            self._still[name] = 0.0
            return
        first, before = self._firsts[name]
        if not np.array_equal(picture, first):
            self._still[name] = -1.0
        elif self._still[name] >= 0.0:
            size = np.array((view.width, view.height))
            inside = ((before > 0) & (before < size) & (points > 0) & (points < size)).all(axis=1)
            moved = float(np.linalg.norm(points - before, axis=1)[inside].max(initial=0.0))
            if moved > MOVED_PIXELS:
                self._still[name] = max(self._still[name], moved / view.height)

    def note_rendered(self, picture: NDArray[np.uint8]) -> None:
        """Note a picture of `render`, as `note` does."""
        view = self._view_of_render()
        if picture.shape == (view.height, view.width, 3):  # else, that of a wrapper
            self.note("render", picture, view)

    def check_rendered(self, env: Any, where: str) -> str:
        """What is wrong with the picture of `render` now, in words, or "".

        Args:
            env: The environment. The pictures of one with wrappers may be drawn on.
            where: The seed and the step, in words.
        """
        world, view = self._env.episode.world, self._view_of_render()
        picture = env.render()
        if wrong_with(picture):
            return f"render gives {wrong_with(picture)} {where}"
        self.note_rendered(picture)
        if env is not getattr(env, "unwrapped", env):
            return ""
        world.move_markers()
        image = capture(world, view, studio=True, shadow=True)
        if picture.shape == image.rgb.shape and same_picture(picture, image.rgb):
            return ""
        return (
            f"render gives another picture than its camera has {where}; draw it anew at every call"
        )

    def _view_of_render(self) -> CameraView:
        world = self._env.episode.world
        return world.camera(self._env.options.render_camera or next(iter(world.scene.cameras)))

    def unchanged(self) -> dict[str, str]:
        """The pictures that never changed although things in them moved, in words."""
        return {
            name: f"{name} never changes, although things in it move by {share:.0%} of its height; "
            "draw it anew in every step"
            for name, share in self._still.items()
            if share > MOVED
        }

    def _view(self, camera: str) -> CameraView:
        env = self._env
        size = env.options.camera_size or env.task.file.spec.scene.cameras[camera].size
        return env.episode.world.camera(camera, size)

    def _drawn(self, camera: str) -> tuple[Image, CameraView]:
        world, view = self._env.episode.world, self._view(camera)
        world.move_markers()
        return capture(world, view), view

    def _points(self, view: CameraView) -> NDArray[np.float64]:
        """Where the robots' links and tools are in a picture: (n, 2), in pixels."""
        world = self._env.episode.world
        places = [
            position
            for robot in world.robots.values()
            for position in (
                robot.tcp.position,
                *(frame.position for frame in robot.arm_frames()),
            )
        ]
        flat = np.array([view.pose.inverse().apply(place) for place in places])
        depth = np.maximum(flat[:, 2:], 1e-6)
        focal = view.height / 2.0 / np.tan(np.radians(view.fov_deg) / 2.0)
        points = flat[:, :2] / depth * focal + np.array((view.width, view.height)) / 2.0
        return np.where(flat[:, 2:] > view.near, points, -1.0)


def pictures_in(seen: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[Channel, NDArray[Any]]]:
    """The pictures of an observation, and the camera channel of each."""
    for key, part in seen.items() if isinstance(seen, Mapping) else ():
        here = (*path, *str(key).split("/"))
        if isinstance(part, Mapping):
            yield from pictures_in(part, here)
        elif np.ndim(part) >= 2:
            camera, _, quantity = here[-1].rpartition(".")
            if not camera:  # of a joint observation: pixels/front, or {"pixels": {"front": ...}}
                quantity, camera = here[-2] if len(here) > 1 else "", here[-1]
            quantity = _QUANTITIES.get(quantity, quantity)
            if quantity in CAMERA_QUANTITIES:
                yield Channel(camera, quantity), np.asarray(part)


def numeric_parts(seen: Any) -> Iterator[NDArray[np.float64]]:
    """The numbers of an observation in order, without its pictures."""
    if isinstance(seen, Mapping):
        for part in seen.values():
            yield from numeric_parts(part)
    elif np.ndim(seen) <= 1:
        yield np.asarray(seen, dtype=np.float64).ravel()


def number_bounds(seen: Any, space: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The least and the largest of each number in `numeric_parts`; infinite where no Box says."""
    if isinstance(seen, Mapping):
        known = space.spaces if isinstance(space, spaces.Dict) else {}
        parts = [number_bounds(part, known.get(key)) for key, part in seen.items()]
        lows, highs = ([part[end] for part in parts] for end in (0, 1))
        return np.concatenate([_NONE, *lows]), np.concatenate([_NONE, *highs])
    if np.ndim(seen) > 1:
        return _NONE, _NONE
    size = np.size(seen)
    if isinstance(space, spaces.Box) and space.low.size == size:
        return space.low.ravel().astype(np.float64), space.high.ravel().astype(np.float64)
    return np.full(size, -np.inf), np.full(size, np.inf)


def same_picture(one: NDArray[Any], other: NDArray[Any]) -> bool:
    """Whether two pictures are the same up to a few pixels, as some renderers round."""
    apart = np.abs(one.astype(np.float64) - other.astype(np.float64))
    limit = 3.0 if one.dtype == np.uint8 else 1e-3
    return float((apart > limit).mean()) < 0.002


def wrong_with(picture: Any) -> str:
    """What a picture is instead of one, in words, or ""."""
    if not isinstance(picture, np.ndarray):
        return "nothing" if picture is None else type(picture).__name__
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3 or not picture.size:
        return f"an array {picture.shape} of {picture.dtype}"
    if (picture == picture[0, 0]).all():
        return f"one colour, {'black' if not picture.any() else tuple(picture[0, 0].tolist())}"
    return ""
