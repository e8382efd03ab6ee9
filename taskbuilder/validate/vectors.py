"""A vector environment, compared with a single environment that plays the episodes of its rows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.env.vector import TaskVectorEnv
from taskbuilder.validate.observing import Find
from taskbuilder.validate.report import Check, Result
from taskbuilder.validate.second_referee import staged
from taskbuilder.validate.traces import digest

KEPT_STEPS = 3
"""Control steps for which an action is kept, so that arms move away from where they stand."""

Parts = dict[str, Any]
"""What an environment returns in a step, by name."""


def vector_of(env: Any) -> TaskVectorEnv | None:
    """The vector environment of taskbuilder that an environment is or wraps, else None."""
    inner = env.unwrapped if isinstance(env, VectorEnv) else None
    return inner if isinstance(inner, TaskVectorEnv) else None


def single_of(vec: TaskVectorEnv) -> Any:
    """A single environment like those of a vector, wrapped in the same way."""
    config = vec.config
    return config.wrap(TaskEnv(config.task, config.options))


def check_vector(find: Find, env: Any, single: Any, seed: int, steps: int) -> Result:
    """The rows of a vector environment play what a single environment plays, to the bit.

    Where the rows are in this process, their episodes and those of the single environment are made
    to fail in the last step but one, so that infos of a failure are seen, and the reset after it.

    Args:
        find: Makes findings.
        env: The vector environment, which may have wrappers.
        single: A single environment like those of its rows; see `single_of`.
        seed: Seed of the first row; the other rows have the next seeds.
        steps: Number of steps to play.
    """
    count: int = env.num_envs
    actions = _actions(single, count, seed, steps)
    rows = [row.unwrapped for row in env.unwrapped.envs]
    failing = single.unwrapped.max_episode_steps - 2 if rows else -1
    played = list(_played(env, rows, seed, actions, failing))
    same_step = env.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    wrong = []
    for row in sorted({0, min(1, count - 1), count - 1}):
        solo = list(_solo(single, seed + row, row, actions, failing, same_step=same_step))
        wrong += list(_differences(row, seed + row, solo, played))[:1]
    found = [find("TB584", f"the vector environment: {message}", "task") for message in wrong]
    name = "vector environments play the same"
    return Check("TB584", name, not found, len(found), 0, "rows"), found


def _actions(single: Any, count: int, seed: int, steps: int) -> list[dict[str, list[Any]]]:
    """Random actions of every agent, for each row, by step; each is kept for a while."""
    spaces = {agent: deepcopy(single.action_space(agent)) for agent in single.possible_agents}
    for number, space in enumerate(spaces.values()):
        space.seed(seed + number)
    drawn = [
        {agent: [space.sample() for _ in range(count)] for agent, space in spaces.items()}
        for _ in range(0, steps, KEPT_STEPS)
    ]
    return [drawn[step // KEPT_STEPS] for step in range(steps)]


# --- what rows give, and what a single environment gives


@dataclass(frozen=True)
class _Step:
    """A step of all rows.

    Attributes:
        parts: What was returned: arrays with an element for each row.
        final: The same of the episodes that ended, by row.
    """

    parts: Parts
    final: Mapping[str, Any]

    def row(self, number: int) -> Parts:
        """What was returned for a row."""
        return {name: _row(part, number) for name, part in self.parts.items()}


def _played(
    env: Any,
    rows: Sequence[TaskEnv],
    seed: int,
    actions: Sequence[Mapping[str, Sequence[Any]]],
    failing: int,
) -> Iterator[_Step]:
    seen, infos = env.reset(seed=seed)
    yield _Step(_parts(seen, infos, _state(env)), {})
    for number, action in enumerate(actions):
        batch = {agent: _stacked(values) for agent, values in action.items()}
        with _failure(rows if number == failing else ()):
            seen, rewards, terminated, truncated, infos = env.step(batch)
        parts = _parts(seen, infos, _state(env))
        paid = {f"the reward of {agent}": pay for agent, pay in rewards.items()}
        ends = {"terminated": terminated, "truncated": truncated}
        yield _Step(parts | paid | ends, infos)


@contextmanager
def _failure(envs: Sequence[TaskEnv]) -> Iterator[None]:
    """The referees of environments say that the task has failed."""
    with ExitStack() as stack:
        for env in envs:
            stack.enter_context(staged(env, success=False, failure=True, once=True))
        yield


def _row(part: Any, number: int) -> Any:
    if isinstance(part, Mapping):
        return {key: _row(value, number) for key, value in part.items()}
    return part[number]


def _state(env: Any) -> Any:
    """The method `state`, of a wrapper if it has one."""
    return getattr(env, "state", env.unwrapped.state)


def _parts(seen: Mapping[str, Any], infos: Mapping[str, Any], state: Any) -> Parts:
    told = {
        f"info {key}": value
        for key, value in infos.items()
        if not key.startswith(("final_", "_")) and key != "lost"
    }
    return {
        **{f"what {agent} sees": view for agent, view in seen.items()},
        "state": state(),
        **told,
    }


def _solo(
    single: Any,
    seed: int,
    row: int,
    actions: Sequence[Mapping[str, Sequence[Any]]],
    failing: int,
    *,
    same_step: bool,
) -> Iterator[tuple[Parts, Parts]]:
    """What a row should return in each step, and what its episode should have returned last."""
    first = single.possible_agents[0]
    seen, infos = single.reset(seed=seed)
    yield _of_one(single, seen, infos[first]), {}
    for number, action in enumerate(actions):
        final: Parts = {}
        if single.agents:
            with _failure((single.unwrapped,) if number == failing else ()):
                seen, rewards, terminated, truncated, infos = single.step(
                    {agent: rows[row] for agent, rows in action.items()}
                )
            ends = {"terminated": terminated[first], "truncated": truncated[first]}
            if not single.agents and same_step:
                final = _of_one(single, seen, infos[first])
                seen, infos = single.reset()
        else:
            seen, infos = single.reset()
            rewards, ends = dict.fromkeys(single.possible_agents, 0.0), {}
            ends = {"terminated": False, "truncated": False}
        paid = {f"the reward of {agent}": pay for agent, pay in rewards.items()}
        yield {**_of_one(single, seen, infos[first]), **paid, **ends}, final


def _of_one(single: Any, seen: Mapping[str, Any], info: Mapping[str, float]) -> Parts:
    told = {f"info {key}": value for key, value in info.items()}
    views = {f"what {agent} sees": view for agent, view in seen.items()}
    return {**views, "state": single.state(), **told}


def _stacked(rows: Sequence[Any]) -> Any:
    if isinstance(rows[0], Mapping):
        return {key: _stacked([row[key] for row in rows]) for key in rows[0]}
    return np.stack(rows)


# --- comparing them


def _differences(
    row: int, seed: int, solo: Sequence[tuple[Parts, Parts]], played: Sequence[_Step]
) -> Iterator[str]:
    for number, ((expected, final), step) in enumerate(zip(solo, played, strict=True)):
        where = f"(row {row}, seed {seed}, step {number})"
        given = step.row(row)
        for name, value in expected.items():
            if name not in given:
                yield f"there is no {name} {where}"
            elif not _same(given[name], value):
                why = _why(name, given[name], row, number, solo, played)
                yield f"{name} is not that of a single environment {where}{why}"
        if final:
            last = _final(step.final, row)
            for name, value in final.items():
                if name not in last or not _same(last[name], value):
                    yield f"the infos have another {name} of the episode that ended {where}"


def _final(infos: Mapping[str, Any], row: int) -> Parts:
    """What the infos have of the last step of a row's episode."""
    seen = infos["final_obs"][row] if "final_obs" in infos else None
    views = {f"what {agent} sees": view for agent, view in (seen or {}).items()}
    told = {f"info {key}": values[row] for key, values in infos.get("final_info", {}).items()}
    state = {"state": infos["final_state"][row]} if "final_state" in infos else {}
    return {**views, **state, **told}


def _why(
    name: str,
    given: Any,
    row: int,
    number: int,
    solo: Sequence[tuple[Parts, Parts]],
    played: Sequence[_Step],
) -> str:
    """What it is instead."""
    if number and _same(given, solo[number - 1][0].get(name)):
        return ": it is that of the step before"
    if number and _same(given, solo[0][0].get(name)):
        return ": it is that after the reset"
    for other, value in solo[number][0].items():
        if other != name and other.split()[0] == name.split()[0] and _same(given, value):
            return f": it is {other}"
    for other_row in range(len(np.atleast_1d(played[number].parts["state"]))):
        if other_row != row and _same(given, played[number].row(other_row).get(name)):
            return f": it is also that of row {other_row}"
    return ""


def _same(given: Any, expected: Any) -> bool:
    if isinstance(expected, Mapping):
        return isinstance(given, Mapping) and all(
            key in given and _same(given[key], value) for key, value in expected.items()
        )
    if isinstance(expected, np.ndarray):
        return digest(np.asarray(given)) == digest(expected)
    try:
        return bool(float(given) == float(expected)) or (given != given and expected != expected)
    except (TypeError, ValueError):
        return bool(given == expected)
