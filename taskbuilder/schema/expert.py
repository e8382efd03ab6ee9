"""How experts do a task: stages, each a barrier, with an order for each robot that acts in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    GetJsonSchemaHandler,
    Tag,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import PydanticCustomError, core_schema

from taskbuilder.schema.order import (
    VERBS,
    Above,
    Condition,
    Offset,
    Order,
    Speed,
    Straight,
    Tolerance,
    Touching,
    listing,
    spelt,
)
from taskbuilder.schema.values import (
    ONE,
    SEVERAL,
    Model,
    ObjectName,
    Place,
    RobotName,
    frozen,
)
from taskbuilder.wording import closest

Seconds = Annotated[float, Field(gt=0.0, le=1000.0)]


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
    to: Place = Field(description="Frame, or point of the world, to bring it to.")
    above: Above = 0.0
    offset: Offset = (0.0, 0.0, 0.0)
    straight: Straight = False
    touching: Touching = ()
    speed: Speed = 1.0
    tolerance: Tolerance = None

    def __str__(self) -> str:
        return f"bring {self.bring} to {spelt(self.to)}"


class Wait(Model):
    """Nobody moves until a condition of the description holds."""

    until: Condition = Field(
        description="Success, failure, a stage or another condition of the description."
    )
    within: Seconds = Field(
        2.0,
        description="Time limit. If the condition is still false when it expires, the stage fails.",
    )

    def __str__(self) -> str:
        return f"until {self.until}"


class Repeat(Model):
    """Some stages several times over."""

    repeat: Annotated[int, Field(ge=1, le=1000)] = Field(description="Maximum number of rounds.")
    stages: Annotated[tuple[ExpertStage, ...], Field(min_length=1)] = Field(
        description="The stages to repeat."
    )
    unless: Condition | None = Field(
        None, description="Condition of the description that ends the repetition when it is true."
    )

    def __str__(self) -> str:
        return f"repeat {self.repeat} times"


WORDS = ("release", "home")
"""Orders that may be written as a word."""


@dataclass(frozen=True)
class Spelt:
    """In an annotation: words that files may write in place of the mapping."""

    words: tuple[str, ...]

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"enum": list(self.words)}, handler(schema)]}


def _is_order(value: Any) -> bool:
    return isinstance(value, Mapping | Order) or (isinstance(value, str) and value in WORDS)


def _are_orders(value: Any) -> bool:
    """Whether a value is a list in which orders stand."""
    return isinstance(value, list | tuple) and any(
        isinstance(item, Order)
        or (isinstance(item, str) and item in WORDS)
        or (isinstance(item, Mapping) and any(key in _ORDER_KEYS for key in item))
        for item in value
    )


def _order_like(value: Any) -> Any:
    if not _is_order(value):
        raise PydanticCustomError(
            "order_type",
            "an order is needed: release, home, or a mapping such as {grasp: stick.left_end}",
        )
    return {value: True} if isinstance(value, str) else value


OneOrder = Annotated[Order, Spelt(WORDS), BeforeValidator(_order_like)]

Orders = Annotated[
    Annotated[OneOrder, Tag(ONE)]
    | Annotated[tuple[OneOrder, ...], Field(min_length=1), Tag(SEVERAL)],
    Discriminator(lambda value: SEVERAL if isinstance(value, list | tuple) else ONE),
]
"""An order, or several that are done one after the other."""

Stage = Annotated[Mapping[RobotName, Orders], Field(min_length=1)]

STAGES: Mapping[str, type[Model]] = {"together": Together, "until": Wait, "repeat": Repeat}
"""Key that tells what a stage is -> its model; any other has an order for each robot."""


_ORDER_KEYS = frozenset(Order.model_fields) - frozenset(STAGES)
"""Keys that only orders have."""


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
        if not (_is_order(value) or _are_orders(value)) and key not in Order.model_fields:
            keys = {own: tag for tag, kind in STAGES.items() for own in kind.model_fields}
            if meant := keys.get(key) or closest(key, STAGES):
                return meant
    return "each"


def listed(told: Order | tuple[Order, ...]) -> tuple[Order, ...]:
    """A robot's orders in a stage, in sequence; a single order becomes a tuple of one."""
    return told if isinstance(told, tuple) else (told,)


def each_order(
    stages: Sequence[Any], path: tuple[str | int, ...] = ("expert",)
) -> Iterator[tuple[tuple[str | int, ...], str, Order]]:
    """Path, robot and order of every order that a single robot is given."""
    for index, stage in enumerate(stages):
        if isinstance(stage, Repeat):
            yield from each_order(stage.stages, (*path, index, "stages"))
        elif isinstance(stage, Mapping):
            for robot, told in stage.items():
                for number, order in enumerate(listed(told)):
                    where = (number,) if isinstance(told, tuple) else ()
                    yield (*path, index, robot, *where), robot, order


