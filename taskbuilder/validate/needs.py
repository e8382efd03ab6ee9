"""The needs family: the task cannot be done without all robots, by chance, or by waiting.

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

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from taskbuilder.errors import Finding
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

NOTHING, RANDOM = "nothing", "random"


class Tried(NamedTuple):
    """The episodes of all probes from a start.

    Attributes:
        plays: The episodes, by probe.
        in_reach: Robots with grasp points in reach that another robot should take.
    """

    plays: dict[str, Rollout]
    in_reach: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class _Way:
    """A kind of probe that must not succeed.

    Attributes:
        code: Code of the check.
        name: Name of the check.
        sign: Name of its only probe, or a part of the names of its probes.
        verb: What it does, for the message.
        mend: What would be right, for the message.
    """

    code: str
    name: str
    sign: str
    verb: str
    mend: str

    def covers(self, name: str) -> bool:
        """Whether a probe is of this kind."""
        return name == self.sign or (self.sign in name and self.sign not in (NOTHING, RANDOM))


_WAYS = (
    _Way("TB544", "doing nothing does not succeed", NOTHING, "holding still", "ask for more"),
    _Way("TB543", "random play does not succeed", RANDOM, "playing at random", "ask for more"),
    _Way(
        "TB541",
        "every robot is needed",
        "without ",
        "playing {way}",
        "make its part matter, or write cooperation: optional",
    ),
    _Way(
        "TB542",
        "no robot does it alone",
        " alone, ",
        "{way}",
        "put something out of its reach, or write cooperation: optional",
    ),
)


def without(robot: str) -> str:
    """The name of the probe in which the expert plays without a robot."""
    return f"without {robot}"


def needs_family(run: Run) -> FamilyResult:
    """Try to succeed without some of the robots, and without a plan."""
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
    """Whether the task must need several robots."""
    return task.file.spec.cooperation == "required" and len(task.agents) > 1


def _summary(run: Run) -> str:
    counts: dict[str, int] = {}
    for way, plays in run.plays.items():
        label = "solo" if " alone, " in way else way.replace("without", "frozen")
        counts[label] = counts.get(label, 0) + sum(play.success for play in plays.values())
    order = sorted(counts, key=lambda label: (label in (NOTHING, RANDOM), label == NOTHING))
    said = ", ".join(f"{label} {counts[label]}" for label in order)
    if run.has_expert and len(run.task.agents) > 1 and "solo" not in counts:
        said += "; success names nothing that a robot could take alone"
    return said


# --- in each process


def try_ways(studio: Studio, start: Start) -> Tried:
    """Play all probes that must not succeed, from a start."""
    task, env = studio.task, studio.env(start.variation)
    plays = {
        NOTHING: play_nothing(env, start.seed),
        RANDOM: play_random(env, start.seed),
    }
    if not studio.has_expert or len(task.agents) < 2:
        return Tried(plays, ())
    expert = studio.expert(start.variation)
    for robot in task.agents:
        plays[without(robot)] = expert.play(start.seed, without={robot}, persist=True)
    scene = env.episode.world.scene
    listed = solos(task, scene)
    first = start.seed * MOST_SOLOS
    turns = [(first + offset) % len(listed) for offset in range(min(MOST_SOLOS, len(listed)))]
    for solo in (listed[turn] for turn in turns):
        plays[solo.name] = play_solo(expert, start.seed, solo)
    return Tried(plays, tuple(_in_reach(studio, start)))


def _in_reach(studio: Studio, start: Start) -> Iterator[tuple[str, str]]:
    """Robots that could take, at the start, an object that another one should take first."""
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
    """Judge the probes, from the simplest on, up to the first that succeeds."""
    for way in _WAYS:
        plays = {name: found for name, found in run.plays.items() if way.covers(name)}
        if not plays:
            continue
        counts = {name: sum(p.success for p in found.values()) for name, found in plays.items()}
        total = sum(counts.values())
        excused = way.code in ("TB541", "TB542") and not _matters(run.task)
        findings: list[Finding] = []
        if total and not excused:
            worst = max(counts, key=counts.__getitem__)
            start = next(start for start, play in plays[worst].items() if play.success)
            share = Share(counts[worst], len(plays[worst]))
            message = (
                f"{way.verb.format(way=worst)} succeeds from {share} seeds ({start}); {way.mend}"
            )
            success = run.task.description.success
            findings = [finding_in_description(run.task, way.code, message, "success", success)]
        limit = None if excused else 0
        yield Check(way.code, way.name, not findings, total, limit, "episodes"), findings
        if findings:
            return


def _check_out_of_reach(
    run: Run, in_reach: dict[tuple[str, str], list[Start]], episodes: int
) -> Result:
    """An object of one robot starts out of reach of the others; otherwise a warning."""
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
