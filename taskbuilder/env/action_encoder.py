"""Encoding of joint and gripper commands as actions, in any action mode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError

Actions = dict[str, NDArray[np.float32]]
"""A flat action for every agent, as `TaskEnv.step` takes them."""


class ActionEncoder:
    """Encodes commands to arms and grippers as an environment's own actions.

    Where a robot carries out its actions with a delay, a command begins where the earlier actions
    will have led.

    Args:
        env: Any environment whose actions are flat.
        corrects: Whether an arm without a new command returns to the last one that was encoded, if
            another action has been carried out in between; otherwise, it stays where it was told to
            be by that.

    Raises:
        UsageError: Its actions are dictionaries.
    """

    def __init__(self, env: TaskEnv, *, corrects: bool = False) -> None:
        if not env.options.flat:
            raise UsageError("flat actions are needed; make the environment with flat=True")
        self.env = env
        self._corrects = corrects
        self._last: dict[str, Sequence[float]] = {}

    def hold(self) -> Actions:
        """Actions that repeat the last commands of all arms and grippers."""
        return self.actions()

    def actions(
        self,
        joints: Mapping[str, Sequence[float]] | None = None,
        openings: Mapping[str, float] | None = None,
    ) -> Actions:
        """An action for every agent.

        Args:
            joints: Commanded joint positions, rad or m, within one control step's reach; other arms
                stay where they were last told to be.
            openings: Gripper openings, from 0 (closed) to 1 (open); other grippers stay unchanged.
        """
        joints, openings = joints or {}, openings or {}
        if self._corrects:
            self._last |= joints
            joints = self._last
        actions = {}
        for agent, modes in self.env.episode.actions.items():
            waiting = self.env.episode.waiting(agent)
            numbers = modes.leading_to(joints.get(agent), openings.get(agent), waiting)
            if self.env.options.normalize:
                numbers = modes.normalized(numbers)
            actions[agent] = np.array(numbers, dtype=np.float32)
        return actions
