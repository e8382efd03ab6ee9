"""Episodes that people steer, one after the other: played, recorded, kept or tried again."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from contextlib import ExitStack, closing
from enum import Enum
from pathlib import Path
from typing import Any

from taskbuilder.data.growing import GrowingDataset
from taskbuilder.data.plan import CollectPlan
from taskbuilder.data.recording import EpisodeData, recording
from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.errors import TaskbuilderError, UsageError
from taskbuilder.policies.grammar import Player, parse_policy
from taskbuilder.policies.mixture import PolicyShare, shared_options
from taskbuilder.rollout.play import Step
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.steering.steering import HUMAN, SteeredPolicy, Steering, check_steerable
from taskbuilder.task import Task

PATIENCE = 6
"""People get so many times as many control steps as the task's own episodes have."""


RECENT = 20
"""Control steps over which the rate is measured."""


class State(Enum):
    """Where a session stands."""

    IDLE = "no episode runs"
    RUNNING = "an episode runs"
    ENDED = "an episode has ended, and is neither kept nor discarded"


def options_for_people(task: Task, player: Player, horizon: int | None = None) -> dict[str, Any]:
    """The options of an environment in which people steer.

    Args:
        task: The task.
        player: Who plays the robots that nobody steers.
        horizon: Length of an episode in control steps; by default six times as in the task file,
            and for a trained policy as in its training.
    """
    own = {name: value for name, value in player.options.items() if name != "variation"}
    if horizon is not None:
        return {**own, "horizon": horizon}
    return {"horizon": PATIENCE * task.file.spec.timing.episode_steps, **own}


def steering_plan(
    task: Task, player: str, catalogue: Catalogue, horizon: int | None = None
) -> CollectPlan:
    """What a data set says of itself whose episodes people steer.

    Args:
        task: The task.
        player: Who plays the robots that nobody steers.
        catalogue: Where the task is looked up.
        horizon: Length of an episode; see `options_for_people`.
    """
    return CollectPlan(
        tasks=(task.reference,),
        episodes=0,
        policies=(PolicyShare(HUMAN),),
        options=options_for_people(task, parse_policy(player), horizon),
        variations=None,
        keep_failures=True,
        until_success=task.file.spec.timing.control_hz,
        catalogue=catalogue,
    )


