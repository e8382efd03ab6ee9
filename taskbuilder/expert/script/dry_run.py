"""A dry run of an expert's stages without physics, which lists every required pose.

Grasped objects are assumed to follow the tool exactly, and brought objects to arrive. Pushed
objects and joints move as `foresight` predicts. So an unreachable pose is known before anything
moves, and separately from other failures.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

from taskbuilder.expert.script.foresight import Foresight
from taskbuilder.expert.script.orders import bring, phases
from taskbuilder.expert.script.situation import Go, NotHeldError, Phase
from taskbuilder.geometry import Pose
from taskbuilder.schema.expert import ExpertStage, Repeat, Together, Wait, listed
from taskbuilder.schema.order import Order
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.world.world import World


@dataclass(frozen=True)
class Asked:
    """A pose that a stage requires of a robot.

    Attributes:
        stage: Number of the stage, from 1.
        robot: The robot.
        order: The order, such as ``grasp stick.right_end``.
        choices: World poses of its tcp, one of which it must reach.
        guess: The object or robot that the poses depend on and that is predicted only roughly, for
            example after a push; "" if all is known.
    """

    stage: int
    robot: str
    order: str
    choices: tuple[Pose, ...]
    guess: str = ""


def dry_run(world: World, stages: Sequence[ExpertStage] | None = None) -> Iterator[Asked]:
    """All poses that an expert's stages require, from the current state of a world.

    Args:
        world: The world after a reset; it is not changed.
        stages: The stages; by default those of the task file.
    """
    run = _DryRun(Foresight(world, _Standing(world)))
    for number, stage in enumerate(world.spec.expert if stages is None else stages, start=1):
        yield from run.go_through(number, stage)


@dataclass(frozen=True)
class _Standing:
    """A world in which nobody holds anything. It is an `orders.Situation`."""

    world: World

    @property
    def scene(self) -> SceneSpec:
        """The scene that was built."""
        return self.world.scene

    def pose(self, frame: str) -> Pose:
        """A named frame in the world."""
        return self.world.pose(frame)

    def tool(self, robot: str) -> Pose:
        """A robot's tcp in the world."""
        return self.world.pose(f"{robot}.tcp")

    def handle(self, robot: str) -> str | None:  # noqa: ARG002  # part of the `Situation` protocol
        """Nothing."""
        return None

    def joint(self, name: str) -> float:
        """Position of a joint, in rad or m."""
        return self.world.joint(name)

    def load(self, robot: str) -> str | None:  # noqa: ARG002  # part of the `Situation` protocol
        """Nothing."""
        return None

    def is_open(self, robot: str) -> bool:  # noqa: ARG002  # part of the `Situation` protocol
        """All grippers are."""
        return True


@dataclass
class _DryRun:
    """A dry run through stages, one by one."""

    foresight: Foresight

    def go_through(self, number: int, stage: ExpertStage) -> Iterator[Asked]:
        """The poses of a stage; afterwards objects are where the stage leaves them."""
        if isinstance(stage, Wait):
            return
        if isinstance(stage, Repeat):
            before = dict(self.foresight.moved)
            for inner in stage.stages:
                yield from self.go_through(number, inner)
            if stage.repeat > 1:  # the number of rounds is not known
                now = self.foresight.moved
                changed = {self.foresight.owner(n) for n in now if before.get(n) != now[n]}
                self.foresight.guesses |= changed
        elif isinstance(stage, Together):
            robots = stage.together
            group: Mapping[str, Phase] = {"": lambda now: bring(now, robots, stage)}
            yield from self._act(number, group, {"": stage})
        else:
            queues = {
                robot: [(phase, order) for order in listed(own) for phase in phases(robot, order)]
                for robot, own in stage.items()
            }
            for acts in zip_longest(*queues.values(), fillvalue=None):
                steps = {robot: act for robot, act in zip(queues, acts, strict=True) if act}
                # An object that one robot brings is at its goal for the others of the stage.
                first = sorted(steps, key=lambda robot: steps[robot][1].bring is None)
                yield from self._act(
                    number,
                    {robot: steps[robot][0] for robot in first},
                    {robot: steps[robot][1] for robot in first},
                )

    def _act(
        self,
        number: int,
        group: Mapping[str, Phase],
        orders: Mapping[str, Order | Together],
    ) -> Iterator[Asked]:
        for who, phase in group.items():
            try:
                act = phase(self.foresight.now)
            except NotHeldError:
                continue  # the grasp was required, and is reported, before
            if isinstance(act, Go):
                move = act.choices[0]
                guess = self._guess(orders[who], tuple(move.carriers))
                for robot in move.carriers:
                    poses = tuple(move.goal @ move.carriers[robot] for move in act.choices)
                    yield Asked(number, robot, str(orders[who]), poses, guess)
                self.foresight.go(act, guess=bool(guess))
            elif act is not None:
                self.foresight.grip(act)

    def _guess(self, order: Order | Together, robots: Sequence[str]) -> str:
        """The roughly predicted object or robot that an order depends on, or ""."""
        frames: list[Any] = [order.bring, order.to]
        if isinstance(order, Order):
            frames += [order.grasp, order.reach, order.push, order.press, order.joint]
        if isinstance(order, Order) and (order.home or order.posture):
            return ""
        # An order that names no frame moves the tool relative to where it is.
        named = [frame for frame in frames if isinstance(frame, str)] or robots
        owners = [self.foresight.owner(frame) for frame in named]
        return next((owner for owner in owners if owner in self.foresight.guesses), "")
