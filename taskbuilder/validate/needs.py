"""The needs family: nobody succeeds without all robots, nor by chance, nor by waiting.

Every seed is played once in each of several ways, the variations taking turns: holding still, at
random, the expert without one of the robots, and one robot alone. A robot alone takes each object
that the success condition names, at each of its grasp points, and brings it to each place that the
condition names, or just up; where the condition names joints, it moves their object by each of its
grasp points along them. Of these ways up to `MOST_SOLOS` are tried from a seed, taking turns.

Ways are judged from the simplest on, up to the first that succeeds: where waiting is enough, all
else is, too. Where the task says ``cooperation: optional``, what robots do without each other is
measured but is no finding.
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
from taskbuilder.validate.alone import (
    fetched,
    first_grasps,
    play_solo,
    sharers,
    solos,
    within_reach,
)
from taskbuilder.validate.places import finding_in_description, finding_in_file
from taskbuilder.validate.playing import play_nothing, play_random
from taskbuilder.validate.report import Check, FamilyResult, Result
from taskbuilder.validate.running import Run
from taskbuilder.validate.shares import Share
from taskbuilder.validate.studio import Start, Studio

MOST_SOLOS = 3


class Tried(NamedTuple):
    """What was tried from a start.

    Attributes:
        plays: What it came to, by way of playing.
        in_reach: Grasp points that a robot could reach which is not to take them, with its name.
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


def needs_family(run: Run) -> FamilyResult:
    """Try to succeed without the robots, and without any plan."""
    starts = run.some_starts()
    in_reach: dict[tuple[str, str], list[Start]] = {}
    for start, tried in zip(starts, run.ask(try_ways, starts, "needs its robots"), strict=True):
        for way, play in tried.plays.items():
            run.plays.setdefault(way, {})[start] = play
        for pair in tried.in_reach:
            in_reach.setdefault(pair, []).append(start)
    results = list(_judged(run))
    if all(check.ok for check, _ in results) and _matters(run.task) and run.has_expert:
        results.append(_check_out_of_reach(run, in_reach, len(starts)))
    checks = tuple(check for check, _ in results)
    findings = tuple(finding for _, found in results for finding in found)
    return FamilyResult("needs its robots", checks, findings, _summary(run))


def _matters(task: Task) -> bool:
    """Whether robots must need each other."""
    return task.file.spec.cooperation == "required" and len(task.agents) > 1


def _summary(run: Run) -> str:
    counts: Counter[Way] = Counter()
    for way, plays in run.plays.items():
        together = Way(way.kind) if way.kind is Kind.ALONE else way
        counts[together] += sum(play.success for play in plays.values())
    order = sorted(counts, key=lambda way: (way in (NOTHING, RANDOM), way == NOTHING))
    said = ", ".join(f"{_called(way)} {counts[way]}" for way in order)
    if run.has_expert and len(run.task.agents) > 1 and Way(Kind.ALONE) not in counts:
        said += "; success names nothing that a robot could take alone"
    return said


def _called(way: Way) -> str:
    """A way, or all ways of robots alone, in a word or two."""
    if way.kind is Kind.WITHOUT:
        return f"frozen {way.robot}"
    return "solo" if way.kind is Kind.ALONE else str(way)


# --- in each process


def try_ways(studio: Studio, start: Start) -> Tried:
    """Every way of playing that must not succeed, from a start."""
    task, env = studio.task, studio.env(start.variation)
    plays = {
        NOTHING: play_nothing(env, start.seed),
        RANDOM: play_random(env, start.seed),
    }
    if not studio.has_expert or len(task.agents) < 2:
        return Tried(plays, ())
    expert = studio.expert(start.variation)
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
    return Tried(plays, tuple(_in_reach(studio, start)))


def _in_reach(studio: Studio, start: Start) -> Iterator[tuple[str, str]]:
    """Which robots could take, at the start, what another one is to take first."""
    task, env = studio.task, studio.env(start.variation)
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


def _judged(run: Run) -> Iterator[Result]:
    """The ways of playing, from the simplest on, up to the first that succeeds."""
    for shortcut in _SHORTCUTS:
        plays = {way: found for way, found in run.plays.items() if way.kind is shortcut.kind}
        if not plays:
            continue
        counts = {way: sum(p.success for p in found.values()) for way, found in plays.items()}
        total = sum(counts.values())
        excused = shortcut.code in ("TB541", "TB542") and not _matters(run.task)
        findings: list[Finding] = []
        if total and not excused:
            worst = max(counts, key=counts.__getitem__)
            start = next(start for start, play in plays[worst].items() if play.success)
            share = Share(counts[worst], len(plays[worst]))
            verb = shortcut.verb.format(way=worst)
            message = f"{verb} succeeds from {share} seeds ({start}); {shortcut.mend}"
            success = run.task.description.success
            findings = [
                finding_in_description(run.task, shortcut.code, message, "success", success)
            ]
        limit = None if excused else 0
        yield Check(shortcut.code, shortcut.name, not findings, total, limit, "episodes"), findings
        if findings:
            return


def _check_out_of_reach(
    run: Run, in_reach: dict[tuple[str, str], list[Start]], episodes: int
) -> Result:
    """What one robot is to fetch starts where no other can fetch it; a warning."""
    findings = []
    for (robot, grasp), starts in in_reach.items():
        message = (
            f"{robot} could take {grasp} at the start of {len(starts)} of {episodes} episodes "
            f"({starts[0]}), which another robot is to take; put it out of reach"
        )
        path = ("scene", "objects", grasp.partition(".")[0])
        found = finding_in_file(run.task, "TB545", message, *path, severity="warning")
        findings.append(found)
    count = max((len(starts) for starts in in_reach.values()), default=0)
    check = Check("TB545", "objects start out of the others' reach", True, count, None, "episodes")
    return check, findings
