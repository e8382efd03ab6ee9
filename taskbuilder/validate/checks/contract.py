"""The contract family: properties that learning libraries rely on.

Observations and rewards are checked over a few episodes of the same actions: those of the expert,
if there is one, and random ones after it. Then the tests of PettingZoo and Gymnasium run, unless
the observations were wrong, which these tests would only report again.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np
from gymnasium.spaces import Dict
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import api_test, parallel_api_test, seed_test
from pettingzoo.utils.conversions import parallel_to_aec

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.joint import JointEnv
from taskbuilder.env.options import EnvOptions, Options
from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.quiet import without_remarks
from taskbuilder.task import Task
from taskbuilder.validate.checks.views import check_views, compare_turns
from taskbuilder.validate.comparing import Compared, play_ends
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import SMALL, EnvCache, Start, at_work
from taskbuilder.validate.environments import (
    LOOKED,
    check_ended,
    check_kept,
    check_picture,
    regions,
)
from taskbuilder.validate.locate import arose_in_description, finding_in_file
from taskbuilder.validate.observing import (
    Find,
    check_inside,
    check_own,
    check_paid,
    check_seeded,
    check_seen,
    check_spaces,
    check_varying,
    sees_itself,
    watch,
)
from taskbuilder.validate.playing import random_actions
from taskbuilder.validate.report import Check, FamilyResult, Result
from taskbuilder.validate.traces import actions_of

EPISODES = 2
MOST_CYCLES = 60
SEED_CYCLES = 10


def contract_family(context: Context) -> FamilyResult:
    """Check observations and rewards, and run the tests of PettingZoo and Gymnasium."""
    env, task = context.cache.env(0), context.task
    find = partial(finding_in_file, task)
    results = [_check_end(find, env)]
    if results[0][0].ok:
        actions = _actions(context, env)
        compared = Compared(env, env)
        views = watch(compared, range(min(context.seeds, EPISODES)), actions)
        blind = [agent for agent in task.agents if not sees_itself(task, agent)]
        results += [
            check_spaces(find, env),
            check_seen(find, views),
            check_inside(find, views),
            check_paid(find, views),
            check_seeded(find, views, placed_anew=regions(task.file.scenes[0])),
            check_varying(find, views),
            check_own(find, views, blind),
            check_kept(find, env),
        ]
        if task.file.scenes[0].cameras:
            results.append(_check_render(find, compared, actions))
    if all(check.ok for check, _ in results):
        results += _compared(context, find, compared, actions)
    if all(check.ok for check, _ in results):
        results += context.spread(partial(at_work, _check_suite, context.source), SUITES)
    wrong = [check.name for check, _ in results if not check.ok]
    summary = f"not so: {', '.join(wrong)}" if wrong else f"{len(_TESTS)} API tests"
    findings = tuple(finding for _, found in results for finding in found)
    return FamilyResult("contract", tuple(check for check, _ in results), findings, summary)


def _compared(
    context: Context, find: Find, compared: Compared, actions: Sequence[Actions]
) -> list[Result]:
    """Compare all views of the environment with its scene."""
    play_ends(compared, 0, actions[:1])
    of_joint, of_rows = check_views(context.task, find, context.source.options)
    compared.add(of_joint)
    compared.add(compare_turns(context.cache, 0))
    results = compared.results(find)
    if all(check.ok for check, _ in results):  # else, the rows would only report it again
        results.append(of_rows)
    return results


def _check_end(find: Find, env: TaskEnv) -> Result:
    """An episode ends at its last control step."""
    env.reset(seed=0)
    env.episode.steps = env.episode.horizon - 1
    if env.agents:
        sizes = {agent: modes.size for agent, modes in env.episode.actions.items()}
        env.step({agent: np.zeros(size, dtype=np.float32) for agent, size in sizes.items()})
    return check_ended(find, env, env.episode.horizon)


def _check_render(find: Find, compared: Compared, actions: Sequence[Actions]) -> Result:
    env = compared.base
    mode, env.render_mode = env.render_mode, "rgb_array"
    compared.go_on()
    try:
        return check_picture(find, compared.look(env, 0, [*actions[:1]] * LOOKED))
    finally:
        env.render_mode = mode


def _actions(context: Context, env: TaskEnv) -> list[Actions]:
    """The actions of the checked episodes."""
    by_chance = list(random_actions(env, 0))
    if not context.has_expert:
        return by_chance
    (played,) = context.demonstrate([Start(0, 0)], "contract")
    done = played.trouble.step if played.trouble else max(played.stage_ends, default=0)
    return actions_of(played)[:done] + by_chance[done:]


def _check_suite(cache: EnvCache, code: str) -> Result:
    return check_suite(cache.task, code, cache.options)


def check_suite(task: Task, code: str, options: Options | None = None) -> Result:
    """The environment of a task passes the tests of a library; their warnings are ignored.

    Args:
        task: The task.
        code: One of `SUITES`.
        options: Options of the environment.

    Raises:
        Exception: The description raised it.
    """
    name, suite = SUITES[code]
    findings = []
    try:
        with without_remarks():
            suite(task, {**(options or Options()).chosen, "camera_size": SMALL})
    except Exception as error:  # the tests of other libraries may raise anything
        if arose_in_description(error, task.file.entry):
            raise
        said = f"{type(error).__name__}: {error}".splitlines()[0]
        findings = [finding_in_file(task, code, f"{name} refuses the environment: {said}", "task")]
    wrong = len(findings)
    return Check(code, f"{name} passes", not wrong, wrong, 0, "refusals"), findings


def _parallel(task: Task, options: EnvOptions) -> None:
    with _made(task, options) as env:
        parallel_api_test(env, num_cycles=_cycles(env))


def _turn_based(task: Task, options: EnvOptions) -> None:
    with _made(task, options) as env:
        # api_test reads the shape of the first agent's observation wherever another agent observes
        # an array. A dictionary has no shape, so agents that observe images come last.
        env.possible_agents.sort(key=lambda agent: isinstance(env.observation_space(agent), Dict))
        api_test(parallel_to_aec(env), num_cycles=_cycles(env))
    with contextlib.ExitStack() as opened:  # the test closes none of those that it makes
        seed_test(
            lambda: parallel_to_aec(opened.enter_context(contextlib.closing(_env(task, options)))),
            num_cycles=SEED_CYCLES,
        )


def _joint(task: Task, options: EnvOptions) -> None:
    env = JointEnv(task, **options)
    _seed(env.observation_space, env.action_space)
    try:
        check_env(env, skip_render_check=True)
    finally:
        env.close()


SUITES: Mapping[str, tuple[str, Callable[[Task, EnvOptions], None]]] = MappingProxyType(
    {
        "TB521": ("parallel_api_test", _parallel),
        "TB522": ("api_test and seed_test", _turn_based),
        "TB523": ("check_env", _joint),
    }
)
"""The tests of a library, by code: name and function."""

_TESTS = ("parallel_api_test", "api_test", "seed_test", "check_env")


@contextlib.contextmanager
def _made(task: Task, options: EnvOptions) -> Iterator[TaskEnv]:
    """An environment with seeded spaces, so that the tests always draw the same actions."""
    env = _env(task, options)
    for agent in env.possible_agents:
        _seed(env.observation_space(agent), env.action_space(agent))
    try:
        yield env
    finally:
        env.close()


def _env(task: Task, options: EnvOptions) -> TaskEnv:
    return parallel_env(task, **options)


def _seed(*spaces: Any) -> None:
    for space in spaces:
        space.seed(0)


def _cycles(env: TaskEnv) -> int:
    """Number of control steps up to the end of an episode, or less for a long one."""
    return min(env.episode.horizon + 10, MOST_CYCLES)
