"""Converters and actions: what the words of a command line mean, or why they mean nothing."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from taskbuilder.errors import UnknownNameError
from taskbuilder.extensions import Door, ForeignPart


class StoreOnce(argparse.Action):
    """Stores the value of an option; a second use with another value is a mistake."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Store the value of a use."""
        del parser
        given = getattr(namespace, "given", {})
        if option_string and given.get(self.dest, values) != values:
            was = given[self.dest]
            wrong = f"given twice, as {was} and {values}; give it once"
            raise argparse.ArgumentError(self, wrong)
        namespace.given = {**given, self.dest: values}
        setattr(namespace, self.dest, values)


class Extend(argparse.Action):
    """Collects the values of every use of an option; the default counts if there is none."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Add the values of one use."""
        del parser, option_string
        before = getattr(namespace, self.dest)
        given = [] if before is self.default else before
        setattr(namespace, self.dest, [*given, *values])


def whole(least: int, most: int) -> Any:
    """A converter for whole numbers in a range."""

    def convert(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f'"{text}" is no whole number') from None
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{value} is not from {least} to {most}")
        return value

    return convert


@dataclass(frozen=True)
class PartName:
    """A converter for one of the library's own names, or of those that installed packages add.

    Attributes:
        own: The library's own names.
        door: What packages can add.
    """

    own: tuple[str, ...]
    door: Door

    def __call__(self, text: str) -> str:
        """The name, if there is such a part."""
        try:
            self.door.part(text, self.own)
        except UnknownNameError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
        return text

    def added(self) -> Iterator[ForeignPart]:
        """The parts that installed packages add."""
        for name in self.door.names(self.own)[len(self.own) :]:
            yield from self.door.declared()[name]


def listed_choices(names: Sequence[str]) -> str:
    """The library's own names, as helps show them."""
    return f"{{{','.join(names)}}}"


def count_or_folder(text: str) -> int | str:
    """A converter for a number of episodes, or the folder of a data set."""
    number: int | str = whole(0, 100_000)(text) if re.fullmatch(r"[+-]?\d+", text) else text
    return number


def variation(text: str) -> int | str:
    """A converter for the number of a variation, or "random"."""
    number: int | str = text if text == "random" else whole(0, 10_000)(text)
    return number


def any_variation(text: str) -> int | str:
    """A converter for the number of a variation, "random" or "all"."""
    return text if text == "all" else variation(text)


def size(text: str) -> tuple[int, int]:
    """A converter for WIDTHxHEIGHT."""
    match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if not match:
        raise argparse.ArgumentTypeError(f'"{text}" is no size; write WxH, such as 640x480')
    width, height = int(match[1]), int(match[2])
    if not (16 <= width <= 2048 and 16 <= height <= 2048):
        raise argparse.ArgumentTypeError(f"{text} is not from 16x16 to 2048x2048")
    return width, height


def robot_choice(text: str) -> tuple[str, str]:
    """A converter for ROBOT=MODEL."""
    name, equals, model = text.partition("=")
    if not (name and equals and model):
        wrong = f'"{text}" names no model for a robot; write left=panda'
        raise argparse.ArgumentTypeError(wrong)
    return name, model


def number(least: float, most: float) -> Any:
    """A converter for numbers in a range."""

    def convert(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f'"{text}" is no number') from None
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{text} is not from {least:g} to {most:g}")
        return value

    return convert


share = number(0.0, 1.0)
"""A converter for numbers from 0 to 1."""


def side_or_size(text: str) -> tuple[int, int]:
    """A converter for WIDTHxHEIGHT, or the side of a square."""
    if "x" in text:
        return size(text)
    side = whole(16, 2048)(text)
    return side, side


def listed(text: str) -> tuple[str, ...]:
    """A converter for names separated by commas; each counts once."""
    return tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))


def variation_or_all(text: str) -> int | str:
    """A converter for the number of a variation, or "all"."""
    number: int | str = text if text == "all" else whole(0, 10_000)(text)
    return number
