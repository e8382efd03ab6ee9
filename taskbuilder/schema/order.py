"""An order of an expert: what one robot is to do, and how."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, GetPydanticSchema, WithJsonSchema, field_validator, model_validator
from pydantic_core import PydanticCustomError, core_schema

from taskbuilder.schema.names import Refers
from taskbuilder.schema.values import (
    PLACE_SCHEMA,
    Coordinate,
    Extent,
    FrameName,
    Length,
    Model,
    Name,
    ObjectName,
    ObjectOrGroup,
    Place,
    Position,
    Reference,
    RpyDeg,
    check_place,
    exactly_one,
    is_number,
)

NOTHING = "nothing"
"""What a gripper closes on that is to push, or to get out of the way."""

JointName = Annotated[Reference, Refers("joint")]
JointDegrees = Annotated[float, Field(ge=-36000.0, le=36000.0)]
Condition = Annotated[str, Field(min_length=1, max_length=100)]


def _check_to(value: Any) -> Any:
    return float(value) if is_number(value) else check_place(value)


To = Annotated[
    str | tuple[float, float, float] | float,
    GetPydanticSchema(lambda _, __: core_schema.no_info_plain_validator_function(_check_to)),
    WithJsonSchema({"anyOf": [*PLACE_SCHEMA["anyOf"], {"type": "number"}]}),
    Refers("frame"),
]
"""A place, or the position of a joint in metres."""

# What all motions can say of how they go.
Above = Annotated[
    Coordinate, Field(description="Height of the end position above the target, in metres.")
]
Offset = Annotated[
    Position,
    Field(
        description="Offset of the end position from the target, along the axes of the target "
        "frame, or along the world's axes if the target is a point."
    ),
]
Straight = Annotated[bool, Field(description="Whether the path must be a straight line.")]
Touching = Annotated[
    tuple[ObjectOrGroup, ...],
    Field(description="Objects that the robot and its load may touch during the motion."),
]
Speed = Annotated[
    float,
    Field(
        gt=0.0, le=1.0, description="Speed, as a fraction of the maximum speed of the action mode."
    ),
]
Tolerance = Annotated[
    Length | None,
    Field(
        description="Tolerance of the end position; for `turn`, along the path of the handle. The "
        "default is 0.02 for `bring`, `turn`, `slide` and `push`, 0.002 for `press` on a joint, "
        "and otherwise 0.01."
    ),
]


_TAKE = "to take something by a grasp point, write grasp"
_GO = "to take the tool to a frame, write reach"
_BRING = "to take what is held somewhere, write bring and to: {{bring: stick, to: goal}}"
_PUSH = "to push something, write push and to: {{push: block, to: goal}}"
_TURN = "to move a joint by its handle, write turn and to_deg, or slide and to"


class Order(Model):
    """One robot's part of a stage: exactly one verb, and what goes with it."""

    INSTEAD: ClassVar = {
        **dict.fromkeys(("move", "go", "goto", "move_to", "go_to"), f"{_GO}; {_BRING}"),
        **dict.fromkeys(("pick", "pick_up", "take", "grip"), _TAKE),
        **dict.fromkeys(("place", "put", "carry", "lift"), _BRING),
        **dict.fromkeys(("open", "drop", "let_go"), "to open the gripper, write release"),
        **dict.fromkeys(("shove", "drag"), _PUSH),
        **dict.fromkeys(("rotate", "swing", "pull"), _TURN),
    }

    grasp: Annotated[Reference, Refers("grasp")] | None = Field(
        None, description="Grasp point to take hold of, such as stick.left_end."
    )
    reach: Place | None = Field(
        None, description="Grasp point, frame or point in the world to which the tool moves."
    )
    bring: ObjectName | None = Field(
        None,
        description="Object to move: the held object, or an object that lies on the held object.",
    )
    retreat: Extent | None = Field(
        None,
        description="Distance to move the tool back, against the direction in which the tool "
        "points.",
    )
    release: Literal[True] | None = Field(
        None, description="Open the gripper, or switch suction off."
    )
    close: Annotated[Reference, Refers("object", besides=NOTHING)] | None = Field(
        None,
        description="Object that the gripper holds after closing; or `nothing`, to close an empty "
        "gripper.",
    )
    turn: JointName | None = Field(
        None, description="Revolute joint to turn by a handle that the robot holds."
    )
    slide: JointName | None = Field(
        None, description="Prismatic joint to move by a handle that the robot holds."
    )
    push: ObjectName | None = Field(
        None, description="Object to push in a straight line with the closed gripper."
    )
    press: FrameName | None = Field(
        None, description="Frame to press from above with the closed gripper, such as a button."
    )
    home: Literal[True] | None = Field(None, description="Move the arm to its start configuration.")
    posture: Name | None = Field(
        None, description="Named posture to which the arm moves, such as tucked."
    )
    to: To | None = Field(
        None,
        description="For `bring` and `push`: frame, or point in the world, to which the object is "
        "moved. For `slide` and `press`: target position of the joint; optional for `press`.",
    )
    to_deg: JointDegrees | None = Field(
        None, description="Target position of the joint, in degrees."
    )
    until: Condition | None = Field(
        None,
        description="Condition of the description. The motion stops when the condition becomes "
        "true, and the order is done only if it did.",
    )
    turn_tool: bool = Field(True, description="Whether the tool turns together with the handle.")
    depth: Length | None = Field(
        None, description="Distance to press down, if `to` is not given; by default 0.01."
    )
    above: Above = 0.0
    offset: Offset = (0.0, 0.0, 0.0)
    approach: Extent | None = Field(
        None,
        description="Length of the straight path at the end of the motion; by default 0.08 for "
        "`grasp` and 0 for `reach`.",
    )
    rpy_deg: RpyDeg | None = Field(
        None, description="Orientation of the tool at the end of the motion, in the world frame."
    )
    align: bool = Field(
        False, description="Whether the object is also turned to the orientation of the frame `to`."
    )
    straight: Straight = False
    touching: Touching = ()
    speed: Speed = 1.0
    tolerance: Tolerance = None
    tolerance_deg: Annotated[float, Field(gt=0.0, le=360.0)] | None = Field(
        None,
        description="Tolerance of the joint, in degrees, instead of `tolerance`; 7.5 by default.",
    )

    @property
    def verb(self) -> str:
        """The key that says what to do."""
        return next(name for name in VERBS if getattr(self, name) is not None)

    @property
    def place(self) -> str | tuple[float, float, float]:
        """The frame, or the point of the world, that something is brought or pushed to."""
        return "" if self.to is None or isinstance(self.to, float) else self.to

    @property
    def joint(self) -> str | None:
        """The joint that is moved by its handle."""
        return self.turn or self.slide

    @property
    def joint_position(self) -> float | None:
        """Where a joint is to be, in rad or m; None if not given."""
        if self.to_deg is not None:
            return math.radians(self.to_deg)
        return self.to if isinstance(self.to, float) else None

    def __str__(self) -> str:
        words = {
            "release": self.verb,
            "home": "go home",
            "posture": f"take the posture {self.posture}",
            "retreat": f"retreat by {self.retreat} m",
            "reach": f"reach {spelt(self.reach)}",
            "bring": f"bring {self.bring} to {spelt(self.to)}",
            "push": f"push {self.push} to {spelt(self.to)}",
            "turn": f"turn {self.turn} to {self.to_deg}°",
            "slide": f"slide {self.slide} to {self.to} m",
        }
        end = f", until {self.until}" if self.until else ""
        return (words.get(self.verb) or f"{self.verb} {getattr(self, self.verb)}") + end

    @field_validator("close", mode="before")
    @classmethod
    def _close_on_something(cls, value: Any) -> Any:
        if not isinstance(value, str | None):
            raise PydanticCustomError(
                "close",
                "name the object that is to be held then, or {nothing}",
                {"nothing": NOTHING},
            )
        return value

    @model_validator(mode="after")
    def _one_verb(self) -> Order:
        exactly_one("an order", self, *VERBS)
        if self.verb in _EXAMPLES:
            self._check_target()
        for key, verbs in ONLY_WITH.items():
            given = getattr(self, key) != type(self).model_fields[key].default
            if given and self.verb not in verbs:
                advice = _OTHERWISE_TURNED.get(self.verb, "") if key == "rpy_deg" else ""
                raise PydanticCustomError(
                    "choice",
                    "{key} goes with {verbs} only{advice}",
                    {"key": key, "verbs": listing(verbs), "advice": advice},
                )
        return self

    def _check_target(self) -> None:
        """Refuse a missing target, or one of a kind that the verb does not take."""
        key = "to_deg" if self.verb == "turn" else "to"
        in_metres = self.verb in ("slide", "press")
        given, example = getattr(self, key), _EXAMPLES[self.verb]
        if given is None and self.verb != "press":
            other, unit = ("to", "degrees") if self.verb == "turn" else ("to_deg", "metres")
            advice = f"; {self.verb} takes {unit}" if getattr(self, other) is not None else ""
            raise PydanticCustomError(
                "choice",
                "{verb} and {key} go together{advice}: {example}",
                {"verb": self.verb, "key": key, "advice": advice, "example": example},
            )
        if key == "to" and given is not None and isinstance(given, float) != in_metres:
            kind = "the joint's position in metres" if in_metres else "a frame or [x, y, z]"
            raise PydanticCustomError(
                "choice",
                "to of {verb} is {kind}: {example}",
                {"verb": self.verb, "kind": kind, "example": example},
            )
        if self.tolerance is not None and self.tolerance_deg is not None:
            raise PydanticCustomError(
                "choice",
                "turn has tolerance, in metres, and tolerance_deg, in degrees; give one of them",
            )
        if self.to is not None and self.depth is not None:
            raise PydanticCustomError("choice", "press has to and depth; give one of them")


