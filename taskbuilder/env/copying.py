"""Copies of environments: each builds a world of its own, and plays what has been played so far.

A copy that shared the physics would move the original, and a process that was forked off has the
numbers of a physics that it cannot step. So a copy is what leads to it: task, options, the seed of
the episode and its actions. What they do not lead to is refused.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from hashlib import blake2b
from typing import TYPE_CHECKING, Any, Self, TypeVar

from taskbuilder.description.load import load_description
from taskbuilder.env.episode import Actions, Episode
from taskbuilder.env.observing import Observer
from taskbuilder.env.options import Options
from taskbuilder.errors import FileError, UsageError
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.task import Task

Env = TypeVar("Env", bound="Copyable")

_REBUILT = ("task", "options", "episode", "_observer")


@dataclass(frozen=True)
class Recipe:
    """What leads to an environment as it stands.

    Attributes:
        seed: Of its episode.
        actions: What all agents did in it; None before the first episode.
        noise: State of the generator of noise.
        fingerprint: Of all that moves, to compare the copy with.
    """

    seed: int
    actions: tuple[Actions, ...] | None
    noise: Mapping[str, Any]
    fingerprint: str


class Copyable:
    """An environment that is copied and pickled by what led to it."""

    if TYPE_CHECKING:
        task: Task
        options: Options
        episode: Episode
        _observer: Observer

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        # The entry comes first: with it the description is imported under the name by which the
        # task then refers to it, wherever this is read.
        packed = pickle.dumps((self.task, self.options))
        return _unpacked, (type(self), self.task.file.entry, packed, _recipe(self), _rest(self))

    def __copy__(self) -> Self:
        return deepcopy(self)

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        recipe, rest = _recipe(self), deepcopy(_rest(self), memo)
        made = _rebuilt(type(self), self.task, self.options, recipe, rest)
        memo[id(self)] = made
        return made


def _rest(env: Copyable) -> dict[str, Any]:
    """Attributes that are copied as they are: generators, spaces, and what others have set."""
    return {name: value for name, value in vars(env).items() if name not in _REBUILT}


def _recipe(env: Copyable) -> Recipe:
    """What leads to an environment.

    Raises:
        UsageError: It is closed, or stands where its actions do not lead to.
    """
    episode = env.episode
    episode.check_usable()
    if episode.exploded:
        raise UsageError("an environment whose physics diverged; reset it first")
    taken = episode.taken
    if taken is None:
        what = "an environment that went back to a saved state"
        raise UsageError(f"{what}; copy it before, or after its next reset")
    noise = episode.noise_rng.bit_generator.state
    if not episode.begun:
        return Recipe(0, None, noise, "")
    return Recipe(episode.seed, tuple(taken), noise, _fingerprint(episode))


def _unpacked(
    kind: type[Env], entry: CatalogueEntry, packed: bytes, recipe: Recipe, rest: dict[str, Any]
) -> Env:
    try:
        load_description(entry)
        task, options = pickle.loads(packed)  # noqa: S301  # as whatever this is a part of
    except (FileError, ImportError, AttributeError) as error:
        what = f"{entry.name} has changed since this copy was made; make it anew"
        raise UsageError(what) from error
    return _rebuilt(kind, task, options, recipe, rest)


def _rebuilt(
    kind: type[Env], task: Task, options: Options, recipe: Recipe, rest: dict[str, Any]
) -> Env:
    """The environment that a recipe leads to.

    Raises:
        UsageError: It is another one than the original was.
    """
    env = kind.__new__(kind)
    vars(env).update(rest, task=task, options=options, episode=Episode(task, options))
    episode = env.episode
    env._observer = Observer(task, options, episode.world)
    if recipe.actions is not None:
        episode.reset(recipe.seed)
        for actions in recipe.actions:
            episode.step(actions)
        if episode.exploded or _fingerprint(episode) != recipe.fingerprint:
            episode.close()
            raise UsageError(
                "an environment that was changed by more than its actions; copy it after its "
                "next reset (other processors calculate otherwise, too)"
            )
    episode.noise_rng.bit_generator.state = recipe.noise
    return env


def _fingerprint(episode: Episode) -> str:
    """A hash of all that moves, and of what it was worth."""
    return blake2b(repr(list(_moving(episode))).encode(), digest_size=16).hexdigest()


def _moving(episode: Episode) -> Iterator[Any]:
    world = episode.world
    yield world.time, world.quantities, episode.steps, episode.outcome.team
    bodies = [robot.body for robot in world.robots.values()]
    for body in (*bodies, *(thing.body for thing in world.objects.values())):
        yield body.pose(), body.velocity(), body.joint_states(tuple(range(len(body.joints))))
