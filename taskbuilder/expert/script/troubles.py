"""Why a stage could not be done, with what was measured."""

from __future__ import annotations

import math
from collections.abc import Collection

from taskbuilder.description.figures import listed
from taskbuilder.errors import TaskbuilderError
from taskbuilder.expert.script.joints import Joint
from taskbuilder.expert.script.situation import Go, Grip
from taskbuilder.geometry import Vec3
from taskbuilder.sim.body import Body
from taskbuilder.sim.contacts import pressing_links
from taskbuilder.world.world import World


class StageError(TaskbuilderError):
    """A stage cannot be done.

    Attributes:
        order: The order.
        robot: The robot that could not do it, or "".
        cause: One of `rollout.record.CAUSES`.
    """

    def __init__(self, order: str, robot: str, cause: str, message: str) -> None:
        super().__init__(message)
        self.order, self.robot, self.cause = order, robot, cause


def lost_on_the_way(world: World, robot: str, load: str, go: Go | None) -> str:
    """A robot no longer holds its load: an object, or a link such as ``chest.lid``.

    Args:
        world: The world.
        robot: The robot.
        load: The object or link.
        go: The motion during which the robot was to hold the link; None for an object.
    """
    frame = load if go is None else _grasp_frame(world, robot, go)
    at = f"at {_place(world.position(frame))}"
    if frame == f"{robot}.tcp":
        frame, at = load, f"its tool {at}"
    text = f"{robot} has lost {frame} on the way, {at}"
    if go is not None and go.joint is not None:
        position, target = _positions(world, *go.joint)
        text += f", with {go.joint[0]} at {position} of {target}"
    felt = _felt(world, robot, load)
    return text + (f"; {felt}" if felt else "") + locks(world, {load.partition(".")[0]})


def _grasp_frame(world: World, robot: str, go: Go) -> str:
    """Where a robot held what a joint moves: the nearest grasp point on it, or the tool.

    The frame of a link is at its joint, which may be far from its handle.
    """
    owner, tcp = go.holds.partition(".")[0], f"{robot}.tcp"
    moving = Joint(world, go.joint[0]).below if go.joint else ()
    grasps = world.objects[owner].spec.grasps.items()
    frames = [f"{owner}.{name}" for name, grasp in grasps if f"{owner}.{grasp.link}" in moving]
    tool = world.position(tcp)
    return min(frames, key=lambda frame: math.dist(world.position(frame), tool), default=tcp)


def _positions(world: World, name: str, target: float) -> tuple[str, str]:
    """The position of a joint, and the one that it was to be moved to."""
    slides = Joint(world, name).slides
    values = [100 * v if slides else math.degrees(v) for v in (world.joint(name), target)]
    digits, unit = (1, " cm") if slides else (0, "°")
    # Adding zero makes a negative zero positive.
    now, goal = (f"{round(value, digits) + 0.0:.{digits}f}{unit}" for value in values)
    return now, goal


def not_arrived(world: World, robot: str, go: Go, gap: float) -> str:
    """A motion has ended too far from its goal; the gap is in metres."""
    subject = go.subject or f"{robot}.tcp"
    if go.joint is not None:
        position, target = _positions(world, *go.joint)
        text = f"{subject} ended up at {position}; its goal is {target}"
    elif math.isfinite(gap):
        text = f"{subject} ended up {gap * 100:.1f} cm from its goal"
    else:
        text = f"{subject} was lost before its goal"
    touches = touched(world, robot)
    if touches:
        text += f"; {robot} touches {', '.join(touches.values())}"
    return text + locks(world, touches)


def grip_missed(world: World, grip: Grip) -> str:
    """A gripper does not hold its object, or does not let go of it."""
    state = world.robots[grip.robot].gripper.words()
    names = ", ".join(touched(world, grip.robot).values())
    state += f" and touches {names}" if names else ""
    if grip.releases:
        return f"{grip.robot} does not let go of {grip.load or 'what it touches'}: {state}"
    felt = _felt(world, grip.robot, grip.load) if grip.load else ""
    return f"{grip.robot} does not hold {grip.load or 'anything'}: {felt or state}"


def _felt(world: World, robot: str, load: str) -> str:
    """With what force each finger presses against a load; "" if none does."""
    forces = world.grip_forces(load, robot)
    return f"it presses with {', '.join(f'{f:.1f}' for f in forces)} N" if any(forces) else ""


def touched(world: World, robot: str) -> dict[str, str]:
    """What a robot touches where, and with which of its links: ``table.top with wrist_3_link``.

    The keys are the names of the objects and of other robots.
    """
    own = world.robots[robot].body
    others: dict[str, Body] = {name: obj.body for name, obj in world.objects.items()}
    others |= {name: other.body for name, other in world.robots.items()}
    touches = {}
    for name in (n for n in others if n != robot and world.touching(robot, n)):
        other = others[name]
        pairs = [(other.called(part), link) for link, part in pressing_links(own, other)]
        first = pairs[0][0]  # where it presses most
        touches[name] = (
            f"{first} with {listed(sorted(link for part, link in pairs if part == first))}"
        )
    return touches


def locks(world: World, objects: Collection[str]) -> str:
    """What is locked of some objects, as the end of a sentence; "" if nothing is."""
    shut = [
        f'{joint} is locked unless "{condition}" holds'
        for joint, condition in world.locked.items()
        if joint.partition(".")[0] in objects
    ]
    return "".join(f"; {each}" for each in shut)


def _place(position: Vec3) -> str:
    return f"({', '.join(f'{value:.2f}' for value in position)})"
