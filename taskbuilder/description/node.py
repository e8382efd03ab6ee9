"""The building blocks of descriptions: frozen expressions over names in the scene.

An expression is a value: it can be compared, hashed, printed and checked against the scene before
anything runs. Its memory during an episode is kept outside it (see `Referee`), so that two
environments never share memory.
"""

from __future__ import annotations

import reprlib
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from itertools import islice
from math import isnan
from pathlib import Path
from types import FrameType
from typing import Annotated, Any, ClassVar, NamedTuple, SupportsFloat, get_args, get_type_hints

from taskbuilder.description.origin import is_ours, place_of
from taskbuilder.description.view import WorldView
from taskbuilder.errors import Location, TaskbuilderError
from taskbuilder.schema.names import Kind, Refers, SceneNames

RobotName = Annotated[str, Refers("robot")]
ObjectName = Annotated[str, Refers("object")]
BodyName = Annotated[str, Refers("body")]
SolidName = Annotated[str, Refers("solid")]
FrameName = Annotated[str, Refers("frame")]
SiteName = Annotated[str, Refers("site")]
JointName = Annotated[str, Refers("joint")]
ContainerName = Annotated[str, Refers("container")]

Memory = Any
"""The memory of a node between control steps; an immutable value."""

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

    gathers: ClassVar[bool] = False
    """Whether it is made of many: each part in ``of`` stands for all members of a group in it."""

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
                return place_of(found) or self.origin
        function = _function_of(self)
        return (place_of(function) if function else None) or self.origin

    @property
    def has_own_code(self) -> bool:
        """Whether code of the description, and not only of this package, says its value."""
        methods = (
            getattr(type(self), name, None) for name in ("holds", "value", "start", "update")
        )
        return _function_of(self) is not None or any(m and not is_ours(m) for m in methods)

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
        """Pairs of bodies whose `WorldView.contact_force` it reads; only these are measured."""
        return iter(())

    def problems(self, names: SceneNames) -> Iterator[str]:
        """Problems with the node's own values, other than names and kinds."""
        return iter(())

    def arguments(self) -> Iterator[Argument]:
        """The values that the node was made of.

        Raises:
            NameError: An annotation names something that its file does not import.
        """
        if is_dataclass(self):
            hints = hints_of(type(self))
            for field in fields(self):
                yield Argument(field.name, getattr(self, field.name), hints[field.name])

    def references(self) -> Iterator[tuple[Kind, str]]:
        """Every name among the node's own arguments, with what it must stand for."""
        for argument in self.arguments():
            for kind in dict.fromkeys(kinds_of(argument.annotation)):
                yield from ((kind, name) for name in _texts(argument.value))


