"""An algorithm: behaviour cloning by ridge regression, which takes a single update."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from taskbuilder.errors import UsageError
from taskbuilder.learn.learner import Algorithm, Preset
from taskbuilder.learn.recordings import Demonstrations
from taskbuilder.policies.trained import Network, TrainedPolicy


@dataclass(frozen=True)
class RidgeSettings:
    """The settings of `Ridge`.

    Attributes:
        penalty: Weight of the squared coefficients.
    """

    penalty: float = 1.0


class Ridge:
    """Predicts each agent's action linearly from its observation.

    Args:
        demonstrations: What to learn from.
        settings: The settings.
        seed: Not used; the solution is unique.
        device: Not used; NumPy computes on the CPU.
    """

    def __init__(
        self,
        demonstrations: Demonstrations,
        settings: RidgeSettings,
        *,
        seed: int,
        device: str = "cpu",
    ) -> None:
        del seed, device
        self._demonstrations, self._settings = demonstrations, settings
        self._weights = {
            agent: np.zeros((seen.shape[1] + 1, demonstrations.actions[agent].shape[1]))
            for agent, seen in demonstrations.observations.items()
        }

    def update(self, rng: np.random.Generator, progress_fraction: float) -> dict[str, float]:
        """Solve the regression, and return the mean absolute error of the actions."""
        del rng, progress_fraction
        errors = []
        for agent, seen in self._demonstrations.observations.items():
            inputs = np.hstack([seen, np.ones((len(seen), 1))]).astype(np.float64)
            wanted = self._demonstrations.actions[agent].astype(np.float64)
            normal = inputs.T @ inputs + self._settings.penalty * np.eye(inputs.shape[1])
            self._weights[agent] = np.linalg.solve(normal, inputs.T @ wanted)
            errors.append(np.abs(inputs @ self._weights[agent] - wanted).mean())
        return {"actions": float(np.mean(errors))}

    def policy(self, about: Mapping[str, Any]) -> TrainedPolicy:
        """The current policy: a network of one layer for each agent."""
        layers = {
            agent: ((weights[:-1].astype(np.float32), weights[-1].astype(np.float32)),)
            for agent, weights in self._weights.items()
        }
        return TrainedPolicy({a: Network(one, squash=False) for a, one in layers.items()}, about)

    def start_from(self, policy: TrainedPolicy) -> None:
        """Refuse to start from a trained policy."""
        raise UsageError("ridge starts from no policy")

    def arrays(self) -> dict[str, Any]:
        """The complete state of the learner, by name."""
        return dict(self._weights)

    def load(self, arrays: Mapping[str, Any]) -> None:
        """Restore the state that `arrays` returned."""
        self._weights = {agent: arrays[agent] for agent in self._weights}


ALGORITHM = Algorithm(
    summary="behaviour cloning by ridge regression, from a data set",
    settings=RidgeSettings,
    learner=Ridge,
    presets={
        "exact": Preset(
            "a single update", plan={"steps": 1, "evaluate_every": 1, "checkpoint_every": 1}
        )
    },
    default_preset=lambda given: "exact",
    cannot={
        name: f"learns from the data set alone; leave --{name} out"
        for name in ("init", "demos", "starts", "workers", "reward", "cameras")
    },
    from_data=True,
)
