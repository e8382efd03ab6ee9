"""The vocabulary of task and robot files: numbers with units, names, colours, frozen mappings."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NoReturn, TypeVar, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    GetPydanticSchema,
    WithJsonSchema,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import PydanticCustomError, core_schema

from taskbuilder.extensions import Door
from taskbuilder.schema.names import Refers

Key = TypeVar("Key")
Value = TypeVar("Value")


class Model(BaseModel):
    """Base of everything in a file: frozen, strict, no unknown keys, no NaN."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class FrozenDict(dict[Key, Value]):
    """A dict that refuses to change. Unlike a mapping proxy it copies, pickles and dumps."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("a specification does not change; make a new one")

    __setitem__ = __delitem__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse
    __ior__ = _refuse

    def __reduce__(self) -> tuple[type[FrozenDict[Key, Value]], tuple[dict[Key, Value]]]:
        return (type(self), (dict(self),))


def frozen(value: Any) -> Any:
    """Plain data that cannot be changed: mappings and lists, however deep, as frozen copies."""
    if isinstance(value, dict):
        return FrozenDict({key: frozen(item) for key, item in value.items()})
    if isinstance(value, list | tuple):
        return tuple(frozen(item) for item in value)
    return value


@dataclass(frozen=True, eq=False)
class Shorthand:
    """In an annotation: files may write a word for one of the values."""

    word: str
    meaning: Any

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        def spell_out(value: Any) -> Any:
            if isinstance(value, str) and value != self.word:
                raise PydanticCustomError(
                    "choice",
                    'is the text "{value}"; the only word that may stand here is "{word}"',
                    {"value": value, "word": self.word},
                )
            return self.meaning if isinstance(value, str) else value

        return core_schema.no_info_before_validator_function(spell_out, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"const": self.word}, handler(schema)]}


@dataclass(frozen=True)
class OrNumber:
    """In an annotation: files may write a number in place of the mapping."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        model = next(kind for kind in get_args(source) if kind is not float)

        def choose(value: Any, parse: core_schema.ValidatorFunctionWrapHandler) -> Any:
            plain = isinstance(value, int | float) and not isinstance(value, bool)
            return float(value) if plain and math.isfinite(value) else parse(value)

        return core_schema.no_info_wrap_validator_function(choose, handler(model))

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"type": "number"}, handler(schema)]}


@dataclass(frozen=True)
class OneOf:
    """In an annotation of text: one of the library's own names, or of those that packages add.

    Attributes:
        own: The library's own names.
        door: The parts that packages add.
    """

    own: tuple[str, ...]
    door: Door

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        del source, handler
        return core_schema.no_info_plain_validator_function(self._checked)

    def _checked(self, value: Any) -> Any:
        known = self.door.names(self.own)
        if not isinstance(value, str) or value not in known:
            raise PydanticCustomError("no_choice", "no choice", {"choices": known})
        if wrong := self.door.problem(value, self.own):
            raise PydanticCustomError("declared_twice", "{wrong}", {"wrong": wrong})
        return value

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        del schema, handler  # editors complete the library's own names, and take others
        return {"anyOf": [{"enum": [*self.own]}, {"type": "string"}]}


RESERVED = {
    *("self", "world", "all", "together", "until", "repeat", "nothing", "time_left", "description"),
    "background",
}


def _check_name(name: str) -> str:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,39}", name):
        raise PydanticCustomError(
            "name", "not a name; a letter, then letters, digits and _, at most 40 in all"
        )
    if name in RESERVED:
        raise PydanticCustomError("name", "a reserved word; choose another name")
    return name


ONE, SEVERAL = "<one>", "<several>"
"""Discriminator tags: a robot has one order in a stage, or several. They are not valid names."""

Name = Annotated[
    str,
    AfterValidator(_check_name),
    Field(json_schema_extra={"pattern": "^[A-Za-z][A-Za-z0-9_]{0,39}$"}),
]
Text = Annotated[str, Field(min_length=1, max_length=2000)]
Reference = Annotated[str, Field(min_length=1, max_length=100)]
"""A name, or a dotted name such as ``tray.left_handle``, to be resolved in the scene."""

RobotName = Annotated[Name, Refers("robot")]
ObjectName = Annotated[Reference, Refers("object")]
ObjectOrGroup = Annotated[Reference, Refers("object", several=True)]
FrameName = Annotated[Reference, Refers("frame")]
FrameOrWorld = Annotated[Reference, Refers("frame", besides="world")]

Coordinate = Annotated[float, Field(ge=-100.0, le=100.0)]
Length = Annotated[float, Field(ge=0.0005, le=100.0)]
Extent = Annotated[float, Field(ge=0.0, le=100.0)]
Degrees = Annotated[float, Field(ge=-360.0, le=360.0)]
Mass = Annotated[float, Field(ge=1e-4, le=1000.0)]
Friction = Annotated[float, Field(ge=0.0, le=10.0)]
Pixels = Annotated[int, Field(ge=16, le=4096)]
Positive = Annotated[float, Field(gt=0.0, le=1e4)]

Position = tuple[Coordinate, Coordinate, Coordinate]
Edges = tuple[Length, Length, Length]
RpyDeg = tuple[Degrees, Degrees, Degrees]

