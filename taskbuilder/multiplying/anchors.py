"""Where a demonstration is cut: the times at which a tool moves relative to an object or a site.

At an anchor, a tool moves as it did in the demonstration, seen from a frame: from the object that
it is about to take, or from the place that it brings an object to. Between two anchors, it goes
over from one to the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from taskbuilder.geometry import Pose, norm, subtract
from taskbuilder.multiplying.demonstration import Milestone, ReplayedDemonstration

WORLD = ""
"""The frame of anchors at which a tool is where it was in the demonstration."""

NEAR_M = 0.1
"""An anchor begins and ends where the tool is as near as this to where it is at its time."""

TOUCH_M = 0.15
"""A tool without a load concerns a thing that is as near as this when a stage is reached."""

SHORTEST_HOLD = 3
"""Control steps; what is held for less was only touched."""


MOVED_M = 0.01
"""An object that is as near as this to where it was has not moved."""

TOGETHER = 5
"""Control steps; robots that let go of an object within this time let go of it together."""


@dataclass(frozen=True)
class Anchor:
    """A time at which a tool moves relative to a frame.

    Attributes:
        begin: Control steps before it.
        end: Control steps before its end.
        frame: The object or site, or `WORLD`.
        fixed: Control step from which on the frame counts as it is then, because the tool may move
            it; None for never.
    """

    begin: int
    end: int
    frame: str
    fixed: int | None = None


@dataclass(frozen=True)
class Hold:
    """A time in which a robot holds an object.

    Attributes:
        robot: The robot.
        load: The object.
        begin: Control steps before it.
        end: Control steps before it is let go of, or the length of the demonstration.
    """

    robot: str
    load: str
    begin: int
    end: int


def holds_of(demonstration: ReplayedDemonstration, robot: str) -> list[Hold]:
    """The times in which a robot holds an object; short interruptions do not count."""
    holds: list[Hold] = []
    for step, load in enumerate(demonstration.held[robot]):
        if not load:
            continue
        last = holds[-1] if holds else None
        if last and last.load == load and step - last.end <= SHORTEST_HOLD:
            holds[-1] = Hold(robot, load, last.begin, step)
        else:
            holds.append(Hold(robot, load, step, step))
    return [hold for hold in holds if hold.end - hold.begin >= SHORTEST_HOLD]


def anchors_of(demonstration: ReplayedDemonstration, robot: str) -> tuple[Anchor, ...]:
    """The anchors of a robot's tool, in order, from the first control step on."""
    holds = [hold for each in demonstration.robots for hold in holds_of(demonstration, each)]
    made = [Anchor(0, 0, WORLD)]
    for hold in holds:
        if hold.robot == robot:
            made.append(_grasp(demonstration, hold, holds))
            made += _passed_on(demonstration, hold, holds)
    for milestone in demonstration.milestones:
        made += _reached(demonstration, robot, milestone, holds)
    for hold in holds:
        if hold.robot == robot and not any(a.begin <= hold.end <= a.end for a in made):
            made.append(_put_down(demonstration, hold, hold.end, WORLD))
    return tuple(_in_order(made))


def _grasp(demonstration: ReplayedDemonstration, hold: Hold, holds: Sequence[Hold]) -> Anchor:
    """The anchor at which an object is taken; it lasts until all have it that lift it together."""
    begin, _ = _around(demonstration.tools[hold.robot], hold.begin)
    carried = any(
        other.load == hold.load and other.begin <= begin <= other.end
        for other in holds
        if other.robot != hold.robot
    )
    # What another robot holds may still move; what lies there is left alone until it is touched.
    fixed = max(begin, hold.begin - SHORTEST_HOLD) if carried else begin
    last = max(other.begin for other in holds if _lift_together(demonstration, hold, other))
    return Anchor(begin, last + 1, hold.load, fixed)


