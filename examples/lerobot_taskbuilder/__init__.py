"""Evaluate a LeRobot policy on a task by LeRobot's own command (LeRobot 0.6).

LeRobot imports this package and finds the environment type ``taskbuilder`` in it:

    PYTHONPATH=examples lerobot-eval \
        --env.discover_packages_path=lerobot_taskbuilder --env.type=taskbuilder \
        --env.task=handover --env.cameras='[front]' --env.camera_size='[128,128]' \
        --policy.path=outputs/train/act/checkpoints/last/pretrained_model \
        --eval.n_episodes=50 --eval.batch_size=10

Give the task, cameras, size and options with which the policy's data set was collected.
"""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, field
from typing import Any

import gymnasium
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.envs.configs import EnvConfig

import taskbuilder.gym  # registers taskbuilder/LeRobot-v0

gymnasium.register_envs(taskbuilder.gym)


@EnvConfig.register_subclass("taskbuilder")
@dataclass
class TaskbuilderEnv(EnvConfig):
    """A task, and the options of its environment."""

    task: str | None = "handover"
    cameras: list[str] = field(default_factory=list)
    camera_size: list[int] | None = None
    variation: int = 0
    renderer: str = "auto"
    frame: str = "task"

    def __post_init__(self) -> None:
        with closing(gymnasium.make(self.gym_id, **self.gym_kwargs)) as env:
            self.fps = env.metadata["render_fps"]
            images = env.observation_space.spaces.get("pixels", {})
            self._add("action", "action", FeatureType.ACTION, env.action_space)
            state = env.observation_space["agent_pos"]
            self._add("agent_pos", "observation.state", FeatureType.STATE, state)
            for camera, image in images.items():
                key = f"observation.images.{camera}"
                self._add(f"pixels/{camera}", key, FeatureType.VISUAL, image)

    def _add(self, name: str, key: str, kind: FeatureType, space: gymnasium.Space) -> None:
        self.features[name] = PolicyFeature(type=kind, shape=tuple(space.shape))
        self.features_map[name] = key

    @property
    def gym_id(self) -> str:
        """What LeRobot passes to `gymnasium.make`."""
        return "taskbuilder/LeRobot-v0"

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        """With these arguments."""
        names = ("task", "cameras", "camera_size", "variation", "renderer", "frame")
        return {name: getattr(self, name) for name in names}
