"""The ladder that is made from an expert's stages, for tasks that write no progress.

`StageLadder` reads it while an episode is played, and `stage_ladder_along` along a recorded one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.expert.ladder.kept import kept_time
from taskbuilder.expert.ladder.orders import Done, OrderStart, closeness, done, start_of
from taskbuilder.expert.ladder.script import HeldObject, LadderOrder, ladder_stages
from taskbuilder.rollout.play import replay
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.expert import Together
from taskbuilder.schema.order import NOTHING
from taskbuilder.world.world import World

UNFINISHED = 0.8
"""What an order is worth at most until its condition is reached."""

BUMPS = 2
"""Control steps without a grip after which an object counts as lost; as for the expert."""


@dataclass(frozen=True)
class Position:
    """How far an episode has come in the script; an immutable value.

    Attributes:
        stage: Number of stages that are done.
        orders: Number of orders of the current stage that each robot has done.
        starts: What was the case when the turn of each robot's order came.
        missed: Control steps for which each robot has not held what it should hold.
        value: The value of the ladder.
    """

    stage: int
    orders: Mapping[str, int]
    starts: Mapping[str, OrderStart]
    missed: Mapping[str, int]
    value: float = 0.0


class StageLadder:
    """How far an episode has come by the expert's stages, from 0 to 1; deterministic.

    With n stages, it is at most n / (n + 1) until what success asks for holds, and 1 while success
    holds::

        value = mean over robots of (stages done + share of the stage) / (n + 1)

    The share of a stage is that of the robot's orders in it: done orders count 1, and the current
    one 0.8 times its closeness. What is done stays done, besides the last order of the last stage.
    While everything holds that success asks for, besides the time for
    which it has to hold, the value is at least (n + share of that time) / (n + 1). A robot that
    has lost what it should hold stands at the order by which it took it, until it holds it again.

    Example:
        >>> ladder = StageLadder(env)
        >>> observations, infos = env.reset(seed=0)
        >>> ladder.begin()  # the value after the reset
        0.03
        >>> *_, infos = env.step(actions)
        >>> ladder.advance()  # the value after a control step
        0.04

    Args:
        env: The environment, with any options; it is only read.

    Attributes:
        position: How far the episode has come; it can be saved and set again.

    Raises:
        UsageError: The task has no expert.
    """

    def __init__(self, env: TaskEnv) -> None:
        script = env.task.file.spec.expert
        if not script:
            raise UsageError(
                f"{env.task.name} has no expert, and a ladder made from its stages needs one; "
                "write progress into the description, or stages under expert:"
            )
        self._env = env
        self._robots = env.task.agents
        self._stages = ladder_stages(script, self._robots)
        awaited = [stage.until for stage in self._stages if stage.until]
        referee = env.episode.referee
        self._kept = {name: kept_time(referee, name) for name in ("success", *awaited)}
        self.position = Position(0, {}, {}, {})

    @property
    def value(self) -> float:
        """The latest value."""
        return self.position.value

    def begin(self) -> float:
        """Start an episode, after its reset; returns the value."""
        nothing = dict.fromkeys(self._robots, 0)
        self.position = self._entered(Position(0, {}, {}, nothing))
        return self.advance()

    def advance(self) -> float:
        """Read the state after a control step; returns the value."""
        episode = self._env.episode
        if episode.exploded:  # then there is no state
            return self.value
        self.position = self._counted(self.position)
        while (onward := self._onward(self.position)) is not None:
            self.position = onward
        self.position = replace(self.position, value=self._value(self.position))
        return self.value

    # --- advancing

    @property
    def _world(self) -> World:
        return self._env.episode.world

    def _holds(self, condition: str) -> bool:
        return self._env.episode.outcome.conditions[condition]

    def _onward(self, at: Position) -> Position | None:
        """The position after the next thing that is done, or None."""
        stage, last = self._stages[at.stage], at.stage == len(self._stages) - 1
        for robot, orders in stage.orders.items():
            number = at.orders[robot]
            if number < len(orders) - last and self._part(at, robot).reached:
                return self._turned(at, robot, number + 1)
        if last:
            return None
        waits = bool(stage.until) and not self._holds(stage.until)
        if not waits and all(at.orders[r] == len(o) for r, o in stage.orders.items()):
            return self._entered(replace(at, stage=at.stage + 1))
        ahead = self._ahead(at)
        return None if ahead is None else self._entered(replace(at, stage=ahead))

    def _part(self, at: Position, robot: str) -> Done:
        """How much of a robot's current order is done."""
        if self._lost(at, robot):
            return Done(0.0, reached=False)
        order = self._stages[at.stage].orders[robot][at.orders[robot]]
        return done(self._world, robot, order, at.starts[robot], self._holds)

    def _turned(self, at: Position, robot: str, number: int) -> Position:
        """The position in which a robot has done so many orders of the stage."""
        numbers, starts = {**at.orders, robot: number}, dict(at.starts)
        stage = self._stages[at.stage]
        if number < len(orders := stage.orders[robot]):
            held = stage.holds[robot][number]
            starts[robot] = start_of(self._world, robot, orders[number], held)
        return replace(at, orders=numbers, starts=starts, missed={**at.missed, robot: 0})

    def _entered(self, at: Position) -> Position:
        """The position at the beginning of its stage, or after a repetition that is over."""
        last = len(self._stages) - 1
        while over := [end for name, end in self._stages[at.stage].exits if self._holds(name)]:
            at = replace(at, stage=min(max(over), last))
            if at.stage == last:
                break
        at = replace(at, orders=dict.fromkeys(self._robots, 0), starts={})
        for robot in self._stages[at.stage].orders:
            at = self._turned(at, robot, 0)
        return at

    def _ahead(self, at: Position) -> int | None:
        """A later stage that is done already, if nothing before it left a mark.

        Robots may go another way than the expert: ways of tools may be left out before a grasp or
        the next way of an object, and so may ways of objects that are still held then.
        """
        for number in range(at.stage + 1, len(self._stages)):
            before, stage = self._stages[number - 1], self._stages[number]
            first = at.orders if number - 1 == at.stage else {}
            left = (
                (r, o) for r, orders in before.orders.items() for o in orders[first.get(r, 0) :]
            )
            if before.until or not all(_is_way(o, stage.holds[r][0]) for r, o in left):
                return None
            if self._is_grasped(number) or (number == at.stage + 1 and self._is_brought(number)):
                return number
        return None

    def _is_grasped(self, number: int) -> bool:
        """Whether robots hold what they take in a stage, and what they held before it."""
        stage = self._stages[number]
        each = [(_grasped(order), r) for r, orders in stage.orders.items() for order in orders]
        grasped = [(body, robot) for body, robot in each if body]
        return bool(grasped) and self._is_held(number, grasped)

    def _is_brought(self, number: int) -> bool:
        """Whether everything is where a stage brings it, if it does nothing else."""
        stage_orders = self._stages[number].orders
        first = {robot: orders[0] for robot, orders in stage_orders.items() if len(orders) == 1}
        brings = all(isinstance(o, Together) or o.bring for o in first.values())
        if (
            not first
            or len(first) < len(stage_orders)
            or not brings
            or not self._is_held(number, ())
        ):
            return False
        world, holds = self._world, self._stages[number].holds
        return all(
            done(world, r, o, start_of(world, r, o, holds[r][0]), self._holds).reached
            for r, o in first.items()
        )

    def _is_held(self, number: int, more: Iterable[tuple[str, str]]) -> bool:
        """Whether robots hold what they hold before a stage, and more, by object and robot."""
        holds = self._stages[number].holds.items()
        held = [(own[0].body, robot) for robot, own in holds if own[0]]
        return all(self._world.held(*pair) for pair in (*held, *more))

    # --- what is held

    def _due(self, at: Position, robot: str) -> HeldObject | None:
        """What a robot should hold now: what it held before its order, unless that lets it go."""
        stage, number = self._stages[at.stage], at.orders.get(robot, 0)
        orders = stage.orders.get(robot, ())
        holds = stage.holds[robot]
        if number < len(orders):
            return holds[number] if holds[number] == holds[number + 1] else None
        return holds[-1]

    def _counted(self, at: Position) -> Position:
        """The position with the control steps counted for which something was not held."""
        missed = {}
        for robot in self._robots:
            due = self._due(at, robot)
            kept = due is None or self._world.held(due.body, robot)
            missed[robot] = 0 if kept else at.missed[robot] + 1
        return replace(at, missed=missed)

    def _lost(self, at: Position, robot: str) -> bool:
        return at.missed[robot] > BUMPS

    # --- the value

    def _value(self, at: Position) -> float:
        outcome, whole = self._env.episode.outcome, len(self._stages)
        if outcome.success:
            return 1.0
        value = sum(self._stands(at)) / len(self._robots)
        share = self._kept["success"].share(self._env.episode.referee, self._world.time)
        return max(value, 0.0 if share is None else whole + share) / (whole + 1)

    def _stands(self, at: Position) -> Iterator[float]:
        """Where each robot stands in the script, in stages."""
        shares = self._shares(at)
        mean = sum(shares.values()) / len(shares) if shares else self._waited(at)
        for robot in self._robots:
            due = self._due(at, robot)
            if due is not None and self._lost(at, robot):
                tool = self._world.pose(f"{robot}.tcp")
                gap = math.dist(tool.position, self._world.position(due.place))
                yield due.grasped_at + UNFINISHED * due.share * closeness(gap)
            else:
                yield at.stage + shares.get(robot, mean)

    def _waited(self, at: Position) -> float:
        """The share of a stage that waits for a condition."""
        until = self._stages[at.stage].until
        if not until:
            return 0.0
        share = self._kept[until].share(self._env.episode.referee, self._world.time)
        return UNFINISHED * (share or 0.0)

    def _shares(self, at: Position) -> dict[str, float]:
        """The share of the current stage that each robot has done which acts in it."""
        shares = {}
        for robot, orders in self._stages[at.stage].orders.items():
            number, share = at.orders[robot], 0.0
            if number < len(orders):
                part = self._part(at, robot)
                share = 1.0 if part.reached else UNFINISHED * part.closeness
            shares[robot] = (number + share) / len(orders)
        return shares


def stage_ladder_along(env: TaskEnv, episode: Rollout) -> NDArray[np.float64]:
    """The ladder of the expert's stages along an episode, which is played again: (steps + 1,).

    Args:
        env: An environment of the episode's task and variation, with the same options.
        episode: The episode.
    """
    ladder, values = StageLadder(env), list[float]()

    def watch(env: TaskEnv) -> None:
        values.append(ladder.advance() if env.episode.steps else ladder.begin())

    replay(env, episode, watch)
    return np.array(values)


def _is_way(order: LadderOrder, held: HeldObject | None) -> bool:
    """Whether an order only takes a tool somewhere, or an object that is still held."""
    if isinstance(order, Together) or order.bring is not None:
        return held is not None
    return order.verb in ("reach", "retreat", "home", "posture")


def _grasped(order: LadderOrder) -> str:
    """The object that an order takes hold of, or ""."""
    if isinstance(order, Together):
        return ""
    if order.grasp is not None:
        return order.grasp.partition(".")[0]
    return "" if order.close in (None, NOTHING) else str(order.close)
