"""A second referee of an episode: rewards, infos and ends as the description has them.

It judges the same scene as the referee of the environment, and what the environment returns is
compared with its outcome.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from taskbuilder.description.description import Outcome, Referee
from taskbuilder.description.view import WorldView
from taskbuilder.env.parallel import TaskEnv

FLAGS = ("success", "succeeded", "is_success", "failure", "failed", "exploded")
"""Infos that say how the episode stands; the others are about rewards and stages."""

Difference = tuple[str, str, str]
"""A code, what the difference is about, and a message."""


class SecondReferee:
    """Judges the episode of an environment, and compares what the environment says of it.

    Args:
        env: The environment.
        agents: The agents that are paid: the robots, or one that moves all of them.
    """

    def __init__(self, env: TaskEnv, agents: Sequence[str]) -> None:
        self._env = env
        self._agents = tuple(agents)
        self._staged: Callable[[Outcome], Outcome] = _as_judged
        self._steps = 0
        self._repeats = True

    def begin(self) -> None:
        """Begin an episode, after the reset of the environment."""
        self._referee = Referee(self._env.task.description, self._env.task.agents)
        self._outcome = self._referee.start(self._env.episode.world)
        self._failed, self._succeeded = self._outcome.failure, False
        self._steps = 0

    def judge(self, steps: int) -> None:
        """Judge the scene after a control step.

        Args:
            steps: Number of control steps in this episode.
        """
        self._steps = steps
        self._outcome = self._staged(self._judged())
        self._failed = self._failed or self._outcome.failure
        self._succeeded = self._succeeded or (self._outcome.success and not self._failed)

    def _judged(self) -> Outcome:
        """The outcome; notes whether the description gives the same when it is asked again.

        A description that counts how often it is asked pays a second referee something else. That
        is no fault of the environment, and TB504 is about it.
        """
        world, referee = self._env.episode.world, self._referee
        memory = referee.memory
        outcome = referee.judge(world)
        if self._steps == 1:
            after = referee.memory
            referee.memory = memory
            self._repeats = referee.judge(world) == outcome
            referee.memory = after
        return outcome

    @contextmanager
    def staged(self, *, success: bool, failure: bool) -> Iterator[None]:
        """Both referees give another verdict than the scene does.

        What an environment makes of success and failure can thus be seen without reaching them.
        """
        self._staged = _verdict(success=success, failure=failure)
        try:
            with staged(self._env, success=success, failure=failure):
                yield
        finally:
            self._staged = _as_judged

    @property
    def _where(self) -> str:
        return f"(seed {self._env.episode.seed}, step {self._steps})"

    # --- rewards

    def rewards(self, paid: Mapping[str, Any], infos: Mapping[str, Any]) -> Iterator[Difference]:
        """The rewards that are not what the description pays."""
        if not self._repeats:
            return
        for agent, expected in self._expected_rewards().items():
            given = paid.get(agent)
            if not isinstance(given, int | float | np.number) or not math.isfinite(given):
                continue  # a fault of its own
            if math.isclose(given, expected, rel_tol=1e-5, abs_tol=1e-6):
                continue
            said = infos.get(agent, {}).get("team_reward")
            team = self._env.options.reward == "team" and isinstance(said, float)
            infos_say = f", and infos say {said:.6g}" if team else ""
            yield (
                "TB579",
                agent,
                f"{agent} is paid {given:.6g} {self._where}, but the description pays "
                f"{expected:.6g}{infos_say}; return the reward of this step",
            )

    def _expected_rewards(self) -> dict[str, float]:
        outcome, kind = self._outcome, self._env.options.reward
        if kind == "sparse":
            return dict.fromkeys(self._agents, float(outcome.success))
        if kind == "local" and set(self._agents) <= set(self._env.task.agents):
            return {agent: outcome.local[agent] for agent in self._agents}
        return dict.fromkeys(self._agents, outcome.team)

    # --- infos

    def infos(self, told: Mapping[str, Any]) -> Iterator[Difference]:
        """The infos that are missing, or not what the description says."""
        if not self._repeats:
            return
        expected = self._expected_infos()
        for agent in self._agents:
            given = told.get(agent, {})
            for key, value in expected.items():
                if key not in given:
                    message = f'infos of {agent} have no "{key}" {self._where}'
                elif not _is_number(given[key], value):
                    message = (
                        f"infos of {agent} say {key} is {given[key]!r} {self._where}, but it is "
                        f"{value:.6g}"
                    )
                else:
                    continue
                if self._steps == 0 and key in FLAGS:
                    message += "; nothing of the episode before may be there after a reset"
                yield "TB582" if key in FLAGS else "TB579", f"{agent} {key}", message

    def _expected_infos(self) -> dict[str, float]:
        outcome = self._outcome
        return {
            "success": float(outcome.success),
            "succeeded": float(self._succeeded),
            "is_success": float(self._succeeded),
            "failure": float(outcome.failure),
            "failed": float(self._failed),
            "exploded": 0.0,
            "stage": float(outcome.stage),
            "progress": outcome.progress,
            "step": float(self._steps),
            "team_reward": outcome.team,
            **{f"reward/{label}": pay for label, pay in outcome.terms.items()},
            **{f"condition/{name}": float(held) for name, held in outcome.conditions.items()},
        }

    # --- ends

    def ends(
        self, terminations: Mapping[str, Any], truncations: Mapping[str, Any], *, wrapped: bool
    ) -> Iterator[Difference]:
        """The agents to whom an end is reported wrongly.

        Args:
            terminations: What agents are told.
            truncations: What agents are told.
            wrapped: Whether there are wrappers, which may end episodes earlier, as TimeLimit does.
        """
        ends, outcome = self._env.task.file.spec.timing.ends_on, self._outcome
        by = "success" if outcome.success and "success" in ends else "failure"
        terminated = by in ends and (outcome.failure if by == "failure" else True)
        truncated = not terminated and self._steps >= self._env.episode.horizon
        if terminated:
            reason = f"an episode that ends by {by} is terminated"
        elif truncated:
            reason = "an episode that only reaches its length is truncated"
        elif wrapped:
            return
        else:
            reason = "it goes on, as neither its length nor ends_on ends it"
        for agent in self._agents:
            given = bool(terminations.get(agent)), bool(truncations.get(agent))
            if given != (terminated, truncated):
                yield (
                    "TB581",
                    agent,
                    f"{agent} is told terminated={given[0]}, truncated={given[1]} {self._where}, "
                    f"but it is {terminated}, {truncated}: {reason}",
                )


@contextmanager
def staged(env: TaskEnv, *, success: bool, failure: bool, once: bool = False) -> Iterator[None]:
    """The referee of an environment gives another verdict than the scene does.

    Args:
        env: The environment.
        success: The verdict on success.
        failure: The verdict on failure.
        once: Whether only the next verdict is another, and not that of a reset which follows it.
    """
    referee, verdict = env.episode.referee, _verdict(success=success, failure=failure)
    judge = referee.judge

    def given(world: WorldView) -> Outcome:
        if once:
            vars(referee).pop("judge", None)
        return verdict(judge(world))

    # In the instance, in place of the method of its class: whatever holds this referee asks it.
    vars(referee)["judge"] = given
    try:
        yield
    finally:
        vars(referee).pop("judge", None)


def _verdict(*, success: bool, failure: bool) -> Callable[[Outcome], Outcome]:
    return lambda outcome: replace(outcome, success=success, failure=failure)


def _as_judged(outcome: Outcome) -> Outcome:
    return outcome


def _is_number(given: Any, value: float) -> bool:
    if not isinstance(given, int | float | np.number | np.bool_):
        return False
    if not math.isfinite(value):
        return True  # a term of the description that is no number is a finding of its own
    return math.isclose(given, value, rel_tol=1e-6, abs_tol=1e-9)
