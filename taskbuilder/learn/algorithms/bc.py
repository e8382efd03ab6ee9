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
from torch import Tensor

from taskbuilder.errors import UsageError
from taskbuilder.learn.chunk_policy import ChunkExecution, ChunkPolicy
from taskbuilder.learn.learner import Algorithm, Preset
from taskbuilder.learn.networks import (
    SharedNetworks,
    load_state,
    minimize,
    set_lr,
    state_arrays,
)
from taskbuilder.learn.policy import Array, TrainedPolicy
from taskbuilder.learn.recordings import Demonstrations
from taskbuilder.learn.shapes import Shapes

LEAST_SCALE = 0.02
"""Minimum scale of an observed number, so that those that hardly vary are not amplified."""


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
    """

    hidden: tuple[int, ...] = (256, 256, 256)
    norms: bool = True
    share: bool = False
    chunk: int = 10
    every: int = 1
    decay: float = 0.1
    batch: int = 256
    lr: float = 1e-3
    weight_decay: float = 1e-4
    noise: float = 0.05


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
        self._settings, self._device = settings, torch.device(device)
        self._generator = torch.Generator().manual_seed(seed)
        self._mean, self._scale = _statistics(demonstrations.observations)
        self._observations = {
            agent: self._tensor((seen - self._mean[agent]) / self._scale[agent])
            for agent, seen in demonstrations.observations.items()
        }
        self._actions = {a: self._tensor(done) for a, done in demonstrations.actions.items()}
        self._ends = torch.from_numpy(demonstrations.ends).to(self._device)
        ins = {agent: seen.shape[1] for agent, seen in self._observations.items()}
        outs = {agent: settings.chunk * done.shape[1] for agent, done in self._actions.items()}
        alone = tuple((agent,) for agent in demonstrations.agents)
        groups = Shapes(ins, outs, 0).same_spaces() if settings.share else alone
        self._networks = SharedNetworks(
            groups, ins, settings.hidden, outs, self._generator, norms=settings.norms
        ).to(self._device)
        self._adam = torch.optim.AdamW(
            self._networks.parameters(), settings.lr, weight_decay=settings.weight_decay, fused=True
        )

    def update(self, rng: np.random.Generator, progress_fraction: float) -> dict[str, float]:
        """Learn from a batch, and return the loss for the logs.

        Args:
            rng: Generator of the batch.
            progress_fraction: The fraction of the training that is done.
        """
        settings = self._settings
        set_lr(self._adam, settings.lr * 0.5 * (1.0 + math.cos(math.pi * progress_fraction)))
        drawn = rng.integers(len(self._ends), size=settings.batch)
        rows = torch.from_numpy(drawn).to(self._device)
        observed = {agent: seen[rows] for agent, seen in self._observations.items()}
        if settings.noise:
            seed = int(rng.integers(2**31))
            observed = {a: self._noisy(x, seed + n) for n, (a, x) in enumerate(observed.items())}
        ahead = rows[:, None] + torch.arange(settings.chunk, device=self._device)
        ends = self._ends[rows, None]
        ahead, inside = torch.minimum(ahead, ends - 1), ahead < ends  # (batch, chunk)
        targets = [done[ahead].flatten(1) for done in self._actions.values()]
        counted = [inside.repeat_interleave(done.shape[1], 1) for done in self._actions.values()]
        errors = (self._networks(observed) - torch.cat(targets, 1)).abs()
        loss = errors[torch.cat(counted, 1)].mean()
        minimize(self._adam, loss)
        return {"loss": float(loss.detach())}

    def _noisy(self, observed: Tensor, seed: int) -> Tensor:
        """Observations with noise, the same on every device."""
        generator = torch.Generator().manual_seed(seed)
        noise = torch.randn(observed.shape, generator=generator).to(self._device)
        return observed + self._settings.noise * noise

    def _tensor(self, array: NDArray[np.floating]) -> Tensor:
        return torch.from_numpy(array.astype(np.float32)).to(self._device)

    # --- saving and loading

    def policy(self, about: Mapping[str, Any]) -> ChunkPolicy:
        """The current policy."""
        networks = self._networks.policy(self._mean, self._scale, squash=False)
        return ChunkPolicy(networks, about, self._execution)

    def start_from(self, policy: TrainedPolicy) -> None:
        """Refuse to start from a trained policy."""
        del policy
        raise UsageError("bc starts from no policy")

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The complete state of the learner by name: networks and optimiser."""
        return {**state_arrays({"networks": self._networks}, {"adam": self._adam})}

    def load(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the state that `arrays` returned.

        Raises:
            KeyError: Something is missing.
            RuntimeError: Something has another shape.
        """
        load_state(arrays, {"networks": self._networks}, {"adam": self._adam})


def _statistics(observations: Mapping[str, Array]) -> tuple[dict[str, Array], dict[str, Array]]:
    """Mean and scale of each agent's observed numbers."""
    mean = {agent: seen.mean(0) for agent, seen in observations.items()}
    scale = {agent: np.maximum(s.std(0), LEAST_SCALE) for agent, s in observations.items()}
    return mean, scale


_ALONE = "learns from the data set alone"

ALGORITHM = Algorithm(
    summary="behaviour cloning with chunks of actions, from a data set",
    settings=BcSettings,
    learner=BehaviourCloning,
    presets={
        "cloning": Preset(
            "steps are updates with a batch",
            plan={"steps": 5_000, "evaluate_every": 1_000, "checkpoint_every": 1_000},
        )
    },
    default_preset=lambda demos, init: "cloning",  # noqa: ARG005  # there is one
    cannot={
        "init": f"{_ALONE}; leave --init out",
        "demos": f"{_ALONE}; leave --demos out",
        "starts": f"{_ALONE}; leave --starts out",
        "workers": f"{_ALONE}; leave --workers out",
        "reward": "learns from no reward; leave --reward out",
    },
    from_data=True,
)
