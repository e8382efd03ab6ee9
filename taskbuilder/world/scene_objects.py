"""Objects and sites of the world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from taskbuilder.assets.model import UrdfMimic
from taskbuilder.geometry import Box, Pose
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.sites import SiteSpec
from taskbuilder.sim.body import BASE, Body
from taskbuilder.sim.passive_joints import PassiveJoint


@dataclass(frozen=True)
class ObjectFrame:
    """A named frame of an object: a part's, or a grasp point's.

    Attributes:
        pose: In the frame of the link that it is fixed to.
        link: Index of that link.
    """

    pose: Pose
    link: int = BASE


@dataclass(frozen=True)
class SceneObject:
    """An object, built.

    Attributes:
        name: Its name in the scene.
        spec: What the task file says of it.
        body: Its body in the simulation.
        boxes: Bounding box of each part or link, in its own frame.
        frames: Each part and grasp point.
        joints: Indices of the joints that move.
        moving_links: Names of the links that they move.
        passive: What acts on those that have more than constant friction, by name.
        mimics: Those that follow another one, which are no states of their own, and what they
            follow.
        start_ranges: Range of the initial position (rad or m) of those that start at random.
    """

    name: str
    spec: ObjectSpec
    body: Body
    boxes: Mapping[str, Box]
    frames: Mapping[str, ObjectFrame]
    joints: tuple[int, ...] = ()
    moving_links: tuple[str, ...] = ()
    passive: Mapping[str, PassiveJoint] = field(default_factory=dict)
    mimics: Mapping[str, UrdfMimic] = field(default_factory=dict)
    start_ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def free_links(self) -> frozenset[int] | None:
        """Indices of its links that are not fixed to the world; None for all of them."""
        if not self.spec.fixed:
            return None
        return frozenset(self.body.links[name] for name in self.moving_links)


@dataclass
class Site:
    """A named frame: fixed in the world for an episode, or riding on something.

    Attributes:
        name: Its name in the scene.
        spec: What the task file says of it.
        pose: In the world, or in the frame it rides on.
        box: Bounding box of its marker, or None without one.
        marker: What it looks like, or None.
    """

    name: str
    spec: SiteSpec
    pose: Pose
    box: Box | None
    marker: Body | None

    @property
    def rides_on(self) -> str | None:
        """The frame that it moves with, or None if it stands in the world."""
        return self.spec.frame if self.spec.frame != "world" else None
