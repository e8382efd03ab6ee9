"""Joint positions and gripper openings of all robots, as exported data sets have them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.parallel import TaskEnv


class JointState:
    """Reads the joint positions and gripper openings of an environment.

    Args:
        env: The environment.

    Attributes:
        names: Name of each number, such as ``left.joint_1`` and ``left.gripper``.
    """

    def __init__(self, env: TaskEnv) -> None:
        self._env = env
        self.names = tuple(
            name
            for robot, body in env.episode.world.robots.items()
            for name in (
                *(f"{robot}.joint_{n}" for n in range(1, body.dof + 1)),
                f"{robot}.gripper",
            )
        )
        self._last = np.zeros(len(self.names), dtype=np.float32)

    def __call__(self) -> NDArray[np.float32]:
        """The numbers now: rad or m, and openings from 0 to 1; after a divergence the last ones."""
        if not self._env.episode.exploded:
            robots = self._env.episode.world.robots.values()
            parts = [(*robot.arm_state()[0], robot.opening()) for robot in robots]
            self._last = np.concatenate(parts).astype(np.float32)
        return self._last.copy()
