"""An expert's script as a flat list of stages, and what each robot holds at every order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from taskbuilder.schema.expert import ExpertStage, Repeat, Together, Wait, listed
from taskbuilder.schema.order import NOTHING, Order

LadderOrder = Order | Together
"""What one robot does; robots that bring a load together have the same."""


@dataclass(frozen=True)
class HeldObject:
    """An object that a robot holds.

    Attributes:
        body: The object.
        place: Frame that the robot took it at.
        grasped_at: Position in the script at which it was taken: its stage, and the share of the
            robot's orders in that stage that came before.
        share: Share that taking it has in the robot's orders of that stage.
    """

    body: str
    place: str
    grasped_at: float
    share: float


@dataclass(frozen=True)
class LadderStage:
    """A stage of the expert.

    Attributes:
        orders: The orders of each robot that acts in it, in sequence.
        until: The condition that is waited for, or "".
        holds: What each robot holds before each of its orders and after the last one; a single
            value for a robot without orders.
        exits: Conditions that end a repetition where this stage begins a round of it, each with
            the number of the stage that comes after the repetition.
    """

    orders: Mapping[str, tuple[LadderOrder, ...]] = field(default_factory=dict)
    until: str = ""
    holds: Mapping[str, tuple[HeldObject | None, ...]] = field(default_factory=dict)
    exits: tuple[tuple[str, int], ...] = ()


def ladder_stages(script: Sequence[ExpertStage], robots: Sequence[str]) -> tuple[LadderStage, ...]:
    """The stages of a script, repetitions written out.

    Args:
        script: The expert's stages, as in a task file.
        robots: Names of all robots.
    """
    held: dict[str, HeldObject | None] = dict.fromkeys(robots)
    stages: list[LadderStage] = []
    for number, (stage, exits) in enumerate(_flat(script, 0)):
        orders = _orders(stage)
        holds = {r: tuple(_held(r, orders.get(r, ()), held, number)) for r in robots}
        until = stage.until if isinstance(stage, Wait) else ""
        stages.append(LadderStage(orders, until, holds, exits))
    return tuple(stages)


_Exits = tuple[tuple[str, int], ...]


def _flat(script: Sequence[ExpertStage], first: int) -> Iterator[tuple[ExpertStage, _Exits]]:
    """Every stage that is no repetition, with its exits; the first of them has a given number."""
    number = first
    for stage in script:
        if not isinstance(stage, Repeat):
            yield stage, ()
            number += 1
            continue
        round_ = len(list(_flat(stage.stages, 0)))
        end = number + stage.repeat * round_
        for _ in range(stage.repeat):
            for index, (inner, exits) in enumerate(_flat(stage.stages, number)):
                own = ((stage.unless, end),) if stage.unless and not index else ()
                yield inner, (*own, *exits)
            number += round_


def _orders(stage: ExpertStage) -> dict[str, tuple[LadderOrder, ...]]:
    if isinstance(stage, Together):
        return dict.fromkeys(stage.together, (stage,))
    if isinstance(stage, Wait | Repeat):
        return {}
    return {robot: listed(orders) for robot, orders in stage.items()}


def _held(
    robot: str, orders: Sequence[LadderOrder], held: dict[str, HeldObject | None], number: int
) -> Iterator[HeldObject | None]:
    """What a robot holds before each order and after the last; ``held`` is brought up to date."""
    yield held[robot]
    for index, order in enumerate(orders):
        held[robot] = _after(order, held[robot], number + index / len(orders), 1 / len(orders))
        yield held[robot]


def _after(
    order: LadderOrder, before: HeldObject | None, at: float, share: float
) -> HeldObject | None:
    """What a robot holds after an order at a position in the script."""
    if isinstance(order, Together):
        return before
    if order.grasp is not None:
        return HeldObject(order.grasp.partition(".")[0], order.grasp, at, share)
    if order.close is not None:
        return None if order.close == NOTHING else HeldObject(order.close, order.close, at, share)
    return None if order.release else before
