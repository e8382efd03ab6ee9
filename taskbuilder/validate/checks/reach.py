"""The reach family: every pose that the expert needs is reachable for its robot.

A dry run goes through the stages without physics, from every seed in every variation. For each
order the pose that lies farthest from the robot's shoulder is tried farther out still, along the
line from the shoulder through it, to find out how much there is to spare.

A dry run may foresee wrongly where things are by then. Wherever it finds a pose out of reach the
expert is played as well: a stage that it carries out asks for nothing out of reach, and a task in
which it succeeds is not wrong.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

from taskbuilder.errors import Finding
from taskbuilder.expert.script.dry_run import Asked, dry_run
from taskbuilder.geometry import Pose, norm, subtract
from taskbuilder.validate.checks.belonging import check_belonging
from taskbuilder.validate.checks.suction import check_suction
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.locate import finding_in_file, in_variation
from taskbuilder.validate.reaching import FARTHEST_M, margin_of, reaches, shoulder_of
from taskbuilder.validate.report import Check, FamilyResult

Key = tuple[int, str, str]
"""An order: the number of its stage, its robot, and its words."""

Verdict = Literal["fine", "warning", "error", ""]


class Reached(NamedTuple):
    """Whether a robot can reach a required pose.

    Attributes:
        start: The start of the episode.
        asked: The required pose with its alternatives.
        pose: World pose of the tcp: the first reachable alternative, or else the first.
        ok: Whether it is reachable.
        distance: Distance of the pose from the robot's shoulder, in metres.
    """

    start: Start
    asked: Asked
    pose: Pose
    ok: bool
    distance: float

    @property
    def key(self) -> Key:
        """The order that it belongs to."""
        return self.asked.stage, self.asked.robot, self.asked.order


class Margin(NamedTuple):
    """The distance of a pose from the edge of the workspace.

    Attributes:
        reached: The pose.
        metres: How much farther out it could be; negative if it must be closer.
        others: The other robots that reach it; only of a pose that its own does not reach.
    """

    reached: Reached
    metres: float
    others: tuple[str, ...] = ()


def reach_family(context: Context) -> FamilyResult:
    """Rehearse the expert's stages from every seed."""
    if not context.task.file.spec.expert:
        return FamilyResult("reach", (), (), "no expert")
    starts = context.every_start
    found = [reached for each in context.ask(dry_run_from, starts, "reach") for reached in each]
    judged = [(reached, _verdict(context, reached)) for reached in _play_missed(context, found)]
    missed = [(reached, verdict) for reached, verdict in judged if verdict and not reached.ok]
    extremes: dict[Key, Reached] = {}
    for reached, verdict in judged:
        known = extremes.get(reached.key)
        if verdict and (known is None or _severity(reached) > _severity(known)):
            extremes[reached.key] = reached
    listed = sorted(extremes.values(), key=lambda reached: reached.start)
    margins = list(
        context.ask(find_margin, [r.start for r in listed], "reach, margins", about=listed)
    )
    worst = min(margins, key=lambda margin: margin.metres, default=None)
    findings = _findings(context, missed, margins)
    value = worst.metres * 100.0 if worst and math.isfinite(worst.metres) else None
    ok = all(verdict == "warning" for _, verdict in missed)
    check = Check("TB511", "the expert's poses can be reached", ok, value, 0.0, "cm")
    others = [check_suction(context), *(check_belonging(context) if ok else ())]
    checks = (check, *(each for each, _ in others))
    rest = (finding for _, each in others for finding in each)
    return FamilyResult("reach", checks, (*findings, *rest), _summary(context, found, worst))


def _play_missed(context: Context, found: Sequence[Reached]) -> Sequence[Reached]:
    """Play the expert from every start with a pose that seems out of reach."""
    starts = sorted({reached.start for reached in found if not reached.ok})
    if starts and context.has_expert:
        for _ in context.demonstrate(starts, "reach, played"):
            pass  # they are kept by the run
    return found


