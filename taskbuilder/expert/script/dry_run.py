"""Go through an expert's stages in thought: every pose that they ask for, without physics.

What is grasped is taken to follow the tool exactly, and what is brought to arrive; what is pushed,
or turns on a joint, moves as `foresight` can tell. So a pose that cannot be reached is known before
anything moves, and apart from all else that may go wrong.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest

from taskbuilder.expert.script.foresight import Foresight
from taskbuilder.expert.script.orders import Go, NothingHeldError, Phase, bring, phases
from taskbuilder.geometry import Pose
from taskbuilder.schema.expert import ExpertStage, Order, Repeat, Together, Wait
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.world.world import World


@dataclass(frozen=True)
class Asked:
    """A pose that a stage asks of a robot.

    Attributes:
        stage: Number of the stage, from 1.
        robot: Whose tool.
        order: What for, as ``grasp stick.right_end``.
        choices: Poses of its tcp in the world, one of which it must reach.
        guess: The object or robot whose pose they depend on and which can be foreseen only
            roughly, as once it has been pushed; "" where all is known.
    """

    stage: int
    robot: str
    order: str
    choices: tuple[Pose, ...]
    guess: str = ""


def dry_run(world: World, stages: Sequence[ExpertStage] | None = None) -> Iterator[Asked]:
    """Every pose that an expert's stages ask for, from where things are in a world now.

    Args:
        world: As after a reset; it is only read.
        stages: By default those of the task file.
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

    def load(self, robot: str) -> str | None:  # noqa: ARG002  # what every situation takes
        """Nothing."""
        return None

    def is_open(self, robot: str) -> bool:  # noqa: ARG002  # what every situation takes
        """All grippers are."""
        return True


@dataclass
class _DryRun:
    """Goes through stages one by one."""

    foresight: Foresight

    def go_through(self, number: int, stage: ExpertStage) -> Iterator[Asked]:
        """A stage's poses; afterwards things are where it leaves them."""
        if isinstance(stage, Wait):
            return
        if isinstance(stage, Repeat):
            before = dict(self.foresight.moved)
            for inner in stage.stages:
                yield from self.go_through(number, inner)
            if stage.repeat > 1:  # how often, and so how far, is not known
                now = self.foresight.moved
                changed = {self.foresight.owner(n) for n in now if before.get(n) != now[n]}
                self.foresight.guesses |= changed
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
                act = phase(self.foresight.now) if phase else None
            except NothingHeldError:
                continue  # the grasp was asked for, and is reported, before
            if isinstance(act, Go):
                move = act.choices[0]
                guess = self._guess(orders[who], tuple(move.carriers))
                for robot in move.carriers:
                    poses = tuple(way.goal @ way.carriers[robot] for way in act.choices)
                    yield Asked(number, robot, str(orders[who]), poses, guess)
                self.foresight.go(act, guess=bool(guess))
            elif act is not None:
                self.foresight.grip(act)

    def _guess(self, order: Order | Together, robots: Sequence[str]) -> str:
        """What an order depends on that is only roughly foreseen; "" if there is nothing."""
        frames = [order.bring, order.to]
        if isinstance(order, Order):
            frames += [order.grasp, order.reach]
            frames += robots if order.retreat is not None else []
        owners = [self.foresight.owner(frame) for frame in frames if frame]
        return next((owner for owner in owners if owner in self.foresight.guesses), "")
