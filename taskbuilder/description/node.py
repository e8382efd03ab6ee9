"""The building blocks of descriptions: frozen expressions over names in the scene.

An expression is a value: it can be compared, hashed, printed and checked against the scene before
anything runs. What it has to remember during an episode is kept outside it (see `Referee`), so
that two environments never share memory.
"""

from __future__ import annotations

import linecache
import reprlib
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from inspect import signature
from itertools import islice
from math import isnan
from pathlib import Path
from types import FrameType
from typing import Annotated, Any, Generic, SupportsFloat, TypeVar, get_args, get_type_hints

from taskbuilder.description.view import WorldView
from taskbuilder.errors import Location, TaskbuilderError
from taskbuilder.spec.names import Kind, Refers, SceneNames

RobotName = Annotated[str, Refers("robot")]
ObjectName = Annotated[str, Refers("object")]
BodyName = Annotated[str, Refers("body")]
SolidName = Annotated[str, Refers("solid")]
FrameName = Annotated[str, Refers("frame")]
SiteName = Annotated[str, Refers("site")]
JointName = Annotated[str, Refers("joint")]
ContainerName = Annotated[str, Refers("container")]

Memory = Any
"""What a node carries from one control step to the next; an immutable value."""

Parts = tuple[Any, ...]
"""The values of a node's parts at this control step."""

Step = tuple[Any, Memory]
"""A node's value at this control step, and its memory for the next."""


@dataclass(frozen=True)
class Argument:
    """A value that a node was made of: a field's, or a parameter's of a decorated function."""

    name: str
    value: Any
    annotation: Any


class Node:
    """An expression of a description; knows the place in the file where it was written.

    A node is evaluated after reset and after every control step, exactly once, its parts first.
    """

    _origin: Location | None = None

    def __new__(cls, *_: Any, **__: Any) -> Any:
        node = super().__new__(cls)
        object.__setattr__(node, "_origin", _caller())
        return node

    @property
    def origin(self) -> Location | None:
        """Where the node was written."""
        return self._origin

    @property
    def written(self) -> Location | None:
        """Where the function was written that says the node's value; of ours, where it is used."""
        own = type(self)
        for name in ("holds", "value", "update"):
            found = getattr(own, name, None)
            if found is not None and not is_ours(found):
                return _place_of(found) or self.origin
        call = getattr(self, "call", None)
        return (_place_of(call.function) if isinstance(call, Call) else None) or self.origin

    @property
    def parts(self) -> tuple[Node, ...]:
        """The nodes that this one is made of, in a fixed order."""
        return ()

    def start(self, world: WorldView) -> Memory:
        """Memory at the beginning of an episode."""
        return None

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        """This node's value, given those of its parts, and its memory for the next step."""
        raise NotImplementedError

    def force_pairs(self) -> Iterator[tuple[str, str]]:
        """Pairs of bodies whose `WorldView.contact_force` it asks for; no others are metered."""
        return iter(())

    def problems(self, names: SceneNames) -> Iterator[str]:
        """What is wrong with the node's own values, beyond names and kinds."""
        return iter(())

    def arguments(self) -> Iterator[Argument]:
        """The values that the node was made of.

        Raises:
            NameError: An annotation names something that its file does not import.
        """
        if is_dataclass(self):
            hints = _hints(type(self))
            for field in fields(self):
                yield Argument(field.name, getattr(self, field.name), hints[field.name])

    def references(self) -> Iterator[tuple[Kind, str]]:
        """Every name among the node's own arguments, with what it must stand for."""
        for argument in self.arguments():
            for kind in dict.fromkeys(_kinds(argument.annotation)):
                yield from ((kind, name) for name in _texts(argument.value))


class ValueOfNodeError(TaskbuilderError, TypeError):
    """An expression gave a value that it cannot have.

    Attributes:
        place: Where what gave it was written, or None.
    """

    def __init__(self, node: Node, value: Any, right: str) -> None:
        said = "nothing" if value is None else reprlib.repr(value)
        super().__init__(f"{_name_of(node)} gave {said}; {right}")
        self.place = node.written

    def __reduce__(self) -> Any:
        return _remade, (type(self), self.args, self.place)


def _remade(sort: type[ValueOfNodeError], args: tuple[Any, ...], place: Location | None) -> Any:
    error = sort.__new__(sort, *args)
    error.args, error.place = args, place
    return error


def _name_of(node: Node) -> str:
    """What an expression is, in a line."""
    call = getattr(node, "call", None)
    return call.function.__name__ if isinstance(call, Call) else type(node).__name__


class Condition(Node):
    """Something that is true or false of the world.

    Compose with ``&``, ``|``, ``~`` and the conditions of `taskbuilder.description.logic`. Make
    your own by subclassing as a frozen dataclass with a method ``holds``, or by `condition`.
    """

    def holds(self, world: WorldView) -> bool:
        """Whether the condition is true now."""
        raise NotImplementedError

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        value = self.holds(world)
        return (value if value is True or value is False else self.truth(value)), memory

    def truth(self, value: Any) -> bool:
        """A value as a condition's; numbers are true unless they are 0.

        Raises:
            ValueOfNodeError: It is neither true nor false.
        """
        if isinstance(value, SupportsFloat):
            with suppress(TypeError, ValueError):  # as of an array of several
                if not isnan(value):
                    return bool(value)
        raise ValueOfNodeError(self, value, "a condition gives True or False")

    def __and__(self, other: Condition) -> Condition:
        return All(_flat(All, self) + _flat(All, other))

    def __or__(self, other: Condition) -> Condition:
        return Any_(_flat(Any_, self) + _flat(Any_, other))

    def __invert__(self) -> Condition:
        return Not(self)

    def __bool__(self) -> bool:
        # Python's `and`, `or` and `not` would drop an operand in silence.
        raise TypeError("a condition has no truth of its own; combine conditions by &, | and ~")


