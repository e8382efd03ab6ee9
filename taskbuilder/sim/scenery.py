"""What pictures show and physics does not know: textures, and things that nothing touches.

The rasteriser draws them; Bullet's renderers do not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from taskbuilder.geometry import Pose, Vec3
from taskbuilder.shapes import BoxShape, CylinderShape, SphereShape

PatternKind = Literal["checks", "stripes", "grain", "speckles"]


@dataclass(frozen=True)
class Texture:
    """A second colour, which alternates with the body's own.

    Attributes:
        kind: The pattern.
        color: The second colour: red, green and blue, 0 to 1. It is mixed with the body's own.
        period: Length after which the pattern repeats, or nearly so, m.
        angle: Direction of the pattern about the body's z axis, rad.
    """

    kind: PatternKind
    color: Vec3
    period: float
    angle: float


@dataclass(frozen=True)
class Distractor:
    """A thing that is only drawn.

    Attributes:
        shape: Its shape.
        pose: Where it is in the world.
        color: Red, green and blue, 0 to 1.
    """

    shape: BoxShape | CylinderShape | SphereShape
    pose: Pose
    color: Vec3


@dataclass(frozen=True)
class Scenery:
    """What is drawn beside the bodies and their colours.

    Attributes:
        textures: By Bullet's number of the body.
        distractors: In any order.
    """

    textures: Mapping[int, Texture] = field(default_factory=dict)
    distractors: tuple[Distractor, ...] = ()