def _lift_together(demonstration: ReplayedDemonstration, hold: Hold, other: Hold) -> bool:
    """Whether two robots take an object one after the other before it moves."""
    if hold.load != other.load or hold.begin > other.end or other.begin > hold.end:
        return False
    poses = demonstration.frames[hold.load]
    return _rests(poses, hold.begin, other.begin)


def _passed_on(
    demonstration: ReplayedDemonstration, hold: Hold, holds: Sequence[Hold]
) -> Iterator[Anchor]:
    """The times at which another robot takes what one holds: both are where they were."""
    for other in holds:
        if other.load != hold.load or other.robot == hold.robot:
            continue
        if _lift_together(demonstration, hold, other):
            continue
        if hold.begin < other.begin <= hold.end:
            begin, _ = _around(demonstration.tools[other.robot], other.begin)
            _, end = _around(demonstration.tools[hold.robot], hold.end)
            yield Anchor(max(begin, hold.begin + 1), end, WORLD)


def _reached(
    demonstration: ReplayedDemonstration, robot: str, milestone: Milestone, holds: Sequence[Hold]
) -> Iterator[Anchor]:
    """The anchor of a robot at a stage: where it brings its load, or what it touches."""
    step = min(milestone.step, demonstration.steps)
    brought = _brought(milestone, step, holds)
    own = max((h for h in brought if h.robot == robot), key=lambda h: h.end, default=None)
    if brought and own is None:
        return
    at = step if own is None else min(step, own.end)
    since = at if own is None else own.begin
    held = {hold.load for hold in holds if hold.begin <= at <= hold.end}
    frames = demonstration.frames

    def distance(name: str) -> float:
        tool = demonstration.tools[robot][at]
        return norm(subtract(frames[name][at].position, tool.position))

    # What moves along with a load is not where the load is brought.
    still = [name for name in milestone.frames if _rests(frames[name], since, at)]
    places = [name for name in still if name not in held and (own is None or name != own.load)]
    nearest = min(places, key=distance, default=None)
    if nearest is None or (own is None and distance(nearest) > TOUCH_M):
        return
    if own is None:
        begin, end = _around(demonstration.tools[robot], at)
        yield Anchor(begin, end, nearest, begin)
    else:
        yield _put_down(demonstration, own, at, nearest)


def _put_down(demonstration: ReplayedDemonstration, hold: Hold, at: int, place: str) -> Anchor:
    """The anchor at which an object comes to a place."""
    begin, _ = _around(demonstration.frames[hold.load], at)
    _, end = _around(demonstration.tools[hold.robot], at)
    return Anchor(max(begin, hold.begin + 1), end, place)


def _rests(poses: Sequence[Pose], begin: int, end: int) -> bool:
    return norm(subtract(poses[begin].position, poses[end].position)) <= MOVED_M


def _brought(milestone: Milestone, step: int, holds: Sequence[Hold]) -> list[Hold]:
    """The last hold of each thing of a stage; of all robots that let go of it together."""
    before = [hold for hold in holds if hold.load in milestone.frames and hold.begin <= step]
    last = {hold.load: hold.end for hold in sorted(before, key=lambda hold: hold.end)}
    return [hold for hold in before if last[hold.load] - hold.end <= TOGETHER]


def _around(poses: Sequence[Pose], step: int) -> tuple[int, int]:
    """The control steps around one at which a tool or object is near where it is then."""

    def is_near(other: int) -> bool:
        return norm(subtract(poses[other].position, poses[step].position)) <= NEAR_M

    begin = end = step
    while begin > 0 and is_near(begin - 1):
        begin -= 1
    while end < len(poses) - 1 and is_near(end + 1):
        end += 1
    return begin, end


def _in_order(anchors: list[Anchor]) -> Iterator[Anchor]:
    """Anchors by their ends; each begins after the one before has ended."""
    first, *rest = sorted(anchors, key=lambda anchor: (anchor.end, anchor.begin))
    yield first
    for before, anchor in pairwise((first, *rest)):
        begin = max(anchor.begin, before.end)
        yield Anchor(begin, max(anchor.end, begin), anchor.frame, anchor.fixed)
