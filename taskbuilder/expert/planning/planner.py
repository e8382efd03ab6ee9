"""Collision-free motion planning for several arms at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.planning.clearance import Clearance
from taskbuilder.expert.planning.collision_world import AttachedObject, CollisionWorld
from taskbuilder.expert.planning.errors import PlanningError
from taskbuilder.expert.planning.goals import ends, goal_of
from taskbuilder.expert.planning.moves import Move, check_moves
from taskbuilder.expert.planning.search import Search, Waypoints
from taskbuilder.expert.planning.spaces import Space
from taskbuilder.expert.planning.subspaces import ArmJoints, Jointed, Subspace
from taskbuilder.expert.planning.timing import Trajectory, timed
from taskbuilder.world.world import World

__all__ = ["Move", "Planner", "PlanningError", "Trajectory"]

FAR, FAR_M = 2.0, 0.3
"""Joint solutions farther than this multiple of the nearest plus this distance (m) count as far; a
search for a detour to nearer ones comes first."""

MOST_SEARCHED = 2
"""Maximum number of joint solutions at the goal for which trees are grown."""

Look = Callable[[Search], Waypoints | None]


class Planner:
    """Plans motions in an environment, without changing it.

    Distances are computed in a copy of the environment's world, which is made on first use.

    Args:
        env: Any environment of a task.
    """

    def __init__(self, env: TaskEnv) -> None:
        self._env = env
        self._collision_worlds: dict[int, CollisionWorld] = {}

    def plan(
        self,
        moves: Sequence[Move],
        *,
        held: Mapping[str, str] = {},
        rng: np.random.Generator,
    ) -> Trajectory:
        """Plan simultaneous moves from the current state.

        Robots that do not move stay at their commanded positions. Held objects, and objects that
        lie on these, move with the tools.

        Args:
            moves: The moves; each robot is in at most one of them.
            held: The object that each robot holds now.
            rng: Generator of the search, if no straight path is free.

        Raises:
            PlanningError: There is no plan.
            UsageError: The moves contradict each other, or an arm's action mode commands torques.
        """
        live = self._env.episode.world
        check_moves(moves, held, live)
        if not moves:
            return Trajectory({})
        world = self._collision_world(live)
        joints = world.copy(live)
        moving = tuple(name for move in moves for name in move.carriers)
        riders = world.riders(live, dict(sorted(held.items(), key=lambda i: i[0] not in moving)))
        motion = _Motion(world, moves, moving, joints, held, riders, rng)
        space, path = motion.path()
        speeds = {name: move.speed for move in moves for name in move.carriers}
        laden = {rider.robot for rider in riders}
        return timed(path, space.reaches, speeds, laden)

    def close(self) -> None:
        """Free the copies of the world."""
        for collision_world in self._collision_worlds.values():
            collision_world.close()
        self._collision_worlds.clear()

    def _collision_world(self, live: World) -> CollisionWorld:
        key = id(live.scene)
        if key not in self._collision_worlds:
            self._collision_worlds[key] = CollisionWorld(live)
        return self._collision_worlds[key]


@dataclass(frozen=True)
class _Motion:
    """A planning problem."""

    collision_world: CollisionWorld
    moves: Sequence[Move]
    moving: Sequence[str]
    joints: Mapping[str, ArmJoints]
    held: Mapping[str, str]
    riders: Sequence[AttachedObject]
    rng: np.random.Generator

    def path(self) -> tuple[Space, Waypoints]:
        """The first path that is found.

        Raises:
            PlanningError: No path is found.
        """
        first: Search | None = None
        for search, look in self._attempts():
            first = first or search
            path = look(search)
            if path is not None:
                return search.space, path
        if first is None:
            raise PlanningError("", "no path", "there is nothing to try")
        raise first.no_path()

    def _attempts(self) -> Iterator[tuple[Search, Look]]:
        """The attempts in order, the cheapest and the nearest first."""
        reaches = self.collision_world.reaches
        lines = [move.carried(reaches, self.joints) for move in self.moves]
        if not any(move.by_joints(reaches) for move in self.moves):
            search = self._search(Space(lines))
            yield search, Search.straight
            yield search, Search.simple
            yield search, Search.connect
            return
        # For joint-space modes, lines in joint space come first, then lines in the world.
        open_ends = self._open(self._ends(lines))
        nearest = next(open_ends)
        yield nearest, Search.straight
        exact = any(move.joints is not None for move in self.moves)
        worldly = iter([] if exact else [Space(lines)])
        for search in self._open(worldly, strict=False):
            yield search, Search.straight
            yield search, Search.simple
        others = list(open_ends)
        limit = FAR * nearest.length + FAR_M
        near = [search for search in others if search.length <= limit]
        yield from ((search, Search.straight) for search in near)
        yield from ((search, Search.simple) for search in (nearest, *near))
        yield from ((search, Search.connect) for search in (nearest, *near)[:MOST_SEARCHED])
        yield from ((search, Search.straight) for search in others if search.length > limit)

    def _ends(self, lines: Sequence[Subspace]) -> Iterator[Space]:
        goals = {}
        parts: list[Subspace] = []
        for move, line in zip(self.moves, lines, strict=True):
            if move.by_joints(self.collision_world.reaches):
                ((name, goal),) = move.tools.items()
                begin = self.joints[name]
                if move.joints is None:
                    goals[name] = goal
                parts.append(Jointed(line.arms[name], begin, move.joints or begin))
            else:
                parts.append(line)
        return ends(parts, goals, self.rng)

    def _open(self, spaces: Iterator[Space], *, strict: bool = True) -> Iterator[Search]:
        """Searches in spaces whose end is free.

        Raises:
            PlanningError: No end is free, and ``strict`` is set.
        """
        refusal: PlanningError | None = None
        free = False
        for space in spaces:
            try:
                search = self._search(space)
            except PlanningError as blocked:
                refusal = refusal or blocked
                continue
            free = True
            yield search
        if refusal is not None and strict and not free:
            raise refusal

    def _search(self, space: Space) -> Search:
        """A search in a space.

        Raises:
            PlanningError: Its end is out of reach or in collision.
        """
        start = space.start(self.joints)
        goal = goal_of(space, start, self.rng)
        touching = {name: move.touching for move in self.moves for name in move.carriers}
        clearance = Clearance(self.collision_world, self.moving, self.riders, self.held, touching)
        clearance.between(start.posture, goal.posture)
        return Search(space, clearance, start, goal, self.rng)
