"""The record of a played episode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.description.reasons import Reason
from taskbuilder.env.options import Options


@dataclass(frozen=True)
class Trouble:
    """Why a stage of an expert could not be done.

    Attributes:
        stage: Number of the stage, from 1, in the order of the task file.
        order: The order, such as ``right: grasp stick.right_end``.
        robot: The robot that could not do it; "" for none in particular.
        cause: One of `CAUSES`.
        message: The robot, the pose and the reason, in a sentence.
        step: Control steps before it.
    """

    stage: int
    order: str
    robot: str
    cause: str
    message: str
    step: int


CAUSES = (
    "out of reach",
    "in collision",
    "no path",
    "grasp missed",
    "lost on the way",
    "not arrived",
    "still held",
    "timed out",
    "no time left",
    "physics diverged",
)
"""The causes for which an expert cannot do a stage."""


@dataclass(frozen=True)
class ScriptLog:
    """The log of an expert's stages.

    Attributes:
        stage_ends: Control step at the end of each completed stage.
        trouble: The first stage that could not be done, or None.
        planning_s: Wall time of the planning, in seconds.
    """

    stage_ends: tuple[int, ...] = ()
    trouble: Trouble | None = None
    planning_s: float = 0.0


BY_STEP = ("actions", "rewards", "agent_rewards", "terms")
"""Fields of a `Rollout` with a row for every control step."""

BY_STATE = ("conditions", "stage", "progress", "succeeded")
"""Fields with a row for every state: after reset, and after each control step."""

ON_REQUEST = ("observations", "pictures", "robot_force")
"""Fields with a row for every state that are recorded only on request."""


@dataclass(frozen=True, eq=False)
class Rollout:
    """The record of an episode: actions, rewards, conditions and progress.

    Some arrays have ``steps`` rows, one per control step. Others have ``steps`` + 1 rows: one for
    the state after reset, and one for the state after each control step. If the physics diverged,
    the last of the ``steps`` + 1 rows repeats the row before it.

    Attributes:
        task: The task's name.
        seed: Seed passed to `reset`.
        variation: Number of the variation; 0 is the task as written.
        options: Options of the environment.
        control_hz: Control steps per second.
        horizon: Length of a full episode in control steps.
        stages: Names of the description's stages, in order.
        actions: (steps, n) float32 by agent, as `TaskEnv.step` takes them.
        rewards: (steps,) the team reward.
        agent_rewards: (steps,) by agent: the rewards that the environment returned.
        terms: (steps,) by name: each reward term. A term that belongs to one agent has the name
            ``NAME/AGENT``.
        conditions: (steps + 1,) bool by name: success, failure, stages and all other conditions.
        stage: (steps + 1,) number of the furthest stage reached so far; 0 for none.
        progress: (steps + 1,) the value of the description's progress.
        succeeded: (steps + 1,) bool: whether success has been reached so far, without a failure
            before it.
        exploded: Whether the physics diverged, which ends the episode.
        observations: (steps + 1, ...) by agent, or by agent and channel; empty unless `play` was
            called with ``observations=True``.
        pictures: (steps + 1, height, width, 3) uint8 by camera. If the physics diverged, the last
            picture is missing. Empty unless `play` was called with ``cameras``.
        robot_force: (steps + 1,) the largest force between two robots in each control step, in
            newtons, and 0 after reset; empty unless `play` was called with ``forces=True``.
        why: Why the success condition is false at the end; empty if the condition is true, or if
            `play` was called without ``explain=True``.
        log: The log of the expert's stages, or None if no expert played.
        disturbed: What the episode drew for disturbances, by axis, as JSON can hold it.
    """

    task: str
    seed: int
    variation: int
    options: Options
    control_hz: int
    horizon: int
    stages: tuple[str, ...]
    actions: Mapping[str, NDArray[np.float32]]
    rewards: NDArray[np.float64]
    agent_rewards: Mapping[str, NDArray[np.float64]]
    terms: Mapping[str, NDArray[np.float64]]
    conditions: Mapping[str, NDArray[np.bool_]]
    stage: NDArray[np.int64]
    progress: NDArray[np.float64]
    succeeded: NDArray[np.bool_]
    exploded: bool = False
    observations: Mapping[str, Any] = field(default_factory=dict)
    pictures: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)
    robot_force: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    why: tuple[Reason, ...] = ()
    log: ScriptLog | None = None
    disturbed: Mapping[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        how = "success" if self.success else "no success"
        paid = f"return {self.team_return:.2f}"
        return f"<Rollout {self.task}, seed {self.seed}: {self.steps} steps, {how}, {paid}>"

    @property
    def steps(self) -> int:
        """Length of the episode in control steps."""
        return len(self.rewards)

    def seconds(self, step: int) -> float:
        """Seconds from the reset to a control step."""
        return step / self.control_hz

    # --- success

    @property
    def success(self) -> bool:
        """Whether success was reached at some control step, before any failure."""
        return bool(self.succeeded[-1])

    @property
    def first_success(self) -> int | None:
        """The control step at which success was reached, counted from 1, or None."""
        return int(np.argmax(self.succeeded)) if self.success else None

    @property
    def success_at_end(self) -> bool:
        """Whether success was reached and holds after the last control step."""
        return self.success and not self.exploded and bool(self.conditions["success"][-1])

    @property
    def success_held_s(self) -> float:
        """Total time for which success held, from the step that reached it on, in seconds."""
        if self.first_success is None:
            return 0.0
        return float(self.conditions["success"][self.first_success :].sum()) / self.control_hz

    @property
    def failed_at(self) -> int | None:
        """The control step at which failure first held, 0 for the state after reset, or None."""
        failed = self.conditions["failure"]
        return int(np.argmax(failed)) if failed.any() else None

    @property
    def peak_robot_force(self) -> float | None:
        """The largest force between two robots (N), or None if it was not recorded."""
        return float(self.robot_force.max()) if len(self.robot_force) else None

    # --- stages

    @property
    def reached(self) -> Mapping[str, int]:
        """The control step at which each stage was first reached, in the order of stages."""
        return {
            name: int(np.argmax(self.stage >= number))
            for number, name in enumerate(self.stages, start=1)
            if self.stage[-1] >= number
        }

    @property
    def furthest_stage(self) -> str:
        """The last stage of the description that was reached, or ""."""
        return self.stages[self.stage[-1] - 1] if self.stage[-1] else ""

    @property
    def stage_ends(self) -> tuple[int, ...]:
        """The control step at the end of each completed stage of the expert."""
        return self.log.stage_ends if self.log else ()

    @property
    def trouble(self) -> Trouble | None:
        """Why a stage of the expert could not be done, or None."""
        return self.log.trouble if self.log else None

    # --- returns

    @property
    def team_return(self) -> float:
        """The undiscounted team return."""
        return float(self.rewards.sum())

    def discounted(self, discount: float) -> float:
        """The discounted team return."""
        return float(self.rewards @ discount ** np.arange(self.steps))

    @property
    def term_returns(self) -> Mapping[str, float]:
        """The sum of each reward term, by label."""
        return {label: float(values.sum()) for label, values in self.terms.items()}

    # --- comparison and parts

    def equals(self, other: Rollout) -> bool:
        """Whether two records are equal bit for bit, except for the planning time."""

        def same(one: Any, two: Any) -> bool:
            if isinstance(one, Mapping):
                return list(one) == list(two) and all(same(one[key], two[key]) for key in one)
            if isinstance(one, np.ndarray):
                return bool(one.dtype == two.dtype) and one.tobytes() == two.tobytes()
            if isinstance(one, ScriptLog):
                return isinstance(two, ScriptLog) and replace(one, planning_s=two.planning_s) == two
            return bool(one == two)

        return all(same(getattr(self, f.name), getattr(other, f.name)) for f in fields(self))

    def until(self, step: int) -> Rollout:
        """The record of the first control steps of the episode."""

        def cut(values: Any, rows: int) -> Any:
            if isinstance(values, Mapping):
                return {name: cut(part, rows) for name, part in values.items()}
            return values[:rows]

        whole = step >= self.steps
        return replace(
            self,
            exploded=self.exploded and whole,
            why=self.why if whole else (),
            **{name: cut(getattr(self, name), step) for name in BY_STEP},
            **{name: cut(getattr(self, name), step + 1) for name in (*BY_STATE, *ON_REQUEST)},
        )
