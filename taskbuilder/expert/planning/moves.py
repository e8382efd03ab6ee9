"""Moves: frames with their goals, and their conversion to parts of a motion."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from taskbuilder.env.actions import can_be_planned
from taskbuilder.errors import UsageError
from taskbuilder.expert.planning.errors import PlanningError
from taskbuilder.expert.planning.reach import Reach
from taskbuilder.expert.planning.subspaces import Arc, ArmJoints, Carried
from taskbuilder.geometry import Pose, turn_between
from taskbuilder.world.world import World

MOST_TILT = math.radians(25.0)
"""Maximum difference of a goal's orientation from what the action mode can command, in rad."""


@dataclass(frozen=True)
class Move:
    """A frame to move to a goal, with the arms that carry it.

    Attributes:
        carriers: Each robot and its tcp in the moved frame: ``{robot: Pose()}`` for an arm's own
            tool, ``{robot: object_from_tcp}`` for an object held by one arm, several robots for
            a load that is held by all of them.
        goal: Goal of the moved frame, in the world.
        straight: Whether only a straight line with an even rotation is allowed.
        speed: Fraction of the speed that the action mode allows, above 0 and at most 1.
        touching: Objects that may be touched, pushed or pressed on the way.
        arc: The arc that leads to the goal in place of the straight line, or None.
        joints: Joint positions (rad or m) at the goal of the only arm, as far as the action mode
            commands joints; None for any.
    """

    carriers: Mapping[str, Pose]
    goal: Pose
    straight: bool = False
    speed: float = 1.0
    touching: Collection[str] = ()
    arc: Arc | None = None
    joints: tuple[float, ...] | None = None

    @property
    def tools(self) -> dict[str, Pose]:
        """The goal of each carrier's tool, in the world."""
        return {name: self.goal @ tcp for name, tcp in self.carriers.items()}

    def by_joints(self, reaches: Mapping[str, Reach]) -> bool:
        """Whether it moves along lines in joint space, and not along lines in the world."""
        alone = len(self.carriers) == 1 and not self.straight
        return alone and not any(reaches[name].in_tool_space for name in self.carriers)

    def carried(self, reaches: Mapping[str, Reach], joints: Mapping[str, ArmJoints]) -> Carried:
        """This move as a part that moves along lines in the world.

        Args:
            reaches: All arms.
            joints: Joint positions of all arms at the start.

        Raises:
            PlanningError: The action mode cannot command the orientation of a tool.
        """
        arms = {name: reaches[name] for name in self.carriers}
        tools = {name: reach.tool(joints[name]) for name, reach in arms.items()}
        for name, goal in self.tools.items():
            _check_tilt(arms[name], goal, "; or write turn_tool: false" if self.arc else "")
        first, grasp = next(iter(self.carriers.items()))
        start = tools[first] @ grasp.inverse()
        grasps = {name: (start.inverse() @ tools[name], end) for name, end in self.carriers.items()}
        return Carried(
            arms, grasps | {first: (grasp, grasp)}, start, self.goal, self.straight, self.arc
        )


def check_moves(moves: Sequence[Move], held: Mapping[str, str], world: World) -> None:
    """Check that moves do not contradict each other or the scene.

    Raises:
        UsageError: They do.
    """
    names = [name for move in moves for name in move.carriers]
    for name in (*names, *held):
        if name not in world.robots:
            raise UsageError(f'there is no robot "{name}": there are {", ".join(world.robots)}')
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"{name} is to make two moves at once")
        action = world.scene.robots[name].action
        if not can_be_planned(action):
            raise UsageError(f"experts do not plan for {action.arm}; use another mode")
    for name in (*held.values(), *(name for move in moves for name in move.touching)):
        if name not in world.objects:
            raise UsageError(f'there is no object "{name}"; there are {", ".join(world.objects)}')
    for move in moves:
        if not move.carriers:
            raise UsageError("a move needs a robot that makes it")
        if not 0.0 < move.speed <= 1.0:
            raise UsageError(f"a speed is above 0 and at most 1, not {move.speed}")


def _check_tilt(reach: Reach, goal: Pose, otherwise: str) -> None:
    tilt = turn_between(goal.quaternion, reach.commandable(goal).quaternion)
    if tilt > MOST_TILT:
        kept = "orientation" if reach.arm.spec.turn == "none" else "tilt"
        raise PlanningError(
            reach.name,
            "out of reach",
            f"{reach.name}'s tool would have to be turned by {math.degrees(tilt):.0f}° more than "
            f"its actions can turn it: the action mode keeps the {kept} that the tool has at home; "
            f"write action: {{turn: full}} for {reach.name}, or turn it less{otherwise}",
        )
