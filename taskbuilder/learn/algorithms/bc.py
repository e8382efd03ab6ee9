"""Behaviour cloning with chunks of actions, from a recorded data set.

Networks predict the next several actions of the demonstrations from an observation, by regression
with an L1 loss, and the chunks are averaged where they overlap, as in Zhao et al. (2023). There is
a network for each robot, or one that robots of the same spaces share.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from taskbuilder.errors import UsageError
from taskbuilder.learn.chunk_data import ChunkData
from taskbuilder.learn.learner import Algorithm, Preset
from taskbuilder.learn.networks import (
    Linears,
    SharedNetworks,
    half_cosine,
    load_state,
    minimize,
    set_lr,
    state_arrays,
)
from taskbuilder.learn.recordings import Demonstrations
from taskbuilder.learn.settings import Count, Layers, Positive, Weight
from taskbuilder.learn.shapes import Shapes
from taskbuilder.learn.vision import PictureEncoders
from taskbuilder.policies.chunk_policy import ChunkExecution, ChunkPolicy
from taskbuilder.policies.pictures import KERNELS
from taskbuilder.policies.trained import TrainedPolicy


@dataclass(frozen=True)
class BcSettings:
    """The settings of `BehaviourCloning`.

    Attributes:
        hidden: Units of each hidden layer.
        norms: Whether hidden layers have layer norm.
        share: Whether robots of the same spaces share a network.
        chunk: Actions that are predicted at once.
        every: Control steps from one prediction to the next when the policy plays.
        decay: Overlapping chunks are averaged with weights exp(-decay n), for actions predicted n
            control steps ago.
        batch: Control steps of the data set in a batch.
        lr: Learning rate of AdamW; it falls to zero along half a cosine.
        weight_decay: Weight decay of AdamW.
        noise: Standard deviation of Gaussian noise on standardised observations.
        turn: Standard deviation, in degrees, of the angle by which the scene of each row of a batch
            is turned about the vertical through each robot's base. Robots have to observe in their
            own frames, with matrices. Those that are commanded by joints are not turned.
        channels: Channels of the three convolutions of each camera.
        scene_weight: With cameras, weight of the loss of predicting, linearly from the features of
            the pictures, what robots observe of the rest of the scene.
    """

    hidden: Layers = (256, 256, 256)
    norms: bool = True
    share: bool = False
    chunk: Count = 10
    every: Count = 1
    decay: Weight = 0.1
    batch: Count = 256
    lr: Positive = 1e-3
    weight_decay: Weight = 1e-4
    noise: Weight = 0.05
    turn: Weight = 0.0
    channels: Layers = (8, 16, 16)
    scene_weight: Weight = 1.0


class BehaviourCloning:
    """The learner of behaviour cloning.

    Args:
        demonstrations: What to learn from.
        settings: The settings of the algorithm.
        seed: Seed of the initial weights.
        device: Device of the networks and of the data set.

    Raises:
        UsageError: Chunks cannot be executed as the settings say.
    """

    def __init__(
        self,
        demonstrations: Demonstrations,
        settings: BcSettings,
        *,
        seed: int,
        device: str = "cpu",
    ) -> None:
        try:
            self._execution = ChunkExecution(settings.chunk, settings.every, settings.decay)
        except ValueError as error:
            raise UsageError(f"{error}; set chunk, every and decay otherwise") from None
        if len(settings.channels) != len(KERNELS):
            raise UsageError(f"channels has {len(settings.channels)} numbers; {len(KERNELS)}")
        self._settings = settings
        self._data = ChunkData(demonstrations, torch.device(device))
        if settings.turn:
            _check_turns(settings.turn, demonstrations)
        generator = torch.Generator().manual_seed(seed)
        self._encoders = PictureEncoders(tuple(self._data.pictures), settings.channels, generator)
        features = self._encoders.size
        ins = {agent: size + features for agent, size in self._data.sizes.items()}
        outs = {agent: settings.chunk * size for agent, size in self._data.action_sizes.items()}
        alone = tuple((agent,) for agent in demonstrations.agents)
        groups = Shapes(ins, outs, 0).same_spaces() if settings.share else alone
        self._networks = SharedNetworks(
            groups, ins, settings.hidden, outs, generator, norms=settings.norms
        )
        parts: dict[str, nn.Module] = {"networks": self._networks}
        if features:
            parts["encoders"] = self._encoders
        self._scene_head: Linears | None = None
        if features and self._data.scene.shape[1]:
            self._scene_head = Linears(1, features, self._data.scene.shape[1], generator)
            parts["scene"] = self._scene_head
        self._modules = nn.ModuleDict(parts).to(device)
        self._adam = torch.optim.AdamW(
            self._modules.parameters(), settings.lr, weight_decay=settings.weight_decay, fused=True
        )

    def update(self, rng: np.random.Generator, progress_fraction: float) -> dict[str, float]:
        """Learn from a batch, and return the losses for the logs.

        Args:
            rng: Generator of the batch.
            progress_fraction: The fraction of the training that is done.
        """
        settings, data = self._settings, self._data
        set_lr(self._adam, settings.lr * half_cosine(progress_fraction))
        rows = data.draw(settings.batch, rng)
        angles = data.angles(settings.batch, math.radians(settings.turn), rng)
        observed = data.observations(rows, settings.noise, rng, angles)
        losses: dict[str, Tensor] = {}
        if data.pictures:
            features = self._encoders({c: images[rows] for c, images in data.pictures.items()})
            observed = {
                agent: torch.cat([values, features], 1) for agent, values in observed.items()
            }
            if self._scene_head is not None:
                errors = self._scene_head(features[None])[0] - data.scene[rows]
                losses["scene"] = settings.scene_weight * errors.square().mean()
        actions, inside = data.chunks(rows, settings.chunk, angles)
        losses["actions"] = (self._networks(observed) - actions).abs()[inside].mean()
        minimize(self._adam, torch.stack(list(losses.values())).sum())
        return {name: float(loss.detach()) for name, loss in losses.items()}

    # --- saving and loading

    def policy(self, about: Mapping[str, Any]) -> ChunkPolicy:
        """The current policy."""
        mean, scale = self._data.statistics(self._encoders.size)
        networks = self._networks.policy(mean, scale, squash=False)
        return ChunkPolicy(networks, about, self._execution, self._encoders.frozen())

    def start_from(self, policy: TrainedPolicy) -> None:
        """Refuse to start from a trained policy."""
        del policy
        raise UsageError("bc starts from no policy")

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The complete state of the learner by name: networks, encoders and optimiser."""
        arrays: dict[str, NDArray[Any]] = {}
        return arrays | state_arrays({"modules": self._modules}, {"adam": self._adam})

    def load(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the state that `arrays` returned.

        Raises:
            KeyError: Something is missing.
            RuntimeError: Something has another shape.
        """
        load_state(arrays, {"modules": self._modules}, {"adam": self._adam})


def _check_turns(degrees: float, demonstrations: Demonstrations) -> None:
    """Refuse to turn what does not turn.

    Raises:
        UsageError: So it is.
    """
    if demonstrations.pictures:
        raise UsageError(f"turn is {degrees:g}, but pictures are not turned; set turn=0")
    if not demonstrations.turns or None in demonstrations.turns.values():
        raise UsageError(
            f"turn is {degrees:g}, but these observations turn in no known way; collect them with "
            "--frame base --rotation matrix, or set turn=0"
        )


_ALONE = "learns from the data set alone"

ALGORITHM = Algorithm(
    summary="behaviour cloning with chunks of actions, from a data set",
    settings=BcSettings,
    learner=BehaviourCloning,
    presets={
        "cloning": Preset(
            "from states; steps are updates with a batch",
            plan={"steps": 5_000, "evaluate_every": 1_000, "checkpoint_every": 1_000},
        ),
        "precise": Preset(
            "from states, shown with recovery and turned; acts on the newest prediction",
            settings={"noise": 0.02, "turn": 5.0, "decay": 2.0},
            plan={"steps": 15_000, "evaluate_every": 3_000, "checkpoint_every": 3_000},
        ),
        "visuomotor": Preset(
            "from pictures of about 64×64",
            settings={"batch": 64, "lr": 3e-3},
            plan={"steps": 10_000, "evaluate_every": 2_000, "checkpoint_every": 2_000},
        ),
    },
    default_preset=lambda given: "visuomotor" if given.get("cameras") else "cloning",
    cannot={
        "init": f"{_ALONE}; leave --init out",
        "demos": f"{_ALONE}; leave --demos out",
        "starts": f"{_ALONE}; leave --starts out",
        "workers": f"{_ALONE}; leave --workers out",
        "reward": "learns from no reward; leave --reward out",
    },
    from_data=True,
)
