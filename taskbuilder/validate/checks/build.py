"""The build family: builds every variation of a task and lets it rest."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from taskbuilder.assets.model import Urdf
from taskbuilder.cameras import CameraView
from taskbuilder.errors import ExplosionError, FileError, Finding, PlacementError
from taskbuilder.geometry import norm
from taskbuilder.schema.camera import FURTHEST_M, NEAREST_M
from taskbuilder.sim.body import Body
from taskbuilder.sim.contacts import gaps
from taskbuilder.task import Task
from taskbuilder.validate.checks.loads import check_loads
from taskbuilder.validate.context import Context
from taskbuilder.validate.locate import finding_at, finding_of_scene, in_variation
from taskbuilder.validate.report import Check, FamilyResult, Result
from taskbuilder.world.hollows import filled_hollows
from taskbuilder.world.inertias import doubtful_inertias, inertias
from taskbuilder.world.pictures import capture
from taskbuilder.world.placement import place_all
from taskbuilder.world.randomness import EpisodeRandomness
from taskbuilder.world.shapes import distance_from
from taskbuilder.world.world import World

OVERLAP_MM = 2.0  # Bullet's hulls of meshes are 1 mm too large each
REST_S = 1.0
DRIFT_MM = 5.0
REST_SPEED = 0.02
SEEN_SHARE = 0.005
DENSITY = (10.0, 25_000.0)  # kg/m³: from foam to beyond lead
AMBIGUOUS_M = 0.001  # a link that is no nearer than this is not what is meant
LONGEST_M = 2.0  # what is longer and far too light is a mesh in another unit
ENERGY_PER_KG = 50.0  # J/kg: falling five metres


def build_family(context: Context) -> FamilyResult:
    """Build every variation, and let each rest for a second."""
    task, measures = context.task, context.measures
    check, found = check_inertias(task)
    checks = {check.code: check}
    findings = list(found)
    for variation in context.progress(range(context.variations), "build"):
        wrong: list[Finding] = []
        started = time.perf_counter()
        try:
            world = context.world(variation)
        except FileError as error:
            findings += in_variation(variation, error.findings, findings)
            continue
        measures.setdefault("build_s", time.perf_counter() - started)
        wrong += world.warnings
        try:
            for check, found in _look(task, world):
                known = checks.get(check.code)
                checks[check.code] = check if known is None or known.ok else known
                wrong += found
        except PlacementError as error:
            wrong += [finding_at(task, f.code, f.message, f.path, "place") for f in error.findings]
        except ExplosionError as error:
            wrong.append(finding_of_scene(task, "TB307", str(error)))
            context.close_world(variation)
        findings += in_variation(variation, wrong, findings)
    for code in {finding.code for finding in findings if finding.severity == "error"}:
        count = sum(finding.code == code for finding in findings)
        checks.setdefault(code, Check(code, _GAVE_UP.get(code, "loads"), False, count, 0, "things"))
    return FamilyResult(
        "build", tuple(checks.values()), tuple(findings), _summary(checks, measures)
    )


_GAVE_UP = {
    "TB303": "homes can be reached",
    "TB305": "everything finds a place",
    "TB307": "energy stays bounded",
}
"""Names of the checks after whose failure a variation is not checked further."""


def _summary(checks: dict[str, Check], measures: dict[str, float]) -> str:
    parts = []
    if "TB306" in checks:
        words = "at rest within" if checks["TB306"].ok else "moved up to"
        parts.append(f"{words} {checks['TB306'].value:.1f} mm")
    if "build_s" in measures:
        parts.append(f"{measures['build_s']:.2f} s to build")
    return ", ".join(parts) or "cannot be built"


def _look(task: Task, world: World) -> Iterator[Result]:
    yield check_masses(task, world)
    yield check_loads(task, world)
    yield check_grasp_points(task, world)
    place_all(world, EpisodeRandomness(0).placement())
    overlap = check_overlap(task, world)
    yield overlap
    if not overlap[0].ok:
        return  # the physics would push them apart, and more would seem to be wrong
    world.reset(0)
    yield check_cameras(task, world)
    yield from check_rest(task, world)


def check_inertias(task: Task) -> Result:
    """Moments of inertia and centres of mass fit the shapes of URDFs."""
    objects = task.file.spec.scene.objects
    factors = [
        inertia.factor
        for name, asset in task.file.assets.items()
        if isinstance(asset, Urdf) and name in objects
        for inertia in inertias(asset, fixed=objects[name].fixed)
    ]
    furthest = max(factors, key=lambda factor: abs(math.log(factor)), default=1.0)
    check = Check("TB422", "inertias fit the shapes", True, furthest, None, "times")
    return check, [*doubtful_inertias(task.file), *filled_hollows(task.file)]


def check_masses(task: Task, world: World) -> Result:
    """Every body that moves has a density between foam and lead."""
    findings = []
    densities = [1000.0]
    for name, thing in world.objects.items():
        if thing.spec.fixed or thing.spec.mass is None:
            continue
        volume = 8.0 * math.prod(world.box(name).half)
        density = thing.body.mass / volume
        densities.append(density)
        if not DENSITY[0] <= density <= DENSITY[1]:
            least, most = (volume * limit for limit in DENSITY)
            message = (
                f"{name} weighs {thing.body.mass:g} kg at {volume * 1e6:.3g} cm³ of bounding box; "
                f"from {least:.2g} to {most:.2g} kg would be plausible"
            )
            place = "mass"
            shape, edge = thing.spec.shape, 2.0 * max(world.box(name).half)
            if shape and shape.mesh and shape.scale is None and edge > LONGEST_M:
                message = f"{name} is {edge:.3g} m long; a mesh in millimetres needs scale: 0.001"
                place = "shape"
            findings.append(finding_at(task, "TB308", message, name, place, severity="warning"))
    extreme = max(densities, key=lambda density: abs(math.log(density / 1000.0)))
    check = Check("TB308", "masses are plausible", True, extreme, None, "kg/m³")
    return check, findings


def check_grasp_points(task: Task, world: World) -> Result:
    """No grasp point on a part that moves is fixed to the base, where it would stay behind."""
    findings = []
    for name, thing in world.objects.items():
        urdf = task.file.assets.get(name)
        if not isinstance(urdf, Urdf):
            continue
        size = (thing.spec.shape.scale if thing.spec.shape else None) or 1.0
        into = {
            link.name: thing.body.pose_of(link.name).inverse() @ world.pose(name)
            for link in urdf.links
        }
        for grasp, point in thing.spec.grasps.items():
            gaps = {
                link.name: distance_from(link.collisions, size, into[link.name].apply(point.at))
                for link in urdf.links
            }
            moving = [link for link in gaps if urdf.moving_joints_above(link)]
            nearest = min(moving, key=gaps.__getitem__, default="")
            fixed = min((gap for link, gap in gaps.items() if link not in moving), default=math.inf)
            if point.link is not None or not nearest or gaps[nearest] > fixed - AMBIGUOUS_M:
                continue
            at = ", ".join(f"{round(x, 4) + 0.0:g}" for x in into[nearest].apply(point.at))
            message = (
                f"{name}.{grasp} is on {nearest}, and stays behind when that moves: it is fixed to "
                f"{urdf.root}; write {{at: [{at}], link: {nearest}}}, in the frame of that link, "
                f"or link: {urdf.root} if it is to stay"
            )
            path = ("grasps", grasp)
            findings.append(finding_at(task, "TB316", message, name, *path, severity="warning"))
    count = len(findings)
    check = Check("TB316", "grasp points go with what they are on", True, count, None, "points")
    return check, findings


def check_overlap(task: Task, world: World) -> Result:
    """No body starts inside another."""
    bodies: list[Body] = [robot.body for robot in world.robots.values()]
    bodies += [thing.body for thing in world.objects.values()]
    bodies += [world.floor] if world.floor else []
    findings, deepest = [], 0.0
    for one, other in combinations(bodies, 2):
        nearest = min(gaps(one, other, 0.0), key=lambda gap: gap.distance, default=None)
        depth = 0.0 if nearest is None else max(0.0, -nearest.distance * 1000.0)
        deepest = max(deepest, depth)
        if nearest is not None and depth > OVERLAP_MM:
            part, inside = one.called(nearest.link_a), other.called(nearest.link_b)
            message = f"{part} starts {depth:.1f} mm inside {inside}; move one of them"
            findings.append(finding_at(task, "TB304", message, one.name))
    check = Check("TB304", "no body starts inside another", not findings, deepest, OVERLAP_MM, "mm")
    return check, findings


def check_cameras(task: Task, world: World) -> Result:
    """Every camera sees something other than floor and background."""
    findings, least = [], 1.0
    named = (*world.robots, *world.objects, *world.sites)
    world.move_markers()
    for name in world.scene.cameras:
        view = world.camera(name, (64, 48))
        seen = float(np.mean(capture(world, view).shows(*named)))
        least = min(least, seen)
        if seen < SEEN_SHARE:
            message = f"{name} sees nothing of the scene; {_help_to_see(world, view, named)}"
            location = task.file.source.locate(("scene", "cameras", name), key=True)
            findings.append(Finding("TB309", message, f"scene.cameras.{name}", location))
    check = Check("TB309", "cameras see the scene", not findings, least, SEEN_SHARE, "share")
    return check, findings


def _help_to_see(world: World, view: CameraView, named: Sequence[str]) -> str:
    """What to change in a camera that does not see enough of these bodies."""
    image = capture(world, replace(view, near=NEAREST_M, far=FURTHEST_M))
    there = image.shows(*named)
    if np.mean(there) < SEEN_SHARE:
        return "move it, or turn it by look_at"
    nearest, furthest = float(image.depth[there].min()), float(image.depth[there].max())
    if nearest > view.far:
        return f"it begins {nearest:.3g} m away, beyond far: {view.far:g}; make far larger"
    return f"it ends {furthest:.3g} m away, before near: {view.near:g}; make near smaller"


def check_rest(task: Task, world: World) -> Iterator[Result]:
    """Objects come to rest near their initial positions, without gaining energy."""
    start = {name: world.position(name) for name in world.objects}
    highest = 0.0
    try:
        for _ in range(max(1, round(REST_S * world.spec.timing.control_hz))):
            world.step()
            highest = max(highest, _energy(world))
    except ExplosionError as error:
        check = Check("TB307", "energy stays bounded", False, None, ENERGY_PER_KG, "J/kg")
        yield check, [finding_of_scene(task, "TB307", str(error))]
        return
    wild = highest > ENERGY_PER_KG
    message = f"things move with {highest:.0f} J/kg although nothing drives them; look for overlap"
    findings = [finding_at(task, "TB307", message, next(iter(world.objects)))] if wild else []
    yield Check("TB307", "energy stays bounded", not wild, highest, ENERGY_PER_KG, "J/kg"), findings
    yield _at_rest(task, world, start)


def _at_rest(task: Task, world: World, start: dict[str, tuple[float, float, float]]) -> Result:
    findings, furthest = [], 0.0
    for name, thing in world.objects.items():
        if thing.spec.fixed:
            continue
        drift = math.dist(start[name], world.position(name)) * 1000.0
        speed = norm(world.velocity(name)[0])
        furthest = max(furthest, drift)
        if drift > DRIFT_MM or speed > REST_SPEED:
            still = f", and still moves at {speed:.2f} m/s" if speed > REST_SPEED else ""
            surface = thing.spec.place.surface if thing.spec.place is not None else None
            advice = "put it on a surface"
            if surface is not None:
                advice = f"its place on {surface} does not bear it: it falls or slides from there"
            message = (
                f"{name} does not stay: after {REST_S:g} s it is {drift:.0f} mm from its start, "
                f"where {DRIFT_MM:g} mm are allowed{still}; {advice}"
            )
            inner = () if surface is None else ("place",)
            findings.append(finding_at(task, "TB306", message, name, *inner))
    check = Check(
        "TB306", "objects stay where they are put", not findings, furthest, DRIFT_MM, "mm"
    )
    return check, findings


def _energy(world: World) -> float:
    """Maximum translational kinetic energy of any object, in J/kg."""
    speeds = [norm(world.velocity(name)[0]) for name in world.objects]
    return max((speed * speed / 2.0 for speed in speeds), default=0.0)