def _flat(sort: type[All] | type[Any_], node: Condition) -> tuple[Condition, ...]:
    if not isinstance(node, Condition):
        raise TypeError(f"{node!r} is no condition; combine conditions with conditions")
    return node.of if isinstance(node, All | Any_) and type(node) is sort else (node,)


@dataclass(frozen=True)
class All(Condition):
    """Every one of several conditions; written ``a & b``."""

    of: tuple[Condition, ...]

    @property
    def parts(self) -> tuple[Node, ...]:
        """The conditions, in order."""
        return self.of

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return all(parts), memory

    def __repr__(self) -> str:
        return f"({' & '.join(map(repr, self.of))})"


@dataclass(frozen=True)
class Any_(Condition):  # noqa: N801  # `Any` would hide typing's
    """At least one of several conditions; written ``a | b``."""

    of: tuple[Condition, ...]

    @property
    def parts(self) -> tuple[Node, ...]:
        """The conditions, in order."""
        return self.of

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return any(parts), memory

    def __repr__(self) -> str:
        return f"({' | '.join(map(repr, self.of))})"


@dataclass(frozen=True)
class Not(Condition):
    """The opposite of a condition; written ``~a``."""

    of: Condition

    @property
    def parts(self) -> tuple[Node, ...]:
        """The one condition."""
        return (self.of,)

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return not parts[0], memory

    def __repr__(self) -> str:
        return f"~{self.of!r}"


Result = TypeVar("Result")


@dataclass(frozen=True)
class Call(Generic[Result]):
    """A function of the world with its arguments, as a value that can be compared and checked."""

    function: Callable[..., Result]
    arguments: tuple[tuple[str, Any], ...]

    @classmethod
    def bind(
        cls, function: Callable[..., Result], args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> Call[Result]:
        """The call of a function with everything but its first argument, the world.

        Raises:
            TypeError: The arguments do not fit the function.
        """
        try:
            bound = signature(function).bind(None, *args, **kwargs)
        except TypeError as error:
            raise TypeError(f"{function.__name__}(): {error}") from None
        bound.apply_defaults()
        return cls(function, tuple(bound.arguments.items())[1:])

    def __call__(self, world: WorldView) -> Result:
        return self.function(world, **dict(self.arguments))

    def annotated(self) -> Iterator[Argument]:
        """The arguments with the annotations of the function's parameters."""
        hints = _hints(self.function)
        for name, value in self.arguments:
            yield Argument(name, value, hints.get(name, Any))

    def __repr__(self) -> str:
        inside = ", ".join(f"{name}={value!r}" for name, value in self.arguments)
        return f"{self.function.__name__}({inside})"


@dataclass(frozen=True)
class CustomCondition(Condition):
    """A condition made of a function by `condition`."""

    call: Call[bool]

    def holds(self, world: WorldView) -> bool:
        return self.call(world)

    def arguments(self) -> Iterator[Argument]:
        return self.call.annotated()

    def __repr__(self) -> str:
        return repr(self.call)


def condition(function: Callable[..., bool]) -> Callable[..., Condition]:
    """Make a condition of a function of the world.

    ::

        @condition
        def higher(world: WorldView, upper: BodyName, lower: BodyName) -> bool:
            return world.position(upper)[2] > world.position(lower)[2]


        success = higher("cube", "tray")

    Parameters annotated as `BodyName`, `RobotName` and so on are checked against the scene.
    """

    def make(*args: Any, **kwargs: Any) -> Condition:
        return CustomCondition(Call.bind(function, args, kwargs))

    make.__name__, make.__doc__ = function.__name__, function.__doc__
    return make


def walk(roots: tuple[Node, ...]) -> Iterator[Node]:
    """Every distinct node below the given ones, parts before what is made of them."""
    seen: dict[Node, None] = {}

    def visit(node: Node) -> None:
        if node in seen:
            return
        for part in node.parts:
            visit(part)
        seen[node] = None

    for root in roots:
        visit(root)
    yield from seen


@cache
def _hints(thing: Any) -> dict[str, Any]:
    return get_type_hints(thing, include_extras=True)


def _kinds(annotation: Any) -> Iterator[Kind]:
    """The kinds of name that an annotation mentions, however deep inside unions and tuples."""
    for argument in get_args(annotation):
        if isinstance(argument, Refers):
            yield argument.kind
        else:
            yield from _kinds(argument)


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from _texts(item)


def is_ours(function: Callable[..., Any]) -> bool:
    """Whether a function belongs to this package, and not to a description."""
    module: str | None = getattr(function, "__module__", None)
    return (module or "").startswith("taskbuilder.description.")


def _place_of(function: Callable[..., Any]) -> Location | None:
    """The line of a function's name, below its decorators."""
    code = getattr(function, "__code__", None)
    if code is None:
        return None
    first = code.co_firstlineno
    lines = linecache.getlines(code.co_filename)[first - 1 :]
    begun = (n for n, line in enumerate(lines, start=first) if line.lstrip().startswith("def "))
    return Location(Path(code.co_filename), next(begun, first), 1)


def _caller() -> Location | None:
    """Where, outside this package, the expression under construction was written."""
    frame: FrameType | None = sys._getframe(1)
    while frame and frame.f_globals.get("__name__", "").startswith("taskbuilder.description"):
        frame = frame.f_back
    if frame is None:
        return None
    code = frame.f_code
    positions = next(islice(code.co_positions(), frame.f_lasti // 2, None), None)
    line, _, column, _ = positions or (frame.f_lineno, None, None, None)
    return Location(Path(code.co_filename), line or 0, (column or 0) + 1)
