"""Observation channels of other packages: the class that they derive from, and its use."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from inspect import isabstract
from typing import TYPE_CHECKING, ClassVar

from taskbuilder.extensions import CHANNELS, ForeignPart
from taskbuilder.schema.channels import Channel
from taskbuilder.world.world import World

if TYPE_CHECKING:
    from taskbuilder.env.episode import Episode


@dataclass(frozen=True)
class ChannelReader(ABC):
    """Reads a channel of numbers that another package adds.

    Attributes:
        meaning: What the channel is, in a few words with the unit, as `taskbuilder explain` shows.
        world: The world, for the number of joints and the like.
        subject: The robot, object or frame; "" for a channel of the episode.
        frame: The frame after ``in``: "world", or a dotted name.
    """

    meaning: ClassVar[str]
    world: World
    subject: str
    frame: str

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """Name of each number, without that of the subject."""

    @property
    @abstractmethod
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number; values are clipped to them."""

    @abstractmethod
    def read(self, episode: Episode) -> Sequence[float]:
        """The current values. ``episode.world`` is the world of the episode."""


@dataclass(frozen=True)
class ForeignChannel:
    """A channel of another package, whose values are checked.

    Attributes:
        names: Name of each number, such as ``left.manipulability``.
        bounds: Lower and upper bound of each number.
    """

    names: tuple[str, ...]
    bounds: tuple[tuple[float, float], ...]
    _part: ForeignPart
    _reader: ChannelReader

    @classmethod
    def of(cls, channel: Channel, world: World) -> ForeignChannel:
        """Make the reader of a channel.

        Raises:
            ExtensionError: It cannot be made, or its names and bounds do not fit each other.
        """
        part, kind = find_reader(channel.added)
        with part.at_work():
            reader = kind(world, channel.subject, channel.frame)
            names, bounds = tuple(reader.names), tuple(reader.bounds)
        if not names or len(names) != len(bounds):
            raise part.error(f"has {len(names)} names for {len(bounds)} pairs of bounds")
        for bound in bounds:
            if len(bound) != 2 or not all(map(math.isfinite, bound)) or bound[0] > bound[1]:
                raise part.error(f"has the bounds {bound}; two finite numbers, low <= high")
        before = f"{channel.subject}." if channel.subject else ""
        return cls(tuple(f"{before}{name}" for name in names), bounds, part, reader)

    def read(self, episode: Episode) -> Sequence[float]:
        """The current values.

        Raises:
            ExtensionError: The package's code failed, or returned something else than one finite
                number for each name.
        """
        with self._part.at_work():
            values = [float(value) for value in self._reader.read(episode)]
        if len(values) != len(self.names) or not all(map(math.isfinite, values)):
            raise self._part.error(
                f"reads {values}, where {len(self.names)} finite numbers are needed"
            )
        return values


def find_reader(name: str) -> tuple[ForeignPart, type[ChannelReader]]:
    """The reader that a package declares under a name such as ``robot.manipulability``.

    Raises:
        UnknownNameError: There is none.
        ExtensionError: It cannot be used.
    """
    part = CHANNELS.part(name)
    if part is None:
        raise ValueError(f"{name} is no other package's")
    return part, load_reader(part)


def load_reader(part: ForeignPart) -> type[ChannelReader]:
    """The reader that a package declares.

    Raises:
        ExtensionError: It cannot be used.
    """
    reader: type[ChannelReader] = part.load(_no_reader)
    return reader


def _no_reader(part: object) -> str | None:
    if not (isinstance(part, type) and issubclass(part, ChannelReader)):
        return "is no subclass of taskbuilder.env.foreign_channels.ChannelReader"
    if isabstract(part):
        return f"lacks {', '.join(sorted(part.__abstractmethods__))}"
    if not isinstance(getattr(part, "meaning", None), str):
        return "has no `meaning`, a text"
    return None
