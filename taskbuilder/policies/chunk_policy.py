"""Policies that predict the next several actions at once, and how their chunks are executed.

Predicting chunks of actions makes a cloned policy less prone to stalling and to compounding errors
(Zhao et al. 2023). A chunk is predicted every few control steps; where chunks overlap, their
actions are averaged.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.env.spaces import VECTOR
from taskbuilder.errors import UsageError
from taskbuilder.policies.pictures import PictureEncoder, is_of_encoder, read_encoder
from taskbuilder.policies.trained import Array32, TrainedPolicy
from taskbuilder.rollout.play import Policy

CHUNKS = "chunks"
"""Key of a policy's file that tells how its chunks are executed."""

ENCODERS = "encoders"
"""Key of a policy's file that names the cameras whose pictures it observes."""

LONGEST = 1_000
"""Maximum length of a chunk in a policy's file."""


@dataclass(frozen=True)
class ChunkExecution:
    """How chunks of actions are predicted and executed.

    Attributes:
        length: Actions in a chunk.
        every: Control steps from one prediction to the next, at most ``length``.
        decay: An action that was predicted n control steps ago has the weight exp(-decay n) in the
            average of overlapping chunks.
    """

    length: int
    every: int = 1
    decay: float = 0.1

    def __post_init__(self) -> None:
        if not 1 <= self.every <= self.length <= LONGEST:
            raise ValueError(f"chunks of {self.length} actions, predicted every {self.every} steps")
        if not math.isfinite(self.decay):
            raise ValueError("the decay is not finite")


@dataclass(frozen=True, repr=False)
class ChunkPolicy(TrainedPolicy):
    """A policy whose networks predict chunks of actions, the first action first.

    A network takes the numbers that its agent observes, and then the features of all pictures.

    Attributes:
        execution: How its chunks are executed.
        encoders: The encoder of each camera that agents observe.
    """

    execution: ChunkExecution = ChunkExecution(1)
    encoders: Mapping[str, PictureEncoder] = field(default_factory=dict)

    def predict(self, observations: Mapping[str, Any]) -> dict[str, Array32]:
        """A chunk of actions for each agent: (length, n) each."""
        inputs = {agent: observations[agent] for agent in self.networks}
        if self.encoders:  # every agent observes the same pictures
            pictures = next(iter(inputs.values()))
            features = [encode(pictures[f"{name}.rgb"]) for name, encode in self.encoders.items()]
            inputs = {a: np.concatenate([seen[VECTOR], *features]) for a, seen in inputs.items()}
        return {
            agent: network(inputs[agent]).reshape(self.execution.length, -1)
            for agent, network in self.networks.items()
        }

    def act(self, observations: Mapping[str, Any]) -> dict[str, Array32]:
        """The first actions of new chunks; see `player` for how a policy plays episodes."""
        return {agent: chunk[0] for agent, chunk in self.predict(observations).items()}

    def player(self) -> Policy:
        """The policy as it plays episodes, which averages overlapping chunks."""
        return ChunkPlayer(self)

    def sizes(self, agent: str) -> tuple[int, int]:
        """How many numbers an agent observes, and how many its action has."""
        takes, gives = super().sizes(agent)
        if gives % self.execution.length:
            raise ValueError(f"{gives} numbers are no chunk of {self.execution.length} actions")
        return takes - self._features, gives // self.execution.length

    @property
    def _features(self) -> int:
        """Number of features of all pictures."""
        return sum(encoder.size for encoder in self.encoders.values())

    def check_env(self, env: TaskEnv, name: str) -> None:
        """Check that agents observe the cameras of training, in the same size and renderer.

        Raises:
            UsageError: They do not.
        """
        if not self.encoders:
            return
        trained, options = self.about["env"], env.options
        size = options.camera_size and list(options.camera_size)
        here = {
            "cameras": list(options.cameras),
            "camera_size": size,
            "renderer": env.episode.world.client.renderer,
        }
        for what, value in here.items():
            needed = trained[what]
            needed = list(needed) if isinstance(needed, tuple) else needed
            if value != needed:
                raise UsageError(
                    f"{name} was trained with {what} {needed}, and here it is {value}; make the "
                    f"environment with {what}={needed!r}"
                )

    def traits(self) -> dict[str, Any]:
        """What a file says of the policy besides its arrays."""
        return {**super().traits(), CHUNKS: vars(self.execution), ENCODERS: list(self.encoders)}

    def arrays(self) -> dict[str, Array32]:
        """Its arrays by name, for a file."""
        arrays = super().arrays()
        for camera, encoder in self.encoders.items():
            arrays |= encoder.arrays(camera)
        return arrays

    @classmethod
    def read(cls, arrays: Mapping[str, Array32], about: Mapping[str, Any]) -> ChunkPolicy:
        """Make a policy from the contents of a file.

        Raises:
            KeyError: Something is missing.
            TypeError: Something is of another kind.
            ValueError: Arrays do not form a network, or chunks cannot be executed like this.
        """
        squash, norms = bool(about["squash"]), bool(about["norms"])
        numbers = {name: array for name, array in arrays.items() if not is_of_encoder(name)}
        plain = TrainedPolicy.of(numbers, about, squash=squash, norms=norms)
        encoders = {camera: read_encoder(arrays, camera) for camera in about.get(ENCODERS, ())}
        return cls(plain.networks, about, ChunkExecution(**about[CHUNKS]), encoders)


class ChunkPlayer:
    """Plays episodes of a policy: predicts chunks, and averages those that overlap.

    Args:
        policy: The policy.
    """

    def __init__(self, policy: ChunkPolicy) -> None:
        self._policy, self._execution = policy, policy.execution
        self._chunks: list[tuple[int, Mapping[str, Array32]]] = []  # when predicted, and the chunk
        self._step = 0

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode; nothing is kept of the one before."""
        del seed
        self._policy.check_env(env, "the policy")
        self._chunks, self._step = [], 0

    def act(self, observations: Mapping[str, Any]) -> dict[str, Array32]:
        """The average of what the chunks that reach this control step contain for it."""
        if self._step % self._execution.every == 0:
            self._chunks.append((self._step, self._policy.predict(observations)))
        first = self._step - self._execution.length
        self._chunks = [chunk for chunk in self._chunks if chunk[0] > first]
        ages = np.array([self._step - begun for begun, _ in self._chunks])
        weights = np.exp(-self._execution.decay * (ages - ages.min()))
        weights = (weights / weights.sum()).astype(np.float32)
        actions = {}
        for agent in self._policy.networks:
            predicted = [chunk[agent][self._step - begun] for begun, chunk in self._chunks]
            actions[agent] = weights @ np.stack(predicted)
        self._step += 1
        return actions