def _verdict(context: Context, reached: Reached) -> Verdict:
    """The verdict on a pose; "" if the simulation shows that it is reachable."""
    if reached.ok:
        return "fine"
    asked, played = reached.asked, context.demonstrations.get(reached.start)
    if played is None:  # the expert cannot be played
        return "warning" if asked.guess else "error"
    if len(played.stage_ends) >= asked.stage:
        return ""
    trouble = played.trouble
    stopped = trouble is not None and (trouble.stage, trouble.robot) == (asked.stage, asked.robot)
    if played.success:
        return "warning" if stopped else ""
    return "error" if stopped or not asked.guess else ""


def _severity(reached: Reached) -> tuple[bool, float]:
    return not reached.ok, reached.distance


def _summary(context: Context, found: Sequence[Reached], worst: Margin | None) -> str:
    stages = len(context.task.file.spec.expert)
    counted = f"{stages} stage{'s' * (stages != 1)}"
    if not found:
        return f"{counted}, which ask for no pose"
    guesses = dict.fromkeys(reached.asked.guess for reached in found if reached.asked.guess)
    rough = f"; where {' and '.join(guesses)} will be is a guess" if guesses else ""
    if worst is None:
        return f"{counted}{rough}"
    stage, robot, order = worst.reached.key
    where = f"({robot}, stage {stage}: {order})"
    if not math.isfinite(worst.metres):
        return f"{counted}, one beyond all reach {where}{rough}"
    return f"{counted}, worst margin {worst.metres * 100:.0f} cm {where}{rough}"


def _findings(
    context: Context, missed: Sequence[tuple[Reached, Verdict]], margins: Sequence[Margin]
) -> list[Finding]:
    """A finding for each order with an unreachable pose."""
    short = {margin.reached.key: margin for margin in margins}
    findings: list[Finding] = []
    for key in dict.fromkeys(reached.key for reached, _ in missed):
        stage, robot, order = key
        mine = [(reached.start, verdict) for reached, verdict in missed if reached.key == key]
        starts = list(dict.fromkeys(start for start, _ in mine))
        wrong = any(verdict == "error" for _, verdict in mine)
        margin = short[key]
        x, y, z = margin.reached.pose.position
        message = (
            f"{robot} cannot reach what it is to {order}, ({x:.2f}, {y:.2f}, {z:.2f}), from "
            f"{len(starts)} of {len(context.every_start)} placements: at worst, from "
            f"{margin.reached.start}, {_far(margin.metres)}; {_right(margin)}"
        )
        if not wrong and context.has_expert:
            message += "; the expert succeeds without it"
        severity: Literal["error", "warning"] = "error" if wrong else "warning"
        path = ("expert", stage - 1, robot)
        found = finding_in_file(context.task, "TB511", message, *path, severity=severity)
        findings += in_variation(starts[0].variation, [found], findings)
    return findings


def _far(metres: float) -> str:
    if math.isfinite(metres):
        return f"it is {-metres * 100:.0f} cm too far out"
    return f"even {FARTHEST_M:g} m nearer would be out of reach"


def _right(margin: Margin) -> str:
    """What would be right."""
    robot = margin.reached.asked.robot
    if math.isfinite(margin.metres):
        right = f"move it, or the base of {robot}, by as much"
    else:
        right = f"turn the tool otherwise, or bring it nearer to {robot}"
    others = " or ".join(margin.others)
    return f"{right}, or let {others} do it, which can reach it" if others else right


# --- in each process


def dry_run_from(cache: EnvCache, start: Start) -> list[Reached]:
    """All poses that the expert needs from a start."""
    env = cache.env(start.variation)
    env.reset(seed=start.seed)
    world = env.episode.world
    found = []
    for asked in dry_run(world):
        robot = world.robots[asked.robot]
        good = next((pose for pose in asked.choices if reaches(robot, pose)), None)
        pose = good or asked.choices[0]
        distance = norm(subtract(pose.position, shoulder_of(robot)))
        found.append(Reached(start, asked, pose, good is not None, distance))
    return found


def find_margin(cache: EnvCache, reached: Reached) -> Margin:
    """How much farther from the shoulder a pose could be, by bisection."""
    robots = cache.env(reached.start.variation).episode.world.robots
    metres = margin_of(robots[reached.asked.robot], reached.pose, ok=reached.ok)
    others = tuple(
        name
        for name, robot in robots.items()
        if not reached.ok and name != reached.asked.robot and reaches(robot, reached.pose)
    )
    return Margin(reached, metres, others)
