"""Go through an expert's stages in thought: every pose that they ask for, without physics.

What is grasped is taken to follow the tool exactly, and what is brought to arrive. So a pose that
cannot be reached is known before anything moves, and apart from all else that may go wrong.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest

from taskbuilder.expert.orders import Foreseen, Go, NothingHeldError, Phase, bring, phases
from taskbuilder.expert.planning import Move
from taskbuilder.geometry import Pose
from taskbuilder.spec.expert import ExpertStage, Order, Repeat, Together, Wait
from taskbuilder.spec.scene import SceneSpec
from taskbuilder.world.world import World


@dataclass(frozen=True)
class Asked:
    """A pose that a stage asks of a robot.

    Attributes:
        stage: Number of the stage, from 1.
        robot: Whose tool.
        order: What for, as ``grasp stick.right_end``.
        choices: Poses of its tcp in the world, one of which it must reach.
    """

    stage: int
    robot: str
    order: str
    choices: tuple[Pose, ...]


def rehearse(world: World, stages: Sequence[ExpertStage] | None = None) -> Iterator[Asked]:
    """Every pose that an expert's stages ask for, from where things are in a world now.

    Args:
        world: As after a reset; it is only read.
        stages: By default those of the task file.
    """
    rehearsal = _Rehearsal(_Standing(world))
    for number, stage in enumerate(world.spec.expert if stages is None else stages, start=1):
        yield from rehearsal.go_through(number, stage)


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

    def load(self, robot: str) -> str | None:  # noqa: ARG002  # what every situation takes
        """Nothing."""
        return None

    def is_open(self, robot: str) -> bool:  # noqa: ARG002  # what every situation takes
        """All grippers are."""
        return True


@dataclass
class _Rehearsal:
    """Where things would be by now."""

    start: _Standing
    moved: dict[str, Pose] = field(default_factory=dict)
    tools: dict[str, Pose] = field(default_factory=dict)
    loads: dict[str, str | None] = field(default_factory=dict)

    @property
    def now(self) -> Foreseen:
        """The situation as it would be."""
        return Foreseen(self.start, self.moved, self.tools, self.loads)

    def go_through(self, number: int, stage: ExpertStage) -> Iterator[Asked]:
        """A stage's poses; afterwards things are where it leaves them."""
        if isinstance(stage, Wait):
            return
        if isinstance(stage, Repeat):
            for inner in stage.stages:
                yield from self.go_through(number, inner)
        elif isinstance(stage, Together):
            robots = stage.together
            group: Mapping[str, Phase | None] = {"": lambda now: bring(now, robots, stage)}
            yield from self._act(number, group, {"": stage})
        else:
            # What one robot brings, others of its stage find where it is brought.
            first = sorted(stage.items(), key=lambda item: item[1].bring is None)
            listed = [phases(robot, order) for robot, order in first]
            for acts in zip_longest(*listed):
                yield from self._act(number, dict(zip(dict(first), acts, strict=True)), stage)

    def _act(
        self,
        number: int,
        group: Mapping[str, Phase | None],
        orders: Mapping[str, Order | Together],
    ) -> Iterator[Asked]:
        for who, phase in group.items():
            try:
                act = phase(self.now) if phase else None
            except NothingHeldError:
                continue  # the grasp was asked for, and is reported, before
            if isinstance(act, Go):
                for robot in act.choices[0].carriers:
                    poses = tuple(move.goal @ move.carriers[robot] for move in act.choices)
                    yield Asked(number, robot, str(orders[who]), poses)
                self._move(act.choices[0], act.brings)
            elif act is not None:
                self.loads[act.robot] = (act.thing or None) if act.opening == 0.0 else None

    def _move(self, move: Move, thing: str) -> None:
        loads = {load for robot in move.carriers if (load := self.now.load(robot))}
        (robot, offset), *_ = move.carriers.items()
        shift = move.goal @ offset @ self.now.tool(robot).inverse()
        there = {name: shift @ self.now.pose(name) for name in {*loads, thing} if name}
        self.moved.update(there)
        for robot, offset in move.carriers.items():
            self.tools[robot] = move.goal @ offset