class Session:
    """Episodes that people steer.

    Args:
        task: The task.
        steering: Who steers.
        horizon: Length of an episode; see `options_for_people`.
        dataset: Where kept episodes are written, until the session is closed; None to record
            nothing.

    Attributes:
        steering: The same.
        state: Where it stands.
        env: The environment of the last episode, or None.
        kept: Number of episodes that were kept.
    """

    def __init__(
        self,
        task: Task,
        steering: Steering,
        *,
        horizon: int | None = None,
        dataset: GrowingDataset | None = None,
    ) -> None:
        self.steering = steering
        self.state = State.IDLE
        self.env: TaskEnv | None = None
        self.kept = 0
        self._task, self._horizon, self._dataset = task, horizon, dataset
        self._stack = ExitStack()
        self._made: tuple[str, int] | None = None
        self._policy: SteeredPolicy | None = None
        self._steps: Generator[Step, None, EpisodeData] | None = None
        self._data: EpisodeData | None = None
        self._times: list[float] = []
        self._watch: Callable[[TaskEnv], None] = lambda _: None

    @property
    def folder(self) -> Path | None:
        """Where kept episodes are written."""
        return self._dataset.folder if self._dataset is not None else None

    @property
    def data(self) -> EpisodeData | None:
        """The episode that has ended, until it is kept or discarded."""
        return self._data

    @property
    def seed(self) -> int | None:
        """The seed of the episode that runs or has ended."""
        return self.env.episode.seed if self.env and self.state != State.IDLE else None

    @property
    def control_hz(self) -> int:
        """Control steps per second, as in the task file."""
        return self._task.file.spec.timing.control_hz

    @property
    def measured_hz(self) -> float | None:
        """Control steps per second of wall time in this episode; None before the second."""
        times = self._times[-RECENT:]
        if len(times) < 2:
            return None
        return (len(times) - 1) / max(times[-1] - times[0], 1e-9)

    @property
    def lag_ms(self) -> float | None:
        """Median time from a key or a drag to its command, in milliseconds; None without any."""
        return self._policy.lag_ms if self._policy and self.env else None

    def people(self) -> dict[str, str]:
        """Who steers each robot: a person, nobody any more, or the player."""
        operators, standing = self.steering.operators, self.steering.standing
        player = self._made[0] if self._made else "the player"
        return {
            robot: operators[robot].name
            if robot in operators
            else "stands still, its person has left"
            if robot in standing
            else player
            for robot in self.steering.robots
        }

    # --- an episode

    def begin(
        self,
        player: str,
        seed: int,
        variation: int = 0,
        watch: Callable[[TaskEnv], None] = lambda _: None,
    ) -> int:
        """Begin an episode; one that has ended and succeeded is kept, other ones are discarded.

        Args:
            player: Who plays the robots that nobody steers.
            seed: Seed of the episode; with a data set, the next one that it does not have.
            variation: Number of the variation.
            watch: Called with the environment after the reset and after each control step.

        Returns:
            The seed.

        Raises:
            TaskbuilderError: It cannot be played, or the data set has other options.
        """
        self._settle()
        env = self._env(player, variation)
        if self._dataset is not None:
            seed = self._dataset.free_seed(seed)
        if self._policy is None:
            raise UsageError("nobody plays")
        self.steering.begin()
        self._watch, self._times = watch, []
        self._steps = recording(env, self._policy, seed, until_success=self.control_hz, watch=watch)
        next(self._steps)
        self.state = State.RUNNING
        return seed

    def step(self) -> None:
        """Run a control step; the episode may end by it."""
        if self._steps is None:
            return
        self._times.append(time.monotonic())
        try:
            next(self._steps)
        except StopIteration as end:
            self._end(end.value)

    def finish(self) -> None:
        """End the episode that runs now."""
        if self._steps is not None and self._policy is not None:
            self._policy.stop()
            self.step()

    def keep(self) -> str:
        """Keep the episode that has ended; its name in the data set, or "" without one.

        Raises:
            UsageError: No episode has ended.
            CollectingError: It cannot be written; it is not lost, and can be kept again.
        """
        self.finish()
        if self._data is None:
            raise UsageError("no episode has ended that could be kept")
        name = "" if self._dataset is None else self._dataset.add(self._data)
        self.kept += 1
        self._data, self.state = None, State.IDLE
        return name

    def discard(self) -> int | None:
        """Discard the episode that runs or has ended; its seed, to try again."""
        seed = self.seed
        if self._steps is not None:
            self._steps.close()
        self._steps, self._data, self.state = None, None, State.IDLE
        return seed

    def close(self) -> None:
        """Keep an episode that has succeeded, and free the environment."""
        try:
            self._settle()
        finally:
            self._stack.close()
            self.env = self._made = None
            if self._dataset is not None:
                self._dataset.close()

    def _settle(self) -> None:
        """Keep the episode that has ended if it succeeded, and discard it if not."""
        if self._data is not None and self._data.about["success"]:
            self.keep()
        self.discard()

    def _end(self, data: EpisodeData) -> None:
        about = dict(data.about)
        if "operators" in about and self.measured_hz:
            about["measured_hz"] = round(self.measured_hz, 2)
        self._data = EpisodeData(about, data.arrays, data.images, data.depths)
        self._steps, self.state = None, State.ENDED

    def _env(self, player: str, variation: int) -> TaskEnv:
        """The environment in which a player can play; the last one if it is the same."""
        if self._made == (player, variation) and self.env is not None:
            return self.env
        read = parse_policy(player)
        options = options_for_people(self._task, read, self._horizon)
        if self._dataset is not None:
            options = shared_options({player: read}, self._dataset.plan.options)
        self._stack.close()
        self._stack, self.env, self._made = ExitStack(), None, None
        env = parallel_env(self._task, **{**options, "variation": variation})
        self._stack.enter_context(closing(env))
        try:
            check_steerable(env)
            made = read.prepare(env, self._stack)
        except TaskbuilderError:
            self._stack.close()
            raise
        self._policy = SteeredPolicy(made, player, self.steering)
        self.env, self._made = env, (player, variation)
        return env
