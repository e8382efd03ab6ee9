"""Exploration: Gaussian noise on actions, and random commands to grippers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from taskbuilder.arrays import Arrays
from taskbuilder.policies.trained import Array32

LONGEST_COMMAND = 10
"""Random commands to grippers last 1 to this many control steps, all equally likely."""

DIRECTIONS = np.array([-1.0, 1.0], dtype=np.float32)
"""Random commands to grippers: close and open."""


class Exploration:
    """Makes the actions of a policy exploratory.

    Gaussian noise explores continuous actions. It seldom opens a binary gripper that the policy
    commands to close with all force, and hardly ever for as long as the fingers need. Therefore,
    grippers now and then get a random command for several control steps (temporally extended
    ε-greedy exploration, Dabney et al. 2021).

    Args:
        grippers: Indices of the commands to grippers in the joint action.
        settings: With ``noise``, ``final_noise``, ``noise_until``, ``least_noise`` and
            ``gripper_epsilon``; see `MaddpgSettings`.
    """

    def __init__(self, grippers: Sequence[int], settings: Any) -> None:
        self._settings = settings
        self._grippers = list(grippers) if settings.gripper_epsilon else []
        self._steps_left = np.zeros((0, len(self._grippers)), dtype=np.int64)
        self._commands = np.zeros((0, len(self._grippers)), dtype=np.float32)

    def noise(self, progress_fraction: float) -> float:
        """Standard deviation of the noise at a fraction of the training, 0 to 1."""
        settings = self._settings
        fraction = min(progress_fraction / max(settings.noise_until, 1e-9), 1.0)
        return float(settings.noise + (settings.final_noise - settings.noise) * fraction)

    def explore_(
        self, actions: Array32, rng: np.random.Generator, progress_fraction: float
    ) -> None:
        """Change the actions of a policy in place; to be called once per control step.

        Args:
            actions: (num_envs, n) joint actions, from -1 to 1.
            rng: Generator of the noise.
            progress_fraction: The fraction of the training that is done.
        """
        relative = np.linspace(1.0, self._settings.least_noise, len(actions), dtype=np.float32)
        relative = relative[::-1, None]
        noise = self.noise(progress_fraction) * relative
        actions += noise * rng.standard_normal(actions.shape, dtype=np.float32)
        actions.clip(-1.0, 1.0, out=actions)
        if self._grippers:
            chance = self._settings.gripper_epsilon * relative
            actions[:, self._grippers] = self._command(actions[:, self._grippers], chance, rng)

    def _command(self, commands: Array32, chance: Array32, rng: np.random.Generator) -> Array32:
        """Commands to grippers, some of them random: (num_envs, grippers)."""
        if len(self._steps_left) != len(commands):
            self._steps_left = np.zeros(commands.shape, dtype=np.int64)
            self._commands = np.zeros(commands.shape, dtype=np.float32)
        begin = (rng.random(commands.shape) < chance) & (self._steps_left == 0)
        steps = rng.integers(1, LONGEST_COMMAND, commands.shape, endpoint=True)
        self._steps_left = np.where(begin, steps, self._steps_left)
        self._commands = np.where(begin, rng.choice(DIRECTIONS, commands.shape), self._commands)
        random = self._steps_left > 0
        self._steps_left = self._steps_left - random
        return np.where(random, self._commands, commands)

    def arrays(self) -> Arrays:
        """The random commands in progress, by name."""
        if not self._grippers:
            return {}
        return {"gripper_steps_left": self._steps_left, "gripper_commands": self._commands}

    def load(self, arrays: Mapping[str, Array32]) -> None:
        """Restore the state that `arrays` returned.

        Raises:
            KeyError: Something is missing.
        """
        if self._grippers:
            self._steps_left = np.array(arrays["gripper_steps_left"], dtype=np.int64)
            self._commands = np.array(arrays["gripper_commands"], dtype=np.float32)
