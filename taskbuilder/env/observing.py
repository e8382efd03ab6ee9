"""Observations of all agents and the centralised state, read from an episode."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from taskbuilder.cameras import CameraView, Image
from taskbuilder.env.camera import Camera, camera_of, with_noise
from taskbuilder.env.drawn_values import drawn_values
from taskbuilder.env.episode import Episode
from taskbuilder.env.observations import (
    POSITIONS,
    Reading,
    View,
    is_camera,
    make_reading,
    with_position_noise,
)
from taskbuilder.env.options import Options
from taskbuilder.env.spaces import VECTOR, image_values, observation_space
from taskbuilder.env.whole_scene import everything, surroundings
from taskbuilder.errors import UsageError
from taskbuilder.schema.channels import Channel, default_channels, parse_channel
from taskbuilder.schema.names import NameProblem
from taskbuilder.schema.task import Noise
from taskbuilder.task import Task
from taskbuilder.world.pictures import capture
from taskbuilder.world.world import World

_Look = tuple[Image, CameraView]


class Observer:
    """Makes the observations of all agents and the centralised state.

    Args:
        task: The task.
        options: The options of the environment.
        world: The world of any variation; all variations have the same bodies.

    Attributes:
        positions: The agents that observe positions.
    """

    def __init__(self, task: Task, options: Options, world: World) -> None:
        spec, names = task.file.spec, task.file.names
        self._flat = options.flat
        listed = spec.observe or {agent: default_channels(names, agent) for agent in task.agents}
        if options.observe == "scene":
            listed = {agent: surroundings(agent, world) for agent in task.agents}
        extra = tuple(f"{camera}.rgb" for camera in options.cameras)
        self._task, self._world = task, world
        self._own_frames, self._matrices = options.frame == "base", options.rotation == "matrix"
        levels = options.disturbance_levels
        self._log = options.distances == "log"
        self._position_noise = math.hypot(options.position_noise, levels.get("state_noise", 0.0))
        self._image_noise = levels.get("image_noise", 0.0)
        self.positions: set[str] = set()
        self._views = {
            agent: self._view((*listed[agent], *extra), agent, spec.observation_noise.get(agent))
            for agent in task.agents
        }
        whole = spec.state == ("all",)
        self._state = self._view(everything(world) if whole else spec.state, None, None)
        if whole:
            drawn = tuple(drawn_values(world, options))
            self._state = View((*self._state.readings, *drawn), ())
        if self._state.cameras:
            raise UsageError("the centralised state is made of numbers; leave cameras out of it")
        self._sizes = {
            name: options.camera_size or camera.size for name, camera in spec.scene.cameras.items()
        }
        self._furthest = {
            name: max(scene.cameras[name].far_plane for scene in task.file.scenes)
            for name in self._sizes
        }

    @property
    def pictures(self) -> frozenset[str]:
        """What agents observe of cameras."""
        return frozenset(each.quantity for view in self._views.values() for each in view.cameras)

    def agent_spaces(self) -> dict[str, spaces.Space[Any]]:
        """The observation space of every agent."""
        return {
            agent: observation_space(
                view, self._sizes, self._furthest, len(self._world.segments.names), flat=self._flat
            )
            for agent, view in self._views.items()
        }

    def state_space(self) -> spaces.Box:
        """The space of the centralised state."""
        return spaces.Box(self._state.low, self._state.high, dtype=np.float32)

    def names(self) -> dict[str, tuple[str, ...]]:
        """The name of each number that every agent observes."""
        return {agent: view.names for agent, view in self._views.items()}

    def state_names(self) -> tuple[str, ...]:
        """The name of each number of the centralised state."""
        return self._state.names

    def observe(self, episode: Episode) -> dict[str, Any]:
        """The current observation of every agent, in new arrays."""
        cameras = [camera for view in self._views.values() for camera in view.cameras]
        images = self._look(episode, cameras) if cameras else {}
        return {agent: self._seen(view, episode, images) for agent, view in self._views.items()}

    def state(self, episode: Episode) -> NDArray[np.float32]:
        """The centralised state: (n,) float32."""
        return self._state.vector(episode)

    def _view(
        self, channels: Iterable[str], agent: str | None, noise: Mapping[str, Noise] | None
    ) -> View:
        readings, cameras = [], []
        for text in dict.fromkeys(channels):
            channel = parse_channel(text, agent, self._task.file.names)
            if isinstance(channel, NameProblem):
                raise UsageError(f"{text}: {channel.message}")
            if is_camera(channel, self._world):
                cameras.append(channel)
            else:
                readings.append(self._reading(text, channel, agent, (noise or {}).get(text)))
        return View(readings, cameras)

    def _reading(
        self, text: str, channel: Channel, agent: str | None, noise: Noise | None
    ) -> Reading:
        if agent and self._own_frames and channel.frame == "world":
            channel = replace(channel, frame=f"{agent}.base")
        if agent and channel.quantity in POSITIONS:
            self.positions.add(agent)
            if self._position_noise:
                noise = with_position_noise(noise, self._position_noise)
        reading = make_reading(text, channel, self._world, noise)
        if self._log and channel.quantity in POSITIONS and channel.frame.endswith(".tcp"):
            reading = reading.with_log()
        return reading.with_matrix() if self._matrices else reading

    def _seen(self, view: View, episode: Episode, images: Mapping[str, _Look]) -> Any:
        vector = view.vector(episode)
        if self._flat and not view.cameras:
            return vector
        pictures = {
            f"{c.subject}.{c.quantity}": image_values(c, *images[c.subject]) for c in view.cameras
        }
        numbers = {VECTOR: vector} if self._flat else view.split(vector)
        return {**numbers, **pictures}

    def cameras(self, world: World) -> dict[str, Camera]:
        """The cameras of the scene as it stands, with the sizes of observed images."""
        return {name: camera_of(world, name, size) for name, size in self._sizes.items()}

    def _look(self, episode: Episode, cameras: Iterable[Channel]) -> dict[str, _Look]:
        """Render each camera once, for all agents that observe it."""
        world = episode.world
        world.move_markers()
        wanted = dict.fromkeys(camera.subject for camera in cameras)
        views = {name: world.camera(name, self._sizes[name]) for name in wanted}
        images = {name: capture(world, view) for name, view in views.items()}
        if self._image_noise:
            images = {
                name: with_noise(image, self._image_noise, episode.noise_rng)
                for name, image in images.items()
            }
        return {name: (image, views[name]) for name, image in images.items()}
