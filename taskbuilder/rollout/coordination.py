"""How robots work together in an episode: how much they move, touch and wait at the same time.

Benchmarks of bimanual manipulation score coordination besides success (BiCoord, arXiv:2604.05831;
DuoBench, arXiv:2606.11901); these are their kinds of figures.

    meter = CoordinationMeter()
    rollout = expert.play(seed=0, watch=meter)
    meter.coordination(rollout.first_success)
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import fmean

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.geometry import Vec3, total

MOVES = 0.02
"""Speed in m/s above which a tool moves."""


@dataclass(frozen=True)
class Coordination:
    """Coordination in an episode.

    Attributes:
        moving: Fraction of the time in which more than one robot moves its tool.
        touching: Fraction of the time in which more than one robot touches the same object.
        waiting: By robot, the fraction of the time in which it stands still while another moves.
        path: By robot, the length of its tool's path in m.
    """

    moving: float
    touching: float
    waiting: Mapping[str, float]
    path: Mapping[str, float]

    @property
    def balance(self) -> float:
        """The shortest path as a fraction of the longest; 1 if all are of the same length."""
        longest = max(self.path.values())
        return min(self.path.values()) / longest if longest else 1.0


@dataclass(frozen=True)
class _Moment:
    tools: Mapping[str, Vec3]
    touched: bool


class CoordinationMeter:
    """Measures coordination in one episode; call it after reset and after each control step."""

    def __init__(self) -> None:
        self._moments: list[_Moment] = []
        self._period = 0.0

    def __call__(self, env: TaskEnv) -> None:
        """Record the current step."""
        world, robots = env.episode.world, env.possible_agents
        self._period = 1.0 / env.task.file.spec.timing.control_hz
        scene = env.task.file.spec.scene.objects
        things = [n for n in world.object_names if not scene[n].fixed or scene[n].joints]
        touched = any(sum(world.touching(robot, name) for robot in robots) > 1 for name in things)
        tools = {robot: world.position(f"{robot}.tcp") for robot in robots}
        self._moments.append(_Moment(tools, touched))

    def coordination(self, steps: int | None = None) -> Coordination:
        """The figures of the episode.

        Args:
            steps: Control steps that count, from the first on; all if None.

        Raises:
            ValueError: No step was recorded.
        """
        moments = self._moments[: None if steps is None else steps + 1]
        if len(moments) < 2:
            raise ValueError("no step was recorded; give the meter to play() as watch")
        robots = tuple(moments[0].tools)
        lengths = {
            robot: [
                math.dist(before.tools[robot], after.tools[robot])
                for before, after in pairwise(moments)
            ]
            for robot in robots
        }
        moves = {r: [d > MOVES * self._period for d in own] for r, own in lengths.items()}
        numbers = [sum(now) for now in zip(*moves.values(), strict=True)]
        return Coordination(
            moving=_fraction([number > 1 for number in numbers]),
            touching=_fraction([moment.touched for moment in moments[1:]]),
            waiting={
                robot: _fraction([n > 0 and not m for n, m in zip(numbers, own, strict=True)])
                for robot, own in moves.items()
            },
            path={robot: total(own) for robot, own in lengths.items()},
        )


def _fraction(flags: Sequence[bool]) -> float:
    return fmean(map(float, flags))
