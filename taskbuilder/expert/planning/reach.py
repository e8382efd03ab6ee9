"""An arm as planning sees it: what its action mode can command, and how far in a control step."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Self

from taskbuilder.env.actions import make_mode
from taskbuilder.env.arm_modes import Arm, ArmMode
from taskbuilder.geometry import (
    Pose,
    Quat,
    conjugate,
    multiply,
    norm,
    normalized,
    scale,
    subtract,
    turn_between,
)
from taskbuilder.world.world import World

NEARLY = 0.999
"""Share of a limit that is used: a straight line of the joints is a slightly curved one of the
tool, and actions are rounded."""

LADEN_SPEED = 0.6
"""How fast a tool goes that carries something, m/s: grasps by friction give way beyond."""

BOLDEST = 0.5
"""How far a joint may turn (rad) or slide (m) while the tool follows a line by a small step."""


@dataclass(frozen=True)
class Reach:
    """An arm that moves.

    Attributes:
        mode: What its actions command, and how far in a control step.
        world_from_base: Where it stands.
    """

    mode: ArmMode
    world_from_base: Pose

    @classmethod
    def of(cls, world: World, robot: str) -> Self:
        """An arm of a world."""
        built = world.robots[robot]
        dt = 1.0 / world.spec.timing.control_hz
        arm = Arm.of(world, built, world.scene.robots[robot].action, dt)
        return cls(make_mode(arm), arm.base_from_world.inverse())

    @property
    def arm(self) -> Arm:
        """Its kinematics, and the limits of its joints."""
        return self.mode.arm

    @property
    def name(self) -> str:
        """The robot."""
        return self.arm.robot.name

    @property
    def in_tool_space(self) -> bool:
        """Whether actions command the tool rather than the joints."""
        return self.mode.space == "tool"

    def tool(self, joints: tuple[float, ...]) -> Pose:
        """Pose of the tool in the world."""
        return self.world_from_base @ self.arm.ik.forward(joints)

    def follow(self, joints: tuple[float, ...], tool: Pose) -> tuple[float, ...]:
        """Joints that bring the tool to a pose in the world that is a small step away."""
        return self._known_steps(joints, tool)

    @cached_property
    def _known_steps(self) -> Callable[[tuple[float, ...], Pose], tuple[float, ...]]:
        """`follow`, kept for a while: one search goes along the same lines again and again."""
        return lru_cache(maxsize=2048)(self._step_towards)

    def _step_towards(self, joints: tuple[float, ...], tool: Pose) -> tuple[float, ...]:
        target = self.arm.base_from_world @ tool
        return self.arm.ik.step(joints, target, self._boldest)

    @cached_property
    def _boldest(self) -> tuple[float, ...]:
        return (BOLDEST,) * len(self.arm.longest)

    def commandable(self, tool: Pose) -> Pose:
        """The pose nearest to one in the world that the tool can be commanded to.

        Modes that do not turn the tool freely keep its tilt from home, or all of its orientation.
        """
        spec = self.arm.spec
        if not self.in_tool_space or spec.turn == "full":
            return tool
        home = self._home
        if spec.turn == "none":
            return Pose(tool.position, home)
        _, _, z, w = multiply(conjugate(home), tool.quaternion)
        size = math.hypot(z, w)
        turn: Quat = (0.0, 0.0, z / size, w / size) if size > 1e-9 else (0.0, 0.0, 0.0, 1.0)
        return Pose(tool.position, multiply(home, turn))

    @cached_property
    def _home(self) -> Quat:
        """Orientation of the tool at home, in the world."""
        return multiply(self.world_from_base.quaternion, self.arm.home)

    def cost(
        self,
        before: Sequence[float],
        after: Sequence[float],
        tools: tuple[Pose, Pose],
        *,
        laden: bool,
    ) -> float:
        """Control steps that a small motion takes at least.

        Args:
            before: Joints where it begins.
            after: Joints where it ends.
            tools: Poses of the tool there.
            laden: Whether the tool carries something.
        """
        cost = max(abs(b - a) / most for a, b, most in zip(before, after, self._most, strict=True))
        begin, end = tools
        distance = norm(subtract(end.position, begin.position))
        if laden:
            cost = max(cost, distance / (LADEN_SPEED * self.arm.dt))
        if self.in_tool_space:
            spec = self.arm.spec
            turn = turn_between(begin.quaternion, end.quaternion)
            cost = max(cost, distance / spec.max_step, turn / math.radians(spec.max_turn_deg))
        return cost / NEARLY

    @cached_property
    def _most(self) -> tuple[float, ...]:
        """How far each joint may move in a control step."""
        return self.mode.longest


def between(begin: Pose, end: Pose, share: float) -> Pose:
    """A pose on the way from one to another: positions in a line, orientations on an arc."""
    ax, ay, az = begin.position
    bx, by, bz = end.position
    position = (ax + share * (bx - ax), ay + share * (by - ay), az + share * (bz - az))
    return Pose(position, part_of_turn(begin.quaternion, end.quaternion, share))


def part_of_turn(begin: Quat, end: Quat, share: float) -> Quat:
    """An orientation on the shortest turn from one to another."""
    x, y, z, w = multiply(end, conjugate(begin))
    if w < 0.0:
        x, y, z, w = -x, -y, -z, -w
    sine = math.sqrt(x * x + y * y + z * z)
    if sine < 1e-9:
        return end if share > 0.5 else begin
    half = share * math.atan2(sine, w)
    axis = scale((x, y, z), math.sin(half) / sine)
    return normalized(multiply((*axis, math.cos(half)), begin))