def spelt(place: str | tuple[float, float, float] | float | None) -> str:
    """A place as files write it."""
    if isinstance(place, tuple):
        return f"[{', '.join(f'{value:g}' for value in place)}]"
    return str(place)


_EXAMPLES = {
    "bring": "{bring: stick, to: goal}",
    "push": "{push: block, to: goal}",
    "turn": "{turn: chest.lid_hinge, to_deg: 70}",
    "slide": "{slide: cabinet.runner, to: 0.2}",
    "press": "{press: button, to: 0.01}",
}
"""Verb -> an order with the target that it takes."""

_MOVING = (
    *("grasp", "reach", "bring", "retreat", "turn", "slide", "push", "press", "home", "posture"),
)

ONLY_WITH = {
    "to": ("bring", "slide", "push", "press"),
    "to_deg": ("turn",),
    "until": ("turn", "slide"),
    "turn_tool": ("turn",),
    "depth": ("press",),
    "approach": ("grasp", "reach"),
    "rpy_deg": ("reach",),
    "align": ("bring",),
    "above": ("reach", "bring"),
    "offset": ("reach", "bring", "push"),
    "straight": ("reach", "bring"),
    "touching": _MOVING,
    "speed": _MOVING,
    "tolerance": _MOVING,
    "tolerance_deg": ("turn",),
}
"""Key of an order -> the verbs that it goes with."""

VERBS = tuple(key for key in Order.model_fields if key not in ONLY_WITH)
"""Keys that say what to do: those that go with no other."""

_OTHERWISE_TURNED = {
    "grasp": "; a grasp point says how it is taken, by its approach and across",
    "bring": "; to turn what is brought, write align: true, and rpy_deg at the site it is brought "
    "to",
    "retreat": "; turn the tool by an order to reach before",
}
"""Verb -> how to turn a tool that is given ``rpy_deg`` with it."""


def listing(words: Sequence[str]) -> str:
    """Words as a list in a sentence."""
    *most, last = words
    return f"{', '.join(most)} and {last}" if most else last