def each_together(
    stages: Sequence[Any], path: tuple[str | int, ...] = ("expert",)
) -> Iterator[tuple[tuple[str | int, ...], Together]]:
    """Path and stage of every load that several robots are to bring."""
    for index, stage in enumerate(stages):
        if isinstance(stage, Repeat):
            yield from each_together(stage.stages, (*path, index, "stages"))
        elif isinstance(stage, Together):
            yield (*path, index), stage


def directed(stage: Mapping[str, Any]) -> tuple[str, ...]:
    """The keys of a stage's plain data that stand for robots, if only by mistake."""
    return tuple(
        key
        for key, value in stage.items()
        if _is_order(value)
        or (isinstance(value, str) and key not in Order.model_fields)
        or _are_orders(value)
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
                {"keys": listing([*own, *mixed])},
            )
    elif bare := [key for key in stage if key in Order.model_fields and not _is_order(stage[key])]:
        raise PydanticCustomError(
            "choice",
            "has {keys} without a robot; an order is some robot's: {left: {grasp: stick.left_end}}",
            {"keys": listing(bare)},
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
    if isinstance(stage, Wait | Repeat):
        return ()
    return tuple((robot, order) for robot, told in stage.items() for order in listed(told))


def in_words(stage: ExpertStage) -> str:
    """A stage in words: ``left: release, right: bring stick to goal``."""
    return ", ".join(f"{who}: {order}" for who, order in orders_of(stage)) or str(stage)


DONE = "done"
"""Label of the control steps after the last stage."""


def stage_labels(stages: Sequence[ExpertStage]) -> tuple[str, ...]:
    """A label for each stage; two stages have the same label only if they are the same.

    A label is the stage in words. Where different stages have the same words, the values in which
    they differ are added, as far as they are needed: ``left: reach cube (above 0.1 m)``.
    """
    alike: dict[str, list[ExpertStage]] = {}
    for stage in stages:
        group = alike.setdefault(in_words(stage), [])
        if stage not in group:
            group.append(stage)
    keys = {words: _telling_apart(group) for words, group in alike.items()}
    return tuple(_label(stage, keys[in_words(stage)]) for stage in stages)


def _telling_apart(group: Sequence[ExpertStage]) -> Sequence[str]:
    """The keys, as few as possible in their order, that give each stage a label of its own."""
    columns = zip(*(_parts(stage) for stage in group), strict=True)
    differing = [
        key
        for parts in columns
        for key in type(parts[0][1]).model_fields
        if any(getattr(part, key) != getattr(parts[0][1], key) for _, part in parts)
    ]
    keys = list(dict.fromkeys(differing))
    for count in range(len(keys)):
        if len({_label(stage, keys[:count]) for stage in group}) == len(group):
            return keys[:count]
    return keys


def _parts(stage: ExpertStage) -> tuple[tuple[str, Model], ...]:
    """Who is told what; a stage that waits, or repeats others, is told to nobody."""
    return orders_of(stage) or (("", stage),) if isinstance(stage, Model) else orders_of(stage)


def _label(stage: ExpertStage, keys: Sequence[str]) -> str:
    """A stage in words, with its values for some keys where they are not the defaults."""
    return ", ".join(
        f"{who}: {part}{_details(part, keys)}" if who else f"{part}{_details(part, keys)}"
        for who, part in _parts(stage)
    )


def _details(part: Model, keys: Sequence[str]) -> str:
    fields = type(part).model_fields
    said = [
        _value_in_words(key, getattr(part, key))
        for key in keys
        if key in fields and getattr(part, key) != fields[key].default
    ]
    return f" ({', '.join(said)})" if said else ""


def _value_in_words(key: str, value: Any) -> str:
    if key == "stages":
        return "; ".join(map(in_words, value))
    if isinstance(value, bool):
        return key if value else f"{key} false"
    if isinstance(value, tuple) and value and isinstance(value[0], str):
        return f"{key} {listing(value)}"
    word = f"{value:g}" if isinstance(value, float) else spelt(value)
    return f"{key} {word}{_UNITS.get(key, '')}"


_UNITS = {
    **dict.fromkeys(("above", "offset", "approach", "tolerance", "depth", "to"), " m"),
    "within": " s",
}


def waits(
    stages: Sequence[Any], path: tuple[str | int, ...] = ("expert",)
) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """Path and name of every condition of the description that stages and orders wait for."""
    for index, stage in enumerate(stages):
        if isinstance(stage, Wait):
            yield (*path, index, "until"), stage.until
        elif isinstance(stage, Repeat):
            if stage.unless is not None:
                yield (*path, index, "unless"), stage.unless
            yield from waits(stage.stages, (*path, index, "stages"))
        elif isinstance(stage, Mapping):
            for robot, told in stage.items():
                for number, order in enumerate(listed(told)):
                    if order.until is not None:
                        where = (number,) if isinstance(told, tuple) else ()
                        yield (*path, index, robot, *where, "until"), order.until


Repeat.model_rebuild()
