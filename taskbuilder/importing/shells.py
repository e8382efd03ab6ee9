"""Links that are only there for other programs: shells around a robot against which it is kept."""

from __future__ import annotations

from dataclasses import replace

from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import ImportedBody


def without_shells(description: ImportedBody, changes: Changes) -> ImportedBody:
    """The description without coarse shells around links that have collision shapes of their own.

    Such a link is fixed to another, is not seen, and weighs nothing. Its shapes are wider than the
    robot, for planners to keep a distance.
    """
    joints = {joint.child: joint for joint in description.joints}
    parents = {joint.parent for joint in description.joints}
    shells = set()
    for link in description.links:
        above = joints.get(link.name)
        if above is None or above.moves or link.visuals or link.inertial or not link.collisions:
            continue
        parent = description.link(above.parent)
        if link.name not in parents and parent.collisions and parent.visuals:
            shells.add(link.name)
            changes.note(
                f"link {link.name}", "left out", "collision only", "–",
                f"a shell around {parent.name}, which has shapes of its own",
            )  # fmt: skip
    return replace(
        description,
        links=tuple(link for link in description.links if link.name not in shells),
        joints=tuple(joint for joint in description.joints if joint.child not in shells),
    )
