"""Whether suction meets a surface at the grasp points that an expert takes; of the reach family."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from taskbuilder.errors import Finding
from taskbuilder.expert.script.orders import grasp_turn
from taskbuilder.expert.script.situation import carrier_of, grasp_of
from taskbuilder.geometry import Pose
from taskbuilder.schema.expert import each_order
from taskbuilder.schema.source import Path_
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.locate import finding_in_file, in_variation
from taskbuilder.validate.report import Check, Result
from taskbuilder.world.suction import FARTHEST_M, Suction
from taskbuilder.world.world import World


class CupGap(NamedTuple):
    """What a cup finds at a grasp point.

    Attributes:
        path: The order in the task file.
        robot: The robot.
        point: The grasp point.
        metres: Distance to the surface; negative if the point is inside, infinite if far.
        reach: How far the cup reaches, in metres.
    """

    path: Path_
    robot: str
    point: str
    metres: float
    reach: float

    @property
    def misses(self) -> bool:
        """Whether the cup finds no surface within its reach, or would be inside."""
        return abs(self.metres) > self.reach

    def __str__(self) -> str:
        far = f"more than {FARTHEST_M * 1000:.0f} mm"
        far = f"{abs(self.metres) * 1000:.0f} mm" if math.isfinite(self.metres) else far
        side = "inside" if self.metres < 0.0 else "above"
        return (
            f"{self.robot} would suck on nothing: {self.point} is {far} {side} the surface, and "
            f"its cup reaches {self.reach * 1000:g} mm; {self._right}"
        )

    @property
    def _right(self) -> str:
        if not math.isfinite(self.metres):
            return "put the grasp point on the surface that the cup comes to by its approach"
        way = "back against" if self.metres < 0.0 else "on along"
        return f"move the grasp point {abs(self.metres) * 1000:.0f} mm {way} its approach"


def check_suction(context: Context) -> Result:
    """Measure the distance to the surface at all grasp points that are taken by suction."""
    firsts = {start.variation: start for start in reversed(context.every_start)}
    robots = context.task.file.robots
    takes = any(
        robots[name].spec.suction for _, name, _ in each_order(context.task.file.spec.expert)
    )
    starts = sorted(firsts.values()) if takes else []
    worst = 0.0
    findings: list[Finding] = []
    for start, gaps in zip(starts, context.ask(find_gaps, starts, "suction"), strict=True):
        worst = max([worst, *(abs(gap.metres) for gap in gaps)])
        missed = [
            finding_in_file(context.task, "TB512", str(gap), *gap.path)
            for gap in gaps
            if gap.misses
        ]
        findings += in_variation(start.variation, missed, findings)
    value = worst * 1000.0 if math.isfinite(worst) else None
    check = Check("TB512", "suction meets a surface", not findings, value, None, "mm")
    return check, findings


# --- in each process


def find_gaps(cache: EnvCache, start: Start) -> list[CupGap]:
    """The gaps at all grasp points that the expert takes by suction."""
    env = cache.env(start.variation)
    env.reset(seed=start.seed)
    return list(_gaps(env.episode.world))


def _gaps(world: World) -> Iterator[CupGap]:
    for path, robot, order in each_order(world.spec.expert):
        cup = world.robots[robot].gripper
        grasp = grasp_of(world.scene, order.grasp) if order.grasp else None
        if grasp is None or order.grasp is None or not isinstance(cup, Suction):
            continue
        at = world.pose(order.grasp)
        tool = Pose(at.position, grasp_turn(grasp, at))
        body = world.objects[carrier_of(world.scene, order.grasp).partition(".")[0]].body
        yield CupGap((*path, "grasp"), robot, order.grasp, cup.gap(body, tool), cup.reach)
