"""An environment's steps compared with its scene, its description and its task file.

What an environment returns comes through wrappers, views and the code of the environment itself. A
`Compared` environment is played like any other. Meanwhile, the numbers that agents should observe
are read from the physics, a second referee judges the scene, and the motors are asked what they
were told. Nothing of this changes the episode.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, Literal

import numpy as np

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.validate.camera_pictures import (
    CameraPictures,
    number_bounds,
    numeric_parts,
    wrong_with,
)
from taskbuilder.validate.commands import Commands, RobotCommand
from taskbuilder.validate.observing import Find
from taskbuilder.validate.report import Check, Result
from taskbuilder.validate.scene_values import Numbers, SceneValues, alike, differ
from taskbuilder.validate.second_referee import SecondReferee
from taskbuilder.validate.stages import SingleAgent

Change = Literal["observations", "rewards", "actions", "ends"]
"""What a wrapper changes on purpose."""

SPARE = 5
"""Control steps beyond the length of an episode that are compared before `Compared.go_on`."""

ACTED, STATED = 6, 10
"""Control steps of an episode whose actions are compared, and those whose state is."""

PICTURED = 3
"""Steps whose observed pictures are compared with what cameras see."""

CHECKS = {
    "TB577": "observations are what the scene has",
    "TB578": "pictures are what cameras see",
    "TB579": "rewards and infos are the description's",
    "TB581": "terminated and truncated are right",
    "TB582": "success and failure are of this episode",
    "TB583": "robots carry out their actions",
}
"""The checks, by code."""


def base_of(env: Any) -> TaskEnv | None:
    """The multi-agent environment of taskbuilder that an environment is made of, if it is.

    An environment whose agents have other names than the robots counts as something else.
    """
    inner = getattr(env, "unwrapped", env)
    inner = getattr(inner, "parallel", inner)
    if not isinstance(inner, TaskEnv):
        return None
    named = isinstance(env, SingleAgent) or {*env.possible_agents} <= {*inner.task.agents}
    return inner if named else None


class Compared:
    """An environment that is compared with its scene while it is played.

    Args:
        env: The environment, with PettingZoo's parallel interface. One agent may move all robots.
        base: The multi-agent environment that it is made of.
        changes: What its wrappers change on purpose, which is not compared.
        view: Name of the view in findings, such as "JointEnv"; "" for the multi-agent one.

    Attributes:
        wrong: The first difference of each kind, by code and by what it is about.
    """

    def __init__(
        self, env: Any, base: TaskEnv, *, changes: Collection[Change] = (), view: str = ""
    ) -> None:
        self.inner, self.base = env, base
        self.unwrapped = getattr(env, "unwrapped", env)
        self.possible_agents: list[str] = list(env.possible_agents)
        self.wrong: dict[str, dict[str, str]] = {code: {} for code in CHECKS}
        self._view = f"{view}: " if view else ""
        self._changes = changes
        alone, robots = isinstance(env, SingleAgent), base.task.agents
        self._robots = {agent: robots if alone else (agent,) for agent in self.possible_agents}
        self._values = {robot: SceneValues(base, robot) for robot in base.task.agents}
        self._state = SceneValues(base, None)
        self._commands = Commands(base)
        self._pictures = CameraPictures(base, PICTURED)
        self._second = SecondReferee(base, self.possible_agents)
        self._unsure: set[str] = set()
        self._check_names()
        self.go_on()

    # --- the interface of an environment

    @property
    def agents(self) -> list[str]:
        """The agents that take part in the episode now."""
        return list(self.inner.agents)

    def observation_space(self, agent: str) -> Any:
        """The observation space of an agent."""
        return self.inner.observation_space(agent)

    def action_space(self, agent: str) -> Any:
        """The action space of an agent."""
        return self.inner.action_space(agent)

    def reset(self, seed: int | None = None) -> tuple[Any, Any]:
        """Reset the environment, and compare what it returns."""
        seen, infos = self.inner.reset() if seed is None else self.inner.reset(seed=seed)
        self._when = f"seed {self.base.episode.seed}"
        self._steps = 0
        self._on = self._left > 0
        self._before: dict[str, Numbers] = {}
        self._first: dict[str, Numbers] = {}
        self._previous = {name: [0.0] * self._commands.size(name) for name in self._values}
        if not self._on:
            return seen, infos
        self._commands.begin()
        self._begun_at = self.base.episode.steps  # a wrapper may begin in the middle of an episode
        self._judged = self._begun_at == 0
        if not self._judged:
            self._previous = {name: [math.nan] * len(old) for name, old in self._previous.items()}
        self._second.begin()
        self._compare(seen, infos)
        return seen, infos

    def step(self, actions: Mapping[str, Any]) -> tuple[Any, ...]:
        """Run a control step, and compare what it returns."""
        told = self._expected_commands(actions) if self._on and self._steps < ACTED else []
        returned: tuple[Any, ...] = self.inner.step(actions)
        self._steps += 1
        self._left -= 1
        self._on = self._on and self._left >= 0
        self._check_place()
        if not self._on:
            return returned
        seen, rewards, terminations, truncations, infos = returned
        self._check_commands(told)
        for agent, action in actions.items():
            self._previous |= self._commands.units(self._robots[agent], action)
        self._second.judge(self._steps)
        self._compare(seen, infos)
        if "rewards" not in self._changes and self._judged:
            self._note_all(self._second.rewards(rewards, infos))
        if "ends" not in self._changes and self._judged:
            wrapped = self.inner is not self.base and not getattr(self.inner, "plain", False)
            self._note_all(self._second.ends(terminations, truncations, wrapped=wrapped))
        return returned

    def go_on(self) -> None:
        """Compare another episode and some steps; after these, episodes are only played."""
        self._left = self.base.episode.horizon + SPARE

    # --- ends

    def staged(self, *, success: bool, failure: bool) -> AbstractContextManager[None]:
        """The referee gives another verdict than the scene does; see `SecondReferee.staged`."""
        return self._second.staged(success=success, failure=failure)

    def skip_to_last_step(self) -> None:
        """Let the next control step be the last of the episode."""
        self._steps = self.base.episode.steps = self.base.episode.horizon - 1
        self._begun_at = 0

    def look(self, env: Any, seed: int, actions: Sequence[Mapping[str, Any]]) -> Any:
        """Compare what `render` gives after the reset and after some steps.

        Args:
            env: The environment, which has a render mode.
            seed: Seed of the episode.
            actions: Actions of every agent, by step.

        Returns:
            The picture after the reset.
        """
        self.reset(seed)
        first = env.render()
        if wrong_with(first):
            return first
        self._pictures.note_rendered(first)
        for action in actions:
            _act(self, action)
        if self._on:
            message = self._pictures.check_rendered(env, self._where())
            if message:
                self._note("TB578", "render", message)
        return first

    # --- results

    def add(self, wrong: Mapping[str, Mapping[str, str]]) -> None:
        """Add the differences of another view, unless there is such a one of this view."""
        for code, messages in wrong.items():
            if not self.wrong[code]:
                self.wrong[code] = dict(messages)

    def results(self, find: Find) -> list[Result]:
        """The results of all comparisons.

        Args:
            find: Makes findings.
        """
        for camera, message in self._pictures.unchanged().items():
            self.wrong["TB578"][camera] = f"{self._view}{message}"  # says more than what else was
        results = []
        for code, name in CHECKS.items():
            found = [
                find(code, message, *(("observe", about) if code == "TB577" else ("task",)))
                for about, message in self.wrong[code].items()
            ]
            results.append((Check(code, name, not found, len(found), 0, "differences"), found))
        return results

    def _note(self, code: str, about: str, message: str) -> None:
        self.wrong[code].setdefault(about, f"{self._view}{message}")

    def _note_all(self, differences: Iterable[tuple[str, str, str]]) -> None:
        for code, about, message in differences:
            self._note(code, about, message)

    def _where(self) -> str:
        return f"({self._when}, step {self._steps})"

    # --- observations

    def _check_names(self) -> None:
        """Every agent observes what the task file or the options list for it."""
        for robot, values in self._values.items():
            named = self.base.observation_names[robot]
            missing = [name for name in values.names if name not in named]
            if missing and "observations" not in self._changes:
                message = (
                    f"{robot} is to observe {missing[0]}, but has no number of this name; "
                    "give each agent its own channels"
                )
                self._note("TB577", robot, message)
        for agent, robots in self._robots.items():
            names = tuple(name for robot in robots for name in self._commands.names(robot))
            given = tuple(name for robot in robots for name in self.base.action_names[robot])
            if len(robots) > 1:
                given = getattr(self.unwrapped, "action_names", names)
            if given != names:
                message = f"the numbers of an action of {agent} are {given}, not {names}"
                self._note("TB583", agent, message)

    def _compare(self, seen: Any, infos: Any) -> None:
        if "observations" not in self._changes:
            self._check_observations(seen)
        if self._judged:
            self._note_all(self._second.infos(infos))

    def _check_observations(self, seen: Mapping[str, Any]) -> None:
        now = {
            robot: values.now(self._previous, self.base.observation_names[robot])
            for robot, values in self._values.items()
        }
        true = {agent: np.concatenate([now[r] for r in own]) for agent, own in self._robots.items()}
        for agent in self.possible_agents:
            if agent not in seen:
                continue
            parts = list(numeric_parts(seen[agent]))
            numbers_seen = np.concatenate(parts) if parts else np.zeros(0)
            if len(numbers_seen) != len(true[agent]):
                continue  # a wrapper gives other observations, in a space of its own
            low, high = number_bounds(seen[agent], self.inner.observation_space(agent))
            expected = np.clip(true[agent], low, high)
            self._check_numbers(agent, self._names_of(agent), numbers_seen, expected, true)
            for about, message in self._pictures.compare(agent, seen[agent], self._where()):
                self._note("TB578", about, message)
        state = getattr(self.inner, "state", None)
        if state is not None and self._steps <= STATED:
            true_state = self._state.now(self._previous, self.base.state_names)
            space = self.base.state_space
            expected = np.clip(true_state, space.low, space.high)
            given = np.asarray(state(), dtype=np.float64)
            self._check_numbers("the state", self.base.state_names, given, expected, {})
            true["the state"] = true_state
        self._before = true
        self._first = self._first or true

    def _names_of(self, agent: str) -> tuple[str, ...]:
        own = self._robots[agent]
        return tuple(name for robot in own for name in self.base.observation_names[robot])

    def _check_numbers(
        self,
        agent: str,
        names: Sequence[str],
        seen: Numbers,
        expected: Numbers,
        others: Mapping[str, Numbers],
    ) -> None:
        if len(seen) != len(expected):
            message = f"{agent} has {len(seen)} numbers {self._where()}, not {len(expected)}"
            self._note("TB577", agent, message)
            return
        wrong = np.flatnonzero(differ(seen, expected))
        if not len(wrong) or (agent in self.wrong["TB577"] and agent not in self._unsure):
            return
        at = int(wrong[0])
        why = self._why(agent, seen, others)
        # In the first step, what was so before it was so after the reset, too.
        (self._unsure.add if self._steps == 1 else self._unsure.discard)(agent)
        what = "has" if agent == "the state" else "sees"
        message = (
            f"{agent} {what} {names[at]} {seen[at]:.4g} {self._where()}, but it is "
            f"{expected[at]:.4g}{why}"
        )
        self.wrong["TB577"][agent] = f"{self._view}{message}"

    def _why(self, agent: str, seen: Numbers, others: Mapping[str, Numbers]) -> str:
        """What the numbers are instead."""
        if alike(seen, self._before.get(agent)):
            return ": that was so a step before; observe after the step, not before it"
        if alike(seen, self._first.get(agent)):
            return ": that was so after the reset; observe anew at every step"
        for other, true in others.items():
            if other != agent and alike(seen, true):
                return f": that is for {other} to see; give each agent its own observation"
        return "; return the observation of this step, as the scene stands"

    # --- actions

    def _expected_commands(
        self, actions: Mapping[str, Any]
    ) -> list[tuple[str, RobotCommand, dict[str, RobotCommand]]]:
        """Each robot, what it should be told in the next step, and what faults would tell it."""
        if "actions" in self._changes:
            return []
        sent: dict[str, list[float]] = {}
        for agent, action in actions.items():
            shape = (sum(self._commands.size(robot) for robot in self._robots[agent]),)
            if self.base.options.flat and self.inner.action_space(agent).shape != shape:
                return []  # a wrapper takes other actions, in a space of its own
            sent |= self._commands.units(self._robots[agent], action)
        due = self._commands.expected(sent)
        return [
            (robot, told, self._commands.mistakes(robot, sent, self._previous[robot]))
            for robot, told in due.items()
        ]

    def _check_commands(
        self, told: Iterable[tuple[str, RobotCommand, Mapping[str, RobotCommand]]]
    ) -> None:
        for robot, expected, mistakes in told:
            now = RobotCommand.of(self.base.episode.world.robots[robot])
            if now.equals(expected):
                continue
            why = next((why for why, wrong in mistakes.items() if now.equals(wrong)), None)
            message = f"{robot} carries out something else than its action {self._where()}"
            if why is None:
                message += f": {now.difference(expected)}; pass each action on as it comes"
            else:
                message += f": {why}; pass each action on as it comes, in the order of action_names"
            self._note("TB583", robot, message)

    def _check_place(self) -> None:
        """The episode is where its steps have led; else nothing more can be compared."""
        if not self._on:
            return
        episode = self.base.episode
        steps = episode.steps - self._begun_at
        if steps != self._steps and "actions" not in self._changes:
            message = (
                f"after {self._steps} steps of the environment, its episode has had {steps} "
                f"({self._when}); step the episode once in each step"
            )
            self._note("TB583", "the episode", message)
        self._on = steps == self._steps and not episode.exploded


def play_ends(compared: Compared, seed: int, actions: Sequence[Mapping[str, Any]]) -> None:
    """Play episodes that end by failure, by success, and by their length.

    Args:
        compared: The environment.
        seed: Seed of the episodes.
        actions: Actions of every agent, by step, for the first episode.
    """
    compared.reset(seed)
    for action in actions:
        _act(compared, action)
    for verdict in ("failure", "success"):
        with compared.staged(success=verdict == "success", failure=verdict == "failure"):
            _act(compared, actions[0])
        _act(compared, actions[0])  # unless it is over: it has failed, or succeeded, for good
        compared.reset(seed)
    compared.skip_to_last_step()
    with compared.staged(failure=False, success=False):
        _act(compared, actions[0])


def _act(compared: Compared, actions: Mapping[str, Any]) -> None:
    if compared.agents:
        compared.step({agent: actions[agent] for agent in compared.agents})
