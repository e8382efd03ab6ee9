"""The reset family: checks of the initial states of many episodes."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

from taskbuilder.description.description import Referee
from taskbuilder.description.load import is_interrupt
from taskbuilder.errors import ExplosionError, Finding, PlacementError
from taskbuilder.geometry import Pose, Vec3
from taskbuilder.schema.placing import Place
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.task import Task
from taskbuilder.validate.checks.edges import Overhang, Upset, overhang, standing, upset
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import Start
from taskbuilder.validate.locate import (
    failure_of_description,
    finding_at,
    finding_of_scene,
    in_variation,
)
from taskbuilder.validate.report import Check, FamilyResult, Result
from taskbuilder.world.world import World

SETTLING_M = 0.003
"""Tolerance in metres for an object that settles at the edge of its region."""


@dataclass
class _Tally:
    """Results collected over the resets."""

    episodes: int = 0
    misplaced: dict[str, Finding] = field(default_factory=dict)
    strayed: dict[str, int] = field(default_factory=dict)
    upset: dict[str, list[Upset]] = field(default_factory=dict)
    upright: dict[str, str] = field(default_factory=dict)
    hanging: dict[str, Overhang] = field(default_factory=dict)
    solved: list[str] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)
    exploded: list[str] = field(default_factory=list)
    raised: list[Finding] = field(default_factory=list)
    positions: dict[tuple[str, int], list[Vec3]] = field(default_factory=dict)
    seconds: list[float] = field(default_factory=list)


def reset_family(context: Context) -> FamilyResult:
    """Reset episodes of every variation, and check each initial state."""
    task, measures = context.task, context.measures
    tally = _Tally()
    for variation in range(context.variations):
        world = context.world(variation)
        referee = Referee(task.description, task.agents)
        world.watch_forces(referee.force_pairs)
        label = f"reset, variation {variation}" if variation else "reset"
        try:
            for seed in context.progress(range(context.seeds), label):
                if not _begin(world, referee, Start(variation, seed), tally):
                    break
        finally:
            context.close_world(variation)
    if tally.seconds:
        measures["reset_ms"] = statistics.median(tally.seconds) * 1000.0
    results = list(_checks(task, tally))
    checks = tuple(check for check, _ in results)
    findings = tuple(finding for _, wrong in results for finding in wrong)
    return FamilyResult("reset", checks, findings, _summary(tally, measures))


def _summary(tally: _Tally, measures: dict[str, float]) -> str:
    solved = "never solved" if not tally.solved else f"{len(tally.solved)} solved"
    time_taken = f", {measures['reset_ms']:.1f} ms each" if "reset_ms" in measures else ""
    episodes = f"{tally.episodes} episode{'s' * (tally.episodes != 1)}"
    return f"{episodes} begun, {solved} at the start{time_taken}"


def _begin(world: World, referee: Referee, start: Start, tally: _Tally) -> bool:
    """Reset an episode and check it; False if the world can no longer be used."""
    started = time.perf_counter()
    try:
        world.reset(start.seed)
    except PlacementError as error:
        for finding in error.findings:
            tally.misplaced.setdefault(finding.path, finding)
        return True
    except ExplosionError as error:
        tally.exploded.append(f"{error} ({start})")
        return False
    tally.seconds.append(time.perf_counter() - started)
    tally.episodes += 1
    for name, place in _regions(world.scene):
        tally.positions.setdefault((name, start.variation), []).append(world.position(name))
        if _outside(world, name, place):
            tally.strayed[name] = tally.strayed.get(name, 0) + 1
        elif how := upset(world, name, place):
            tally.upset.setdefault(name, []).append(how)
        over = overhang(world, name, place)
        if over is not None and (name not in tally.hanging or over.by > tally.hanging[name].by):
            tally.hanging[name] = over
    try:
        outcome = referee.start(world)
    except BaseException as error:
        if is_interrupt(error):
            raise
        tally.raised.append(failure_of_description(error, world.task.entry))
        return False
    if outcome.success:
        tally.solved.append(str(start))
    if outcome.failure:
        tally.failed.append(str(start))
    for name, place in _regions(world.scene):
        if name in tally.upset and name not in tally.upright and (how := upset(world, name, place)):
            advice = standing(world, name, place) if how.tilt_deg is not None else ""
            tally.upright[name] = advice
    return True


def _regions(scene: SceneSpec) -> Iterator[tuple[str, Place]]:
    for name, spec in {**scene.objects, **scene.sites}.items():
        if spec.place is not None:
            yield name, spec.place


def _outside(world: World, name: str, place: Place) -> bool:
    frame = world.pose(place.frame) if place.frame != "world" else Pose()
    point = frame.inverse().apply(world.position(name))
    return any(
        abs(point[i] - place.center[i]) > place.size[i] / 2 + SETTLING_M
        for i in range(len(place.center))
    )


def _checks(task: Task, tally: _Tally) -> Iterator[Result]:
    misplaced = [
        finding_at(task, "TB305", finding.message, name, "place")
        for name, finding in tally.misplaced.items()
    ]
    yield _counted("TB305", "everything finds a place", misplaced, len(tally.misplaced))
    total = tally.episodes
    strayed = [
        finding_at(task, "TB310", f"left its region in {count} of {total} resets", name, "place")
        for name, count in tally.strayed.items()
    ]
    strayed += [
        finding_at(task, "TB310", _upset(name, tally), name, "place")
        for name in tally.upset
        if name not in tally.hanging  # which says why
    ]
    yield _counted("TB310", "placements stay inside their regions", strayed, len(strayed))
    hanging = [
        finding_at(task, "TB318", _hangs(name, over, tally), name, "place")
        for name, over in tally.hanging.items()
    ]
    yield _counted("TB318", "regions are on their surfaces", hanging, len(hanging))
    exploded = [finding_of_scene(task, "TB307", text) for text in tally.exploded]
    yield _counted("TB307", "resets do not explode", exploded, len(tally.exploded))
    raised = list(dict.fromkeys(tally.raised))  # in each variation
    yield _counted("TB314", "the description can be asked", raised, len(raised))
    yield _never_at_start(task, "TB311", "success", tally.solved, tally.episodes)
    yield _never_at_start(task, "TB312", "failure", tally.failed, tally.episodes)
    yield _varies(task, tally)


def _upset(name: str, tally: _Tally) -> str:
    """How an object does not stand, how often, and what would help."""
    found = tally.upset[name]
    worst = max(found, key=lambda how: math.inf if how.tilt_deg is None else how.tilt_deg)
    advice = tally.upright.get(name, "")
    often = f"{worst} in {len(found)} of {tally.episodes} resets"
    return f"{often}; {advice}" if advice and worst.tilt_deg is not None else often


def _hangs(name: str, over: Overhang, tally: _Tally) -> str:
    falls = len(tally.upset.get(name, []))
    seen = f"it fell in {falls} of {tally.episodes} resets; " if falls else ""
    return f"{seen}{over}"


def _counted(code: str, name: str, findings: list[Finding], count: int) -> Result:
    return Check(code, name, not findings, count, 0, "things"), findings


def _never_at_start(task: Task, code: str, what: str, seeds: list[str], episodes: int) -> Result:
    findings = []
    if seeds:
        origin = getattr(task.description, what).origin
        message = (
            f"holds already at the start of {len(seeds)} of {episodes} episodes "
            f"({seeds[0]}); it must be false when an episode begins"
        )
        findings = [Finding(code, message, what, origin)]
    return Check(code, f"{what} is false at the start", not seeds, len(seeds), 0, "seeds"), findings


def _varies(task: Task, tally: _Tally) -> Result:
    """Placements of regions that have a size differ from seed to seed."""
    findings: list[Finding] = []
    sized = {name: place for name, place in _regions(task.file.spec.scene) if any(place.size)}
    spreads = []
    for (name, variation), points in tally.positions.items():
        if len(points) < 2 or name not in sized:
            continue
        spread = max(math.dist(points[0], point) for point in points[1:])
        spreads.append(spread / max(sized[name].size))
        if spread < 1e-6:
            found = finding_at(task, "TB313", "is at one place for every seed", name, "place")
            findings += in_variation(variation, [found], findings)
    least = min(spreads, default=1.0)
    return Check("TB313", "placements vary", not findings, least, 0.0, "of the region"), findings
