"""Several arms of one body: each becomes a robot, and together they form the body.

The first arm keeps the body. The others stand at the same base without it, because what is in both
would be in each other. A joint that moves several arms is fixed: robots share no joint.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from taskbuilder.assets import codes
from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import ImportedBody
from taskbuilder.importing.folders import (
    Imported,
    ImportSource,
    ReadRobot,
    TryGripper,
    finished,
    read_robot,
)
from taskbuilder.importing.limits import held_as_unused
from taskbuilder.kinematics.chain import Chain
from taskbuilder.world.arm_branches import arms_of_body, links_below
from taskbuilder.world.arm_figure import ArmFigure, bodies_of
from taskbuilder.world.robot_proposal import Proposal, propose

_LONGEST_NAME = 40
_WORDS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+")
_SIDES = {"l": "left", "r": "right"}


@dataclass(frozen=True)
class ImportedArms:
    """The arms of one body.

    Attributes:
        robots: Name that an agent may have -> the robot; the first has the body.
        height: Of the frame of their bases above what the body stands on, in metres.
    """

    robots: Mapping[str, Imported]
    height: float


@dataclass(frozen=True)
class _ArmOfBody:
    """An arm of a body.

    Attributes:
        agent: What an agent may be called.
        robot: The name of its robot.
        joint: The joint of the tree that it begins with, perhaps a fixed one.
        links: The links that its joints move. What carries them belongs to the body.
        mounts: The links that carry them.
    """

    agent: str
    robot: str
    joint: UrdfJoint
    links: frozenset[str]
    mounts: frozenset[str]


def import_arms(source: ImportSource, try_gripper: TryGripper | None = None) -> ImportedArms:
    """Read a body with several arms, and make the files of a folder of each arm.

    Args:
        source: What is imported; its name is what the names of the robots begin with.
        try_gripper: Tries the grippers that are proposed; see `import_robot`.

    Raises:
        FileError: There are no several arms, or something else is wrong.
        UsageError: Options are wrong, or the extra is not installed.
    """
    read = read_robot(source)
    with read.urdf() as urdf:
        arms = _arms(urdf)
    if not arms:
        message = (
            "no link has several long branches beyond it, so there are no several arms; import it "
            "without --all-arms"
        )
        raise FileError([Finding(codes.NOT_IMPORTED, message, "", Location(read.description.file))])
    read = replace(read, description=_unshared(read.description, arms, read.changes))
    robots: dict[str, Imported] = {}
    height = 0.0
    for arm in arms:
        alone = _alone(read, arm, arms)
        with alone.urdf() as urdf:
            proposal = propose(
                urdf, home=read.description.postures.get("home"), suction=read.suction
            )
        if proposal is None:
            message = f"from {arm.joint.child} on, no arm was found"
            raise FileError([Finding(codes.NOT_IMPORTED, message, "", Location(source.file))])
        figure = _figure(urdf, proposal)
        home = None
        if arm is arms[0]:
            height = -figure.floor
            alone = _with_fine_body(alone, arm)
        else:
            home = dict(zip((joint.name for joint in proposal.arm), proposal.home, strict=True))
            alone = _bodiless(alone, arm, arms[0], _always_inside(urdf, proposal, figure))
        robots[arm.agent] = finished(alone, source, try_gripper, home, _said(arm, arms))
    return ImportedArms(robots, round(height, 3) + 0.0)


def _arms(urdf: Urdf) -> tuple[_ArmOfBody, ...]:
    joints = arms_of_body(urdf)
    agents = _agents([joint.child for joint in joints])
    arms = []
    for agent, joint in zip(agents, joints, strict=True):
        robot = f"{urdf.name[: _LONGEST_NAME - len(agent) - 1]}_{agent}"
        first = list(_first_that_move(urdf, joint))
        links = frozenset(link for one in first for link in links_below(urdf, one))
        arms.append(_ArmOfBody(agent, robot, joint, links, frozenset(one.parent for one in first)))
    return tuple(arms)


def _first_that_move(urdf: Urdf, joint: UrdfJoint) -> Iterator[UrdfJoint]:
    if joint.moves:
        yield joint
        return
    for other in urdf.joints:
        if other.parent == joint.child:
            yield from _first_that_move(urdf, other)


def _agents(links: Sequence[str]) -> list[str]:
    """What agents may be called: the words in which the names of their links differ."""
    words = [[word.lower() for word in _WORDS.findall(link)] for link in links]
    shared = set.intersection(*map(set, words)) if words else set()
    agents = []
    for own in words:
        text = "_".join(_SIDES.get(word, word) for word in own if word not in shared)
        agents.append(text if text[:1].isalpha() else f"arm_{text}")
    if len(set(agents)) < len(agents) or any(len(name) > 20 for name in agents):
        return [f"arm_{number}" for number in range(1, len(links) + 1)]
    return agents


def _unshared(
    description: ImportedBody, arms: Sequence[_ArmOfBody], changes: Changes
) -> ImportedBody:
    """The description with the joints fixed that would move several arms."""
    above, link = set(), arms[0].joint.parent
    while (joint := description.joint_above(link)) is not None:
        above.add(joint.name)
        link = joint.parent
    reason = "it moves several arms, and robots share no joint"
    return held_as_unused(description, above, changes, reason)


def _alone(read: ReadRobot, arm: _ArmOfBody, arms: Sequence[_ArmOfBody]) -> ReadRobot:
    """The body with one arm, under the name of its robot."""
    changes = read.changes.copy()
    description = read.description
    for other in arms:
        if other is not arm:
            description = _without(description, other.links, changes)
            changes.note(
                f"arm {other.agent}", "left out", f"{len(other.links)} links", "–",
                f"it is the robot {other.robot}",
            )  # fmt: skip
    geometry = replace(read.geometry, changes=changes)
    description = replace(description, name=arm.robot)
    return replace(read, description=description, geometry=geometry, changes=changes)


def _without(description: ImportedBody, links: Collection[str], changes: Changes) -> ImportedBody:
    """The description without some links and their joints, and without the rows about them."""
    joints = [joint.name for joint in description.joints if joint.child in links]
    changes.drop([*(f"link {link}" for link in links), *(f"joint {joint}" for joint in joints)])
    return replace(
        description,
        links=tuple(link for link in description.links if link.name not in links),
        joints=tuple(joint for joint in description.joints if joint.child not in links),
    )


def _figure(urdf: Urdf, proposal: Proposal) -> ArmFigure:
    chain = Chain.of(urdf, [joint.name for joint in proposal.arm], proposal.tcp_link, proposal.tcp)
    opened = {name: ends[0] for name, ends in proposal.gripper.items()}
    return ArmFigure(chain, tuple(bodies_of(urdf, proposal.arm, opened)), 0)


def _always_inside(urdf: Urdf, proposal: Proposal, figure: ArmFigure) -> frozenset[str]:
    """The links of an arm that cannot but be in the body."""
    names = [joint.name for joint in proposal.arm]
    inside = {names[index] for index in figure.in_base()}
    found = set()
    for link in urdf.links:
        above = [j.name for j in urdf.moving_joints_above(link.name) if j.name in names]
        if above and max(above, key=names.index) in inside:
            found.add(link.name)
    return frozenset(found)


def _bodiless(
    alone: ReadRobot, arm: _ArmOfBody, first: _ArmOfBody, inside: frozenset[str]
) -> ReadRobot:
    """An arm without the body that the robot of another arm has."""
    description, changes = alone.description, alone.changes
    path: set[str] = set().union(*(_path(description, link) for link in arm.mounts))
    body = [link for link in description.links if link.name not in arm.links]
    seen = sum(bool(link.visuals or link.collisions) for link in body)
    rest = {link.name for link in body} - path
    description = _without(description, rest, changes)
    changes.drop([f"link {link}" for link in path])
    changes.note(
        "body", "left out", f"{seen} links with shapes", "–",
        f"the robot {first.robot} has it, at the same base",
    )  # fmt: skip
    links = []
    for link in description.links:
        if link.name in path:
            link = replace(link, inertial=None, visuals=(), collisions=())
        elif link.name in inside and link.collisions:
            count = len(link.collisions)
            changes.note(
                f"link {link.name}", "collision", f"{count} shape{'s' * (count > 1)}", "none",
                f"it is always in the body, which is another robot here, {first.robot}",
            )  # fmt: skip
            link = replace(link, collisions=())
        links.append(link)
    return replace(alone, description=replace(description, links=tuple(links)))


def _with_fine_body(alone: ReadRobot, arm: _ArmOfBody) -> ReadRobot:
    """The body with collision shapes that are as exact as those of objects: arms meet it now."""
    body = [link.name for link in alone.description.links if link.name not in arm.links]
    return replace(alone, description=alone.geometry.refined(alone.description, body))


def _path(description: ImportedBody, link: str) -> set[str]:
    """A link and those between it and the root, with the root."""
    found = {link}
    while (joint := description.joint_above(link)) is not None:
        link = joint.parent
        found.add(link)
    return found


def _said(arm: _ArmOfBody, arms: Sequence[_ArmOfBody]) -> tuple[str, ...]:
    others = ", ".join(other.robot for other in arms if other is not arm)
    return (f"an arm of a body; {others} belongs to it, and has the same base in a task",)
