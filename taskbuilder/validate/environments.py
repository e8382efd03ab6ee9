"""Checking any environment from Python: of taskbuilder, wrapped, or of another package."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import gymnasium
from gymnasium.utils.env_checker import check_env as gymnasium_check
from pettingzoo import AECEnv
from pettingzoo.test import api_test, parallel_api_test

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.episode import Episode
from taskbuilder.env.vector import TaskVectorEnv
from taskbuilder.errors import Finding, TaskbuilderError, UsageError, in_reading_order
from taskbuilder.quiet import without_remarks
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.source import dotted
from taskbuilder.validate.camera_pictures import wrong_with
from taskbuilder.validate.comparing import Change, Compared, base_of, play_ends
from taskbuilder.validate.observing import (
    Find,
    check_inside,
    check_own,
    check_paid,
    check_seeded,
    check_seen,
    check_spaces,
    check_varying,
    episode_of,
    watch,
)
from taskbuilder.validate.report import Check, Result
from taskbuilder.validate.stages import SingleAgent, TurnBased
from taskbuilder.validate.vectors import check_vector, single_of, vector_of
from taskbuilder.wording import suggestion

MOST_STEPS = 10_000
"""Control steps after which an episode of unknown length counts as endless."""

RESETS = 20
KEPT_BYTES = 100_000
"""How many resets there are to see what each of them keeps, and what none may keep."""

CYCLES = 60

LOOKED = 5
"""Control steps after which `render` must give another picture."""

AFTER_END = 2
"""Steps of a vector environment after the end of its first episodes."""


class ContractError(TaskbuilderError):
    """An environment violates what learning libraries rely on.

    Attributes:
        findings: The problems.
    """

    def __init__(self, findings: Sequence[Finding]) -> None:
        self.findings = in_reading_order(findings)
        super().__init__("\n".join(map(str, self.findings)))


def check_env(
    env: Any,
    *,
    seeds: Sequence[int] = (0, 1),
    max_steps: int | None = None,
    changes: Collection[Change] = (),
    raises: bool = True,
) -> tuple[Finding, ...]:
    """Check that an environment does what learning libraries rely on, and what its task says.

    The environment may come from taskbuilder or from another package, and may have wrappers from
    PettingZoo, SuperSuit or Gymnasium. `check_env` plays episodes with random actions. If
    taskbuilder's environment is inside, found by the attribute ``unwrapped``, every step is
    compared with its scene: observations, state and pictures, rewards, infos, terminations and
    truncations, and motor commands. If these episodes show no problem, `check_env` then runs
    PettingZoo's or Gymnasium's own tests. Reset the environment before you use it again.

    Args:
        env: A PettingZoo ParallelEnv or AECEnv, a gymnasium.Env, or an environment of `make_vec`.
        seeds: Seeds of the episodes.
        max_steps: Number of control steps within which an episode must end; by default the length
            of the task's episodes, or 10,000 if this length is not known.
        changes: What wrappers change on purpose, which is not compared with the scene:
            ``observations``, ``rewards``, ``actions`` or ``ends``. Observations and actions in a
            space of another shape are never compared.
        raises: Whether to raise an error if there are findings; otherwise, they are returned.

    Returns:
        The findings.

    Raises:
        ContractError: There are findings.
        UsageError: ``env`` is nothing that can be checked, or ``changes`` has another word.
    """
    for change in changes:
        if change not in get_args(Change):
            help_ = suggestion(change, get_args(Change), what="one of")
            raise UsageError(f'changes has "{change}"; {help_}')
    played = tuple(dict.fromkeys(seeds))
    vec = vector_of(env)
    if vec is not None:
        results = list(_checked_vector(env, vec, played, max_steps, changes))
    else:
        results = list(_checked(env, _as_parallel(env), played, max_steps, changes))
    findings = tuple(finding for _, found in results for finding in found)
    if findings and raises:
        raise ContractError(findings)
    return findings


def _checked_vector(
    env: Any,
    vec: TaskVectorEnv,
    seeds: Sequence[int],
    max_steps: int | None,
    changes: Collection[Change],
) -> Iterator[Result]:
    """First a single environment like those of the rows, and then the rows against such a one."""
    with closing(single_of(vec)) as single:
        results = list(_checked(single, single, seeds, max_steps, changes))
        if all(check.ok for check, _ in results) and not changes:
            steps = (max_steps or single.unwrapped.max_episode_steps) + AFTER_END
            results.append(check_vector(_unplaced, env, single, seeds[0], steps))
    yield from results


def _checked(
    env: Any,
    stage: Any,
    seeds: Sequence[int],
    max_steps: int | None,
    changes: Collection[Change],
) -> Iterator[Result]:
    episode = episode_of(stage)
    most = max_steps or (episode.horizon if episode else MOST_STEPS)
    actions = list(_played(stage, seeds[0], most))
    ended = check_ended(_unplaced, stage, len(actions))
    yield ended
    if not ended[0].ok:
        return
    base = base_of(stage)
    known = isinstance(env, gymnasium.Env) or (
        base and {*stage.possible_agents} <= {*base.task.agents}
    )
    compared = Compared(stage, base, changes=changes) if base and known else None
    views = watch(compared or stage, seeds, actions)
    results = [
        check_spaces(_unplaced, stage),
        check_seen(_unplaced, views),
        check_inside(_unplaced, views),
        check_paid(_unplaced, replace(views, unpaid=views.endless | views.unpaid)),
        check_seeded(_unplaced, views, placed_anew=bool(episode and places_anew(episode))),
        check_varying(_unplaced, views, by_chance=True),
        check_own(_unplaced, views, ()),
        check_kept(_unplaced, stage),
    ]
    if compared:
        compared.go_on()
    if getattr(env, "render_mode", None) == "rgb_array":
        if compared:
            picture = compared.look(env, seeds[0], actions[:1] * LOOKED)
        else:
            env.reset(seed=seeds[0])
            picture = env.render()
        results.append(check_picture(_unplaced, picture))
    if compared and all(check.ok for check, _ in results):
        play_ends(compared, seeds[0], actions[:2])
        results += compared.results(_unplaced)
    yield from results
    if all(check.ok for check, _ in results):
        yield _passes(env, len(actions))


def _unplaced(code: str, message: str, *path: str | int) -> Finding:
    """A finding about an environment, without a place in a file."""
    return Finding(code, message, dotted(path[1:]))


def _played(stage: Any, seed: int, most: int) -> Iterator[Actions]:
    """Random actions from a seed, up to the end of the episode or a maximum length."""
    stage.reset(seed=seed)
    for number, agent in enumerate(stage.possible_agents):
        stage.action_space(agent).seed(seed + number)
    for _ in range(most):
        if not stage.agents:
            return
        drawn = {agent: stage.action_space(agent).sample() for agent in stage.possible_agents}
        stage.step({agent: drawn[agent] for agent in stage.agents})
        yield drawn


def check_ended(find: Find, env: Any, steps: int) -> Result:
    """The episode has ended.

    Args:
        find: Makes findings.
        env: The environment after the episode.
        steps: Number of control steps that were played.
    """
    found = []
    if env.agents:
        message = f"the episode goes on after its {steps} control steps; truncate it, and say so"
        found = [find("TB573", message, "task")]
    return Check("TB573", "episodes end", not found, len(found), 0, "episodes"), found


def check_picture(find: Find, picture: Any) -> Result:
    """`render` returns a picture that is not blank."""
    found = []
    wrong = wrong_with(picture)
    if wrong:
        message = f"render gives {wrong}; a picture is (height, width, 3) of uint8"
        found = [find("TB571", message, "task")]
    return Check("TB571", "render gives pictures", not found, len(found), 0, "pictures"), found


def check_kept(find: Find, env: Any) -> Result:
    """Resets do not accumulate states or memory."""
    resets = [lambda seed=seed: env.reset(seed=seed) for seed in range(RESETS)]
    _grown(env, resets[:5])  # one-time allocations
    states, taken = _grown(env, resets)
    if not states and taken > KEPT_BYTES:
        states, taken = _grown(env, resets)  # the first measurement may have been a coincidence
    found = []
    if states or taken > KEPT_BYTES:
        what = f"{states:g} saved states" if states else f"{taken / 1000:,.0f} KB"
        message = f"each reset keeps {what} that no other gives back; let them go"
        found = [find("TB572", message, "task")]
    return Check("TB572", "resets keep nothing", not found, taken / 1000, None, "KB"), found


def _grown(env: Any, resets: Sequence[Callable[[], Any]]) -> tuple[float, float]:
    """Number of states and bytes that each of several resets keeps."""
    states, taken = _states(env), _memory()
    for reset in resets:
        reset()
    count = len(resets)
    return round((_states(env) - states) / count), (_memory() - taken) / count


def _states(env: Any) -> int:
    """Number of saved states of a taskbuilder environment."""
    episode = episode_of(env)
    return episode.world.client.snapshots if episode else 0


def _memory() -> int:
    """Memory use of this process in bytes; 0 where the system does not tell."""
    pages = Path("/proc/self/statm")
    if pages.exists():
        return int(pages.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    try:
        import resource  # POSIX only
    except ImportError:
        return 0
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most


def places_anew(episode: Episode) -> bool:
    """Whether initial positions differ between episodes."""
    return regions(episode.world.scene)


def regions(scene: SceneSpec) -> bool:
    """Whether a scene places anything at random, in a region of noticeable size."""
    things = {**scene.objects, **scene.sites}.values()
    return any(thing.place and max(thing.place.size) > 1e-3 for thing in things)


def _passes(env: Any, steps: int) -> Result:
    """The tests of PettingZoo or Gymnasium pass."""
    parallel = not isinstance(env, gymnasium.Env)
    code, name = ("TB521", "parallel_api_test") if parallel else ("TB523", "check_env")
    if isinstance(env, AECEnv):
        code, name = "TB522", "api_test"
    found = []
    try:
        with without_remarks():
            if isinstance(env, AECEnv):
                api_test(env, num_cycles=min(steps + 10, CYCLES))
            elif parallel:
                parallel_api_test(env, num_cycles=min(steps + 10, CYCLES))
            else:
                gymnasium_check(env, skip_render_check=True)
    except Exception as error:  # whatever the tests of others raise
        said = f"{type(error).__name__}: {error}".splitlines()[0]
        found = [_unplaced(code, f"{name} refuses the environment: {said}")]
    return Check(code, f"{name} passes", not found, len(found), 0, "refusals"), found


def _as_parallel(env: Any) -> Any:
    if isinstance(env, gymnasium.Env):
        return SingleAgent(env)
    if isinstance(env, AECEnv):
        return TurnBased(env)
    needed = ("possible_agents", "reset", "step", "observation_space", "action_space")
    if all(hasattr(env, name) for name in needed):
        return env
    raise UsageError(
        f"{type(env).__name__} is neither a PettingZoo ParallelEnv or AECEnv, nor a gymnasium.Env, "
        "nor of make_vec; check the environment that it was made of"
    )