PALETTE: Mapping[str, tuple[float, float, float]] = FrozenDict(
    black=(0.10, 0.10, 0.11),
    blue=(0.16, 0.36, 0.72),
    brown=(0.40, 0.26, 0.16),
    cyan=(0.20, 0.67, 0.75),
    gray=(0.50, 0.51, 0.53),
    green=(0.22, 0.58, 0.28),
    lightgray=(0.78, 0.79, 0.80),
    maroon=(0.42, 0.08, 0.12),
    navy=(0.10, 0.16, 0.36),
    olive=(0.46, 0.46, 0.16),
    orange=(0.91, 0.49, 0.13),
    pink=(0.90, 0.56, 0.66),
    purple=(0.45, 0.25, 0.60),
    red=(0.83, 0.13, 0.12),
    silver=(0.70, 0.71, 0.73),
    teal=(0.12, 0.48, 0.48),
    white=(0.94, 0.94, 0.93),
    wood=(0.76, 0.62, 0.46),
    yellow=(0.93, 0.78, 0.18),
)
"""Matte colours by name: what a task file may call a thing's colour."""

_HEX = re.compile(r"#[0-9a-fA-F]{6}")


def _check_color(value: Any) -> str | tuple[float, float, float]:
    if isinstance(value, str) and (value in PALETTE or _HEX.fullmatch(value)):
        return value
    if isinstance(value, str):
        raise PydanticCustomError(
            "color",
            'no such colour; one of {palette}, or [r, g, b] from 0 to 1, or "#rrggbb"',
            {"palette": ", ".join(PALETTE), "value": value},
        )
    numbers = isinstance(value, tuple) and all(
        isinstance(part, int | float) and not isinstance(part, bool) and 0 <= part <= 1
        for part in value
    )
    if not numbers or len(value) != 3:
        raise PydanticCustomError(
            "color", 'a colour is a name, [r, g, b] with each from 0 to 1, or "#rrggbb"'
        )
    return (float(value[0]), float(value[1]), float(value[2]))


Color = Annotated[
    str | tuple[float, float, float],
    # One validator in place of a union, which would report a failure for each of its members.
    GetPydanticSchema(lambda _, __: core_schema.no_info_plain_validator_function(_check_color)),
    WithJsonSchema(
        {
            "anyOf": [
                {"enum": [*PALETTE]},
                {"type": "string", "pattern": "^#[0-9a-fA-F]{6}$"},
                {
                    "type": "array",
                    "items": {"type": "number", "minimum": 0, "maximum": 1},
                    "minItems": 3,
                    "maxItems": 3,
                },
            ]
        }
    ),
]


def check_place(value: Any) -> str | tuple[float, float, float]:
    """The name of a frame, or three coordinates in the world.

    Raises:
        PydanticCustomError: It is neither.
    """
    if isinstance(value, str) and 1 <= len(value) <= 100:
        return value
    if isinstance(value, list | tuple) and len(value) == 3 and all(map(_is_coordinate, value)):
        return (float(value[0]), float(value[1]), float(value[2]))
    raise PydanticCustomError(
        "place", "the name of a frame, or [x, y, z] in metres from -100 to 100, is needed"
    )


def _is_coordinate(value: Any) -> bool:
    return is_number(value) and -100.0 <= value <= 100.0


def is_number(value: Any) -> bool:
    """Whether a value of a file is a number; true and false are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


PLACE_SCHEMA: Mapping[str, Any] = FrozenDict(
    anyOf=[
        {"type": "string", "minLength": 1, "maxLength": 100},
        {
            "type": "array",
            "items": {"type": "number", "minimum": -100, "maximum": 100},
            "minItems": 3,
            "maxItems": 3,
        },
    ]
)

Place = Annotated[
    str | tuple[float, float, float],
    GetPydanticSchema(lambda _, __: core_schema.no_info_plain_validator_function(check_place)),
    WithJsonSchema(dict(PLACE_SCHEMA)),
    Refers("frame"),
]
"""Where something is to go: the name of a frame, or [x, y, z] in the world."""


def rgb(color: str | tuple[float, float, float]) -> tuple[float, float, float]:
    """Red, green and blue from 0 to 1 of a colour as files write it."""
    if not isinstance(color, str):
        return color
    if color in PALETTE:
        return PALETTE[color]
    return (int(color[1:3], 16) / 255, int(color[3:5], 16) / 255, int(color[5:7], 16) / 255)


def color_name(color: str | tuple[float, float, float]) -> str:
    """The name of a colour: its own, or the nearest in the palette, by red, green and blue."""
    if isinstance(color, str) and color in PALETTE:
        return color
    return min(PALETTE, key=lambda name: math.dist(rgb(color), PALETTE[name]))


def exactly_one(what: str, model: BaseModel, *names: str) -> None:
    """Refuse a model in which none or several of the named keys are given.

    Raises:
        PydanticCustomError: To be raised inside a validator.
    """
    given = [name for name in names if getattr(model, name) is not None]
    if len(given) != 1:
        raise PydanticCustomError(
            "choice",
            "{what} has {given}; give exactly one of {names}",
            {"what": what, "given": " and ".join(given) or "none", "names": ", ".join(names)},
        )
