"""The family "needs its robots": one robot less, chance and waiting must not succeed.

Every seed is played once by each of several probes, and the variations take turns: holding still,
random actions, the expert without one of the robots, and one robot alone. A robot alone takes each
object in the success condition, at each of its grasp points, and brings it to each place in the
condition, or just up. If the condition names joints, it moves their object by each of its grasp
points along them. From each seed up to `MOST_SOLOS` of these attempts are played, in turn.

Probes are judged from the simplest on, up to the first that succeeds: if waiting is enough,
everything else is, too. If the task says ``cooperation: optional``, the success of single robots is
measured and is not a finding.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from taskbuilder.errors import Finding
from taskbuilder.expert.ways import NOTHING, RANDOM, Kind, Way
from taskbuilder.rollout.record import Rollout
from taskbuilder.task import Task
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.locate import finding_in_description, finding_in_file
from taskbuilder.validate.playing import play_nothing, play_random
from taskbuilder.validate.proportion import Proportion
from taskbuilder.validate.report import Check, FamilyResult, Result
from taskbuilder.validate.solo import (
    fetched,
    first_grasps,
    play_solo,
    sharers,
    solos,
    within_reach,
)

MOST_SOLOS = 3


class Tried(NamedTuple):
    """The episodes of all probes from a start.

    Attributes:
        plays: The episodes, by probe.
        in_reach: Robots with grasp points in reach that another robot should take.
    """

    plays: dict[Way, Rollout]
    in_reach: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class _Shortcut:
    """A sort of playing that must not succeed.

    Attributes:
        code: Of the check.
        name: What the check is about.
        kind: The kind of its ways.
        verb: What it does, for the message.
        mend: What would be right.
    """

    code: str
    name: str
    kind: Kind
    verb: str
    mend: str


_SHORTCUTS = (
    _Shortcut(
        "TB544", "doing nothing does not succeed", Kind.NOTHING, "holding still", "ask for more"
    ),
    _Shortcut(
        "TB543", "random play does not succeed", Kind.RANDOM, "playing at random", "ask for more"
    ),
    _Shortcut(
        "TB541",
        "every robot is needed",
        Kind.WITHOUT,
        "playing {way}",
        "make its part matter, or write cooperation: optional",
    ),
    _Shortcut(
        "TB542",
        "no robot does it alone",
        Kind.ALONE,
        "{way}",
        "put something out of its reach, or write cooperation: optional",
    ),
)


def needs_family(context: Context) -> FamilyResult:
    """Try to succeed without some of the robots, and without a plan."""
    starts = context.some_starts()
    in_reach: dict[tuple[str, str], list[Start]] = {}
    for start, tried in zip(starts, context.ask(try_ways, starts, "needs its robots"), strict=True):
        for way, play in tried.plays.items():
            context.plays.setdefault(way, {})[start] = play
        for pair in tried.in_reach:
            in_reach.setdefault(pair, []).append(start)
    results = list(_judged(context))
    if all(check.ok for check, _ in results) and _matters(context.task) and context.has_expert:
        results.append(_check_out_of_reach(context, in_reach, len(starts)))
    checks = tuple(check for check, _ in results)
    findings = tuple(finding for _, found in results for finding in found)
    return FamilyResult("needs its robots", checks, findings, _summary(context))


def _matters(task: Task) -> bool:
    """Whether the task must need several robots."""
    return task.file.spec.cooperation == "required" and len(task.agents) > 1


def _summary(context: Context) -> str:
    counts: Counter[Way] = Counter()
    for way, plays in context.plays.items():
        together = Way(way.kind) if way.kind is Kind.ALONE else way
        counts[together] += sum(play.success for play in plays.values())
    order = sorted(counts, key=lambda way: (way in (NOTHING, RANDOM), way == NOTHING))
    said = ", ".join(f"{_called(way)} {counts[way]}" for way in order)
    if context.has_expert and len(context.task.agents) > 1 and Way(Kind.ALONE) not in counts:
        said += "; success names nothing that a robot could take alone"
    return said


def _called(way: Way) -> str:
    """A way, or all ways of robots alone, in a word or two."""
    if way.kind is Kind.WITHOUT:
        return f"frozen {way.robot}"
    return "solo" if way.kind is Kind.ALONE else str(way)


# --- in each process


def try_ways(cache: EnvCache, start: Start) -> Tried:
    """Play all probes that must not succeed, from a start."""
    task, env = cache.task, cache.env(start.variation)
    plays = {
        NOTHING: play_nothing(env, start.seed),
        RANDOM: play_random(env, start.seed),
    }
    if not cache.has_expert or len(task.agents) < 2:
        return Tried(plays, ())
    expert = cache.expert(start.variation)
    for robot in task.agents:
        plays[Way(Kind.WITHOUT, robot=robot)] = expert.play(
            start.seed, without={robot}, persist=True
        )
    scene = env.episode.world.scene
    listed = solos(task, scene)
    first = start.seed * MOST_SOLOS
    turns = [(first + offset) % len(listed) for offset in range(min(MOST_SOLOS, len(listed)))]
    for solo in (listed[turn] for turn in turns):
        plays[solo.way] = play_solo(expert, start.seed, solo)
    return Tried(plays, tuple(_in_reach(cache, start)))


def _in_reach(cache: EnvCache, start: Start) -> Iterator[tuple[str, str]]:
    """Robots that could take, at the start, an object that another one should take first."""
    task, env = cache.task, cache.env(start.variation)
    env.reset(seed=start.seed)
    world = env.episode.world
    things = fetched(task, world.scene)
    shared = sharers(task.file.spec.expert)
    for grasp, taker in first_grasps(task.file.spec.expert).items():
        thing = grasp.partition(".")[0]
        if thing in things:
            apart = {taker} | shared.get(thing, set())
            others = [robot for robot in task.agents if robot not in apart]
            yield from ((r, grasp) for r in others if within_reach(world, r, grasp))


# --- the checks


def _judged(context: Context) -> Iterator[Result]:
    """Judge the probes, from the simplest on, up to the first that succeeds."""
    for shortcut in _SHORTCUTS:
        plays = {way: found for way, found in context.plays.items() if way.kind is shortcut.kind}
        if not plays:
            continue
        counts = {way: sum(p.success for p in found.values()) for way, found in plays.items()}
        total = sum(counts.values())
        excused = shortcut.code in ("TB541", "TB542") and not _matters(context.task)
        findings: list[Finding] = []
        if total and not excused:
            worst = max(counts, key=counts.__getitem__)
            start = next(start for start, play in plays[worst].items() if play.success)
            share = Proportion(counts[worst], len(plays[worst]))
            verb = shortcut.verb.format(way=worst)
            message = f"{verb} succeeds from {share} seeds ({start}); {shortcut.mend}"
            success = context.task.description.success
            findings = [
                finding_in_description(context.task, shortcut.code, message, "success", success)
            ]
        limit = None if excused else 0
        yield Check(shortcut.code, shortcut.name, not findings, total, limit, "episodes"), findings
        if findings:
            return


def _check_out_of_reach(
    context: Context, in_reach: dict[tuple[str, str], list[Start]], episodes: int
) -> Result:
    """An object of one robot starts out of reach of the others; otherwise a warning."""
    findings = []
    for (robot, grasp), starts in in_reach.items():
        message = (
            f"{robot} could take {grasp} at the start of {len(starts)} of {episodes} episodes "
            f"({starts[0]}), which another robot is to take; put it out of reach"
        )
        path = ("scene", "objects", grasp.partition(".")[0])
        found = finding_in_file(context.task, "TB545", message, *path, severity="warning")
        findings.append(found)
    count = max((len(starts) for starts in in_reach.values()), default=0)
    check = Check("TB545", "objects start out of the others' reach", True, count, None, "episodes")
    return check, findings