class ValueOfNodeError(TaskbuilderError, TypeError):
    """An expression returned an invalid value.

    Attributes:
        place: Where the code that returned it was written, or None.
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
    function = _function_of(node)
    return function.__name__ if function else type(node).__name__


def _function_of(node: Node) -> Callable[..., Any] | None:
    """What an expression of `taskbuilder.description.custom` was made of, or None."""
    return getattr(getattr(node, "call", None), "function", None)


class Blame(NamedTuple):
    """The parts of a condition that keep it from having the wanted value.

    Attributes:
        parts: Each part, with the value that it should have.
        every: Whether all of them must change, or any one of them would be enough.
    """

    parts: tuple[tuple[Condition, bool], ...]
    every: bool = True


class Condition(Node):
    """An expression that is true or false.

    Combine conditions with ``&`` (and), ``|`` (or) and ``~`` (not), or with conditions such as
    `All` and `Then`. Define your own conditions with the decorator `condition`, or as subclasses
    that are frozen dataclasses with a method ``holds``.
    """

    def holds(self, world: WorldView) -> bool:
        """Whether the condition is true now."""
        raise NotImplementedError

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        value = self.holds(world)
        return (value if value is True or value is False else self.truth(value)), memory

    def truth(self, value: Any) -> bool:
        """A value as a bool; numbers other than 0 are true.

        Raises:
            ValueOfNodeError: It is neither true nor false.
        """
        if isinstance(value, SupportsFloat):
            with suppress(TypeError, ValueError):  # as of an array of several
                if not isnan(value):
                    return bool(value)
        raise ValueOfNodeError(self, value, "a condition gives True or False")

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        """The figure that decides and the bound that is needed: "7 cm, within 5 cm is needed".

        It is called after an episode, and only if the condition does not have the wanted value.

        Args:
            world: The world in this state.
            memory: The memory after the last `update`.
            wanted: Whether the condition should hold.
        """
        return "does not hold" if wanted else "holds"

    def blamed(self, parts: Parts, memory: Memory, *, wanted: bool) -> Blame | None:
        """The parts to blame if it does not have the wanted value; None to use its `figure`.

        Args:
            parts: Values of the parts.
            memory: The memory after the last `update`.
            wanted: Whether the condition should hold.
        """
        return None

    def __and__(self, other: Condition) -> Condition:
        return AllOf(_flat(AllOf, self) + _flat(AllOf, other))

    def __or__(self, other: Condition) -> Condition:
        return AnyOf(_flat(AnyOf, self) + _flat(AnyOf, other))

    def __invert__(self) -> Condition:
        return Not(self)

    def __bool__(self) -> bool:
        # Python's `and`, `or` and `not` would drop an operand in silence.
        raise TypeError("a condition has no truth of its own; combine conditions by &, | and ~")


def _flat(sort: type[AllOf] | type[AnyOf], node: Condition) -> tuple[Condition, ...]:
    if not isinstance(node, Condition):
        raise TypeError(f"{node!r} is no condition; combine conditions with conditions")
    return node.of if isinstance(node, AllOf | AnyOf) and type(node) is sort else (node,)


def blame_those(of: tuple[Condition, ...], values: Parts, *, wanted: bool, every: bool) -> Blame:
    """Blame the conditions that do not have the wanted value."""
    wrong = [part for part, value in zip(of, values, strict=True) if bool(value) != wanted]
    return Blame(tuple((part, wanted) for part in wrong), every)


@dataclass(frozen=True)
class AllOf(Condition):
    """All of several conditions; written ``a & b``."""

    of: tuple[Condition, ...]

    @property
    def parts(self) -> tuple[Node, ...]:
        """The conditions, in order."""
        return self.of

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return all(parts), memory

    def blamed(self, parts: Parts, memory: Memory, *, wanted: bool) -> Blame | None:
        return blame_those(self.of, parts, wanted=wanted, every=wanted)

    def __repr__(self) -> str:
        return f"({' & '.join(map(repr, self.of))})"


@dataclass(frozen=True)
class AnyOf(Condition):  # `Any` would hide typing's
    """At least one of several conditions; written ``a | b``."""

    of: tuple[Condition, ...]

    @property
    def parts(self) -> tuple[Node, ...]:
        """The conditions, in order."""
        return self.of

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return any(parts), memory

    def blamed(self, parts: Parts, memory: Memory, *, wanted: bool) -> Blame | None:
        return blame_those(self.of, parts, wanted=wanted, every=not wanted)

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

    def blamed(self, parts: Parts, memory: Memory, *, wanted: bool) -> Blame | None:
        return Blame(((self.of, not wanted),))

    def __repr__(self) -> str:
        return f"~{self.of!r}"


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
def hints_of(thing: Any) -> dict[str, Any]:
    """The annotations of a class or function, with what they mark."""
    return get_type_hints(thing, include_extras=True)


def kinds_of(annotation: Any) -> Iterator[Kind]:
    """The kinds of name that an annotation mentions, however deep inside unions and tuples."""
    for argument in get_args(annotation):
        if isinstance(argument, Refers):
            yield argument.kind
        else:
            yield from kinds_of(argument)


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from _texts(item)


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
