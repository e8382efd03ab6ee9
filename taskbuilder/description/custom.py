"""Expressions made from functions of the world."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from inspect import signature
from typing import Any, Generic, TypeVar

from taskbuilder.description.node import Argument, Condition, hints_of
from taskbuilder.description.view import WorldView

Result = TypeVar("Result")


@dataclass(frozen=True)
class Call(Generic[Result]):
    """A function of the world with its arguments, as a comparable value."""

    function: Callable[..., Result]
    arguments: tuple[tuple[str, Any], ...]

    @classmethod
    def bind(
        cls, function: Callable[..., Result], args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> Call[Result]:
        """Bind the arguments of a function, except the first one, the world.

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
        hints = hints_of(self.function)
        for name, value in self.arguments:
            yield Argument(name, value, hints.get(name, Any))

    def __repr__(self) -> str:
        inside = ", ".join(f"{name}={value!r}" for name, value in self.arguments)
        return f"{self.function.__name__}({inside})"


@dataclass(frozen=True)
class CustomCondition(Condition):
    """A condition that `condition` made from a function."""

    call: Call[bool]

    def holds(self, world: WorldView) -> bool:
        return self.call(world)

    def arguments(self) -> Iterator[Argument]:
        return self.call.annotated()

    def __repr__(self) -> str:
        return repr(self.call)


def condition(function: Callable[..., bool]) -> Callable[..., Condition]:
    """Turn a function of the world into a condition.

    ::

        @condition
        def higher(world: WorldView, upper: BodyName, lower: BodyName) -> bool:
            return world.position(upper)[2] > world.position(lower)[2]


        success = higher("cube", "tray")

    Names that are passed to parameters with the annotations `BodyName`, `RobotName` and so on are
    checked against the scene.
    """

    def make(*args: Any, **kwargs: Any) -> Condition:
        return CustomCondition(Call.bind(function, args, kwargs))

    make.__name__, make.__doc__ = function.__name__, function.__doc__
    return make
