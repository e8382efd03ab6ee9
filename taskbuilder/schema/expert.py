"""How experts do a task: stages, each a barrier, with an order for each robot that acts in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from taskbuilder.schema.names import Refers
from taskbuilder.schema.values import (
    Coordinate,
    Extent,
    FrameName,
    Length,
    Model,
    ObjectName,
    ObjectOrGroup,
    Position,
    Reference,
    RobotName,
    RpyDeg,
    Shorthand,
    exactly_one,
    frozen,
)
from taskbuilder.wording import closest

NOTHING = "nothing"
"""What a gripper closes on that is to push, or to get out of the way."""

Seconds = Annotated[float, Field(gt=0.0, le=1000.0)]
Condition = Annotated[str, Field(min_length=1, max_length=100)]

# What all motions can say of how they go.
Above = Annotated[Coordinate, Field(description="Metres above the named frame.")]
Offset = Annotated[Position, Field(description="Offset from the named frame, along its own axes.")]
Straight = Annotated[bool, Field(description="Allow only the straight path.")]
Touching = Annotated[
    tuple[ObjectOrGroup, ...],
    Field(description="Objects that may be touched during the motion, to push or press them."),
]
Speed = Annotated[
    float,
    Field(gt=0.0, le=1.0, description="Fraction of the speed that the action mode allows."),
]
Tolerance = Annotated[
    Length | None,
    Field(
        description="Tolerance of the end position in metres: by default 0.01, and 0.02 to bring."
    ),
]


_TAKE = "to take something by a grasp point, write grasp"
_GO = "to take the tool to a frame, write reach"
_BRING = "to take what is held somewhere, write bring and to: {{bring: stick, to: goal}}"
_PUSH = (
    "to push something, close the gripper, then go through it: "
    "{{reach: block, offset: [0.2, 0, 0], straight: true, touching: [block]}}"
)


class Order(Model):
    """One robot's part of a stage: exactly one verb, and what goes with it."""

    INSTEAD: ClassVar = {
        **dict.fromkeys(("move", "go", "goto", "move_to", "go_to"), f"{_GO}; {_BRING}"),
        **dict.fromkeys(("pick", "pick_up", "take", "grip"), _TAKE),
        **dict.fromkeys(("place", "put", "carry", "lift"), _BRING),
        **dict.fromkeys(("open", "drop", "let_go"), "to open the gripper, write release"),
        **dict.fromkeys(("push", "press", "slide"), _PUSH),
    }

    grasp: Annotated[Reference, Refers("grasp")] | None = Field(
        None, description="Grasp point to take, such as stick.left_end."
    )
    reach: FrameName | None = Field(None, description="Grasp point or frame to go to.")
    bring: ObjectName | None = Field(
        None, description="Object to move: the held one, or one that lies on it."
    )
    retreat: Extent | None = Field(
        None, description="Metres to move back, against the direction of the tool."
    )
    release: Literal[True] | None = Field(None, description="Open the gripper.")
    close: Annotated[Reference, Refers("object", besides=NOTHING)] | None = Field(
        None, description="Close the gripper on an object until it is held, or on nothing."
    )
    to: FrameName | None = Field(None, description="Frame to bring the object to.")
    above: Above = 0.0
    offset: Offset = (0.0, 0.0, 0.0)
    approach: Extent | None = Field(
        None,
        description="Metres of straight path at the end: by default 0.08 to grasp, none to reach.",
    )
    rpy_deg: RpyDeg | None = Field(
        None, description="Orientation of the tool at the frame, in the world."
    )
    align: bool = Field(False, description="Turn the object to the orientation of the frame.")
    straight: Straight = False
    touching: Touching = ()
    speed: Speed = 1.0
    tolerance: Tolerance = None

    @property
    def verb(self) -> str:
        """The key that says what to do."""
        return next(name for name in VERBS if getattr(self, name) is not None)

    def __str__(self) -> str:
        words = {
            "release": self.verb,
            "retreat": f"retreat by {self.retreat} m",
            "bring": f"bring {self.bring} to {self.to}",
        }
        return words.get(self.verb) or f"{self.verb} {getattr(self, self.verb)}"

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
        if (self.bring is None) != (self.to is None):
            raise PydanticCustomError(
                "choice", "bring and to go together: {bring: stick, to: goal}"
            )
        exactly_one("an order", self, *VERBS)
        for key, verbs in ONLY_WITH.items():
            given = getattr(self, key) != type(self).model_fields[key].default
            if given and self.verb not in verbs:
                advice = _OTHERWISE_TURNED.get(self.verb, "") if key == "rpy_deg" else ""
                raise PydanticCustomError(
                    "choice",
                    "{key} goes with {verbs} only{advice}",
                    {"key": key, "verbs": _and(verbs), "advice": advice},
                )
        return self


