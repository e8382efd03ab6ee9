"""The repeat family: the same seed and actions give the same episode, bit for bit.

Up to `EPISODES` episodes of the expert's actions, or of random ones without an expert, are played
in each of two fresh processes, and in this one after other episodes. The variations take turns. If
the fresh processes differ, each plays its episodes twice, to find out whether they differ even
within a process. Only the first difference that explains the others is reported.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import deepcopy
from typing import NamedTuple

from taskbuilder.description.description import Referee
from taskbuilder.description.node import Node
from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.parallel import EnvState, TaskEnv
from taskbuilder.errors import Finding
from taskbuilder.task import Task
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.fresh_process import fresh_processes
from taskbuilder.validate.locate import finding_in_description, finding_of_scene
from taskbuilder.validate.playing import random_actions
from taskbuilder.validate.report import Check, FamilyResult, Result
from taskbuilder.validate.traces import (
    Difference,
    Trace,
    actions_of,
    difference,
    digest,
    go_on,
    physical,
    trace,
)

EPISODES = 3
SAVED = 8
"""Control steps of an episode, evenly spaced, at which its state is saved and restored."""

AHEAD = 10
"""Control steps for which an episode continues from a restored state; to its end from the first."""


class Script(NamedTuple):
    """An episode to repeat."""

    start: Start
    actions: list[Actions]


def repeat_family(context: Context) -> FamilyResult:
    """Play the same episodes in several ways, and compare them to the bit."""
    with fresh_processes(2, limit_s=context.limit_s, beat=context.alive) as give:
        scripts = _scripts(context, context.some_starts(EPISODES))
        untouched = _check_untouched(context, scripts[0])
        if not untouched[0].ok:
            return _result([untouched], "the description changes the world")
        fresh = give(play_scripts, context.source, scripts)
        played = [
            _with_restores(context.cache.env(start.variation), start.seed, actions)
            for start, actions in scripts
        ]
        here = [whole for whole, _ in played]
        results = [untouched, *_check_repeats(context, scripts, here, fresh())]
    if all(check.ok or check.code == "TB503" for check, _ in results):
        results.append(_check_restores(context, scripts, [found for _, found in played]))
    broken = [check.name for check, _ in results if not check.ok]
    good = "bit for bit: again, after others, fresh process, restore"
    return _result(results, f"not so: {', '.join(broken)}" if broken else good)


def _result(results: Sequence[Result], summary: str) -> FamilyResult:
    checks = tuple(check for check, _ in results)
    return FamilyResult("repeat", checks, tuple(f for _, found in results for f in found), summary)


def _scripts(context: Context, starts: Sequence[Start]) -> list[Script]:
    if context.has_expert:
        played = context.demonstrate(starts, "repeat")
        return [Script(start, actions_of(d)) for start, d in zip(starts, played, strict=True)]
    return [
        Script(start, list(random_actions(context.cache.env(start.variation), start.seed)))
        for start in starts
    ]


# --- TB505


def _check_untouched(context: Context, script: Script) -> Result:
    """Evaluating the description does not change the world."""
    env = context.cache.env(script.start.variation)
    found = next(_changes(env, context.task, script), None)
    findings = []
    if found:
        message = f"asking it changes the world: {script.start}, {found}; it may only look"
        name = context.task.description.__name__
        findings = [finding_in_description(context.task, "TB505", message, name)]
    wrong = len(findings)
    return Check("TB505", "the description only looks", not wrong, wrong, 0, "episodes"), findings


def _changes(env: TaskEnv, task: Task, script: Script) -> Iterator[Difference]:
    """What the evaluation by a referee changes in an episode."""
    world, modes = env.episode.world, env.episode.actions
    referee = Referee(task.description, task.agents)
    world.reset(script.start.seed)
    for step, actions in enumerate((None, *script.actions)):
        if actions is not None:
            told = {agent: modes[agent].physical(a.tolist()) for agent, a in actions.items()}
            targets = {agent: modes[agent].command(numbers) for agent, numbers in told.items()}
            world.step({agent: goal for agent, goal in targets.items() if goal is not None})
        before = {name: digest(value) for name, value in physical(world).items()}
        if actions is None:
            referee.start(world)
        else:
            referee.judge(world)
        after = {name: digest(value) for name, value in physical(world).items()}
        if before != after:
            yield Difference(step, tuple(n for n in before if before[n] != after.get(n)))


# --- TB501, TB502, TB503


def _check_repeats(
    context: Context,
    scripts: Sequence[Script],
    here: Sequence[Trace],
    fresh: Sequence[Sequence[Trace]],
) -> Iterator[Result]:
    """An episode is the same again, after others, and in a fresh process."""
    counts = {"TB501": 0, "TB502": 0, "TB503": 0}
    findings: dict[str, list[Finding]] = {code: [] for code in counts}
    one, two = fresh
    apart = [difference(*pair) for pair in zip(one, two, strict=True)]
    again = _again(context, scripts) if any(apart) else [None] * len(scripts)
    for script, used, new, elsewhere, twice in zip(scripts, here, one, apart, again, strict=True):
        if elsewhere and twice:
            code, found = "TB501", twice
        elif elsewhere:
            code, found = "TB503", elsewhere
        elif after := difference(new, used):
            code, found = "TB502", after
        else:
            continue
        counts[code] += 1
        if not findings[code]:
            findings[code] = [_differs(context.task, code, script.start, found)]
    first = next((code for code in counts if counts[code]), None)
    for code, count in counts.items():
        if first in (None, code):
            yield Check(code, _NAMES[code], not count, count, 0, "episodes"), findings[code]


_NAMES = {
    "TB501": "the same seed, the same episode",
    "TB502": "the same after other episodes",
    "TB503": "the same in a fresh process",
    "TB504": "the same from a restored state",
}
_WHY = {
    "TB501": "the same seed and actions give another episode",
    "TB502": "the same seed and actions give another episode once others have been played",
    "TB503": "the same seed and actions give another episode in another process",
    "TB504": "restored in mid-episode, it goes on differently under the same actions",
}


def _differs(task: Task, code: str, start: Start, found: Difference) -> Finding:
    message = f"{_WHY[code]}: {start}, {found}"
    name, node = _culprit(task, found.parts)
    return finding_in_description(task, code, message, name, node)


def _culprit(task: Task, parts: Sequence[str]) -> tuple[str, Node | None]:
    """The part of a description that differs, if it can be identified."""
    description = task.description
    terms = {f"reward/{term.label}": (f"reward.{term.label}", term) for term in description.reward}
    named = {
        f"condition/{name}": (name, condition)
        for name, condition in description.conditions().items()
    }
    known: dict[str, tuple[str, Node | None]] = {**named, **terms}
    known["progress"] = ("progress", description.progress)
    return next((known[part] for part in parts if part in known), (description.__name__, None))


def _again(context: Context, scripts: Sequence[Script]) -> list[Difference | None]:
    """Where each episode differs when it is played twice over in one process."""
    with fresh_processes(1, limit_s=context.limit_s, beat=context.alive) as give:
        (traces,) = give(play_scripts, context.source, [s for s in scripts for _ in "12"])()
    return [difference(*pair) for pair in zip(traces[::2], traces[1::2], strict=True)]


def play_scripts(cache: EnvCache, scripts: Sequence[Script]) -> list[Trace]:
    """Play episodes one after the other."""
    return [trace(cache.env(start.variation), start.seed, acts) for start, acts in scripts]


# --- TB504


def _check_restores(
    context: Context, scripts: Sequence[Script], restored: Sequence[Difference | None]
) -> Result:
    """An episode continues identically from a saved state."""
    findings: list[Finding] = []
    for script, found in zip(scripts, restored, strict=True):
        if found and not findings:
            findings = [_restored_otherwise(context, script.start, found)]
    count = sum(found is not None for found in restored)
    return Check("TB504", _NAMES["TB504"], not count, count, 0, "episodes"), findings


def _restored_otherwise(context: Context, start: Start, found: Difference) -> Finding:
    """A finding at the description, if it can be its fault, and otherwise at the scene."""
    task = context.task
    moved = physical(context.cache.env(start.variation).episode.world)
    own = any(node.has_own_code for node in task.description.nodes())
    if own and not any(part in moved for part in found.parts):
        return _differs(task, "TB504", start, found)
    return finding_of_scene(task, "TB504", f"{_WHY['TB504']}: {start}, {found}; {_NOT_YOURS}")


_NOT_YOURS = "the description is not the cause, so this is a fault of taskbuilder: please report it"


def _with_restores(
    env: TaskEnv, seed: int, actions: Sequence[Actions]
) -> tuple[Trace, Difference | None]:
    """An episode, and its differences after restoring saved states, the latest first.

    Every other state is a copy, which is restored by playing its actions again.
    """
    marks = {number * len(actions) // (SAVED + 1) for number in range(1, SAVED + 1)}
    saved: list[tuple[int, EnvState]] = []
    steps = list(trace(env, seed, ()))
    for number, action in enumerate(actions):
        if number in marks and env.agents:
            state = env.save_state()
            saved.append((number, deepcopy(state) if len(saved) % 2 else state))
        steps += go_on(env, [action])
    found = None
    for number, state in reversed(saved):
        env.load_state(state)
        end = len(actions) if number == min(marks) else number + AHEAD
        again = list(go_on(env, actions[number:end]))
        found = found or difference(steps[number + 1 : end + 1], again, number + 1)
    return tuple(steps), found