ONLY_WITH = {
    "to": ("bring",),
    "approach": ("grasp", "reach"),
    "rpy_deg": ("reach",),
    "align": ("bring",),
    "above": ("reach", "bring"),
    "offset": ("reach", "bring"),
    "straight": ("reach", "bring"),
    "touching": ("reach", "bring", "retreat"),
    "speed": ("grasp", "reach", "bring", "retreat"),
    "tolerance": ("grasp", "reach", "bring", "retreat"),
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


def _and(words: Sequence[str]) -> str:
    *most, last = words
    return f"{', '.join(most)} and {last}" if most else last


def _different(robots: tuple[str, ...]) -> tuple[str, ...]:
    twice = [robot for robot in robots if robots.count(robot) > 1]
    if twice:
        raise PydanticCustomError("choice", 'names "{robot}" twice', {"robot": twice[0]})
    return robots


class Together(Model):
    """One load held by several grippers, moved as one and kept level."""

    together: Annotated[tuple[RobotName, ...], Field(min_length=2), AfterValidator(_different)] = (
        Field(description="The robots that hold the load.")
    )
    bring: ObjectName = Field(description="The load, or an object on it.")
    to: FrameName = Field(description="Frame to bring it to.")
    above: Above = 0.0
    offset: Offset = (0.0, 0.0, 0.0)
    straight: Straight = False
    touching: Touching = ()
    speed: Speed = 1.0
    tolerance: Tolerance = None

    def __str__(self) -> str:
        return f"bring {self.bring} to {self.to}"


class Wait(Model):
    """Nobody moves until a condition of the description holds."""

    until: Condition = Field(
        description="Success, failure, a stage or another condition of the description."
    )
    within: Seconds = Field(2.0, description="Timeout in seconds, after which the stage fails.")

    def __str__(self) -> str:
        return f"until {self.until}"


class Repeat(Model):
    """Some stages several times over."""

    repeat: Annotated[int, Field(ge=1, le=1000)] = Field(description="Maximum number of rounds.")
    stages: Annotated[tuple[ExpertStage, ...], Field(min_length=1)] = Field(
        description="The stages to repeat."
    )
    unless: Condition | None = Field(
        None, description="Stop once this condition of the description holds."
    )

    def __str__(self) -> str:
        return f"repeat {self.repeat} times"


def _is_order(value: Any) -> bool:
    return isinstance(value, Mapping | Order) or value == "release"


def _order_like(value: Any) -> Any:
    if not _is_order(value):
        raise PydanticCustomError(
            "order_type",
            "an order is needed: release, or a mapping such as {grasp: stick.left_end}",
        )
    return value


Stage = Annotated[
    Mapping[
        RobotName,
        Annotated[Order, Shorthand("release", {"release": True}), BeforeValidator(_order_like)],
    ],
    Field(min_length=1),
]

STAGES: Mapping[str, type[Model]] = {"together": Together, "until": Wait, "repeat": Repeat}
"""Key that tells what a stage is -> its model; any other has an order for each robot."""


def kind_of_stage(stage: Any) -> str:
    """What a stage is, or seems meant to be.

    Args:
        stage: A model, or a file's plain data, right or wrong.

    Returns:
        ``together``, ``until`` or ``repeat``, after its key, or ``each`` where each robot has an
        order.
    """
    if not isinstance(stage, Mapping):
        return next((key for key, kind in STAGES.items() if isinstance(stage, kind)), "each")
    if given := [key for key in STAGES if key in stage and not isinstance(stage[key], Mapping)]:
        return given[0]
    for key, value in stage.items():
        if not _is_order(value) and key not in Order.model_fields:
            keys = {own: tag for tag, kind in STAGES.items() for own in kind.model_fields}
            if meant := keys.get(key) or closest(key, STAGES):
                return meant
    return "each"


def directed(stage: Mapping[str, Any]) -> tuple[str, ...]:
    """The keys of a stage's plain data that stand for robots, if only by mistake."""
    return tuple(
        key
        for key, value in stage.items()
        if _is_order(value) or (isinstance(value, str) and key not in Order.model_fields)
    )


def _unmixed(stage: Any) -> Any:
    """Refuse what is several stages in one, or an order that nobody is given."""
    if not isinstance(stage, Mapping):
        return stage
    kind = STAGES.get(kind_of_stage(stage))
    if kind:
        strange = [key for key in stage if key not in kind.model_fields]
        mixed = [k for k in strange if k in STAGES or k in VERBS or _is_order(stage[k])]
        if mixed:
            own = [key for key in stage if key in STAGES and key not in mixed]
            raise PydanticCustomError(
                "choice",
                "has {keys}; together, until, repeat and orders for robots are stages of their own",
                {"keys": _and([*own, *mixed])},
            )
    elif bare := [key for key in stage if key in Order.model_fields and not _is_order(stage[key])]:
        raise PydanticCustomError(
            "choice",
            "has {keys} without a robot; an order is some robot's: {left: {grasp: stick.left_end}}",
            {"keys": _and(bare)},
        )
    return stage


ExpertStage = Annotated[
    Annotated[Stage, AfterValidator(frozen), Tag("each")]
    | Annotated[Together, Tag("together")]
    | Annotated[Wait, Tag("until")]
    | Annotated[Repeat, Tag("repeat")],
    Discriminator(kind_of_stage),
    BeforeValidator(_unmixed),
]


def orders_of(stage: ExpertStage) -> tuple[tuple[str, Order | Together], ...]:
    """Who is told what in a stage; empty for one that waits, or repeats others.

    Returns:
        Robots in words, such as ``left and right``, and their order.
    """
    if isinstance(stage, Together):
        return ((" and ".join(stage.together), stage),)
    return () if isinstance(stage, Wait | Repeat) else tuple(stage.items())


def in_words(stage: ExpertStage) -> str:
    """A stage in words: ``left: release, right: bring stick to goal``."""
    return ", ".join(f"{who}: {order}" for who, order in orders_of(stage)) or str(stage)


def waits(
    stages: Sequence[Any], path: tuple[str | int, ...] = ("expert",)
) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """Path and name of every condition of the description that stages wait for."""
    for index, stage in enumerate(stages):
        if isinstance(stage, Wait):
            yield (*path, index, "until"), stage.until
        elif isinstance(stage, Repeat):
            if stage.unless is not None:
                yield (*path, index, "unless"), stage.unless
            yield from waits(stage.stages, (*path, index, "stages"))


Repeat.model_rebuild()
