"""Copies of environments, which build a world of their own and replay the episode so far.

A copy that shared the physics would move the original, and a forked process cannot step the
physics of its parent. So a copy is made from the task, the options, the seed of the episode and its
actions. If these do not lead to the current state, copying is refused.
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
    """The data that an environment is rebuilt from.

    Attributes:
        seed: Seed of its episode.
        actions: All actions of the episode; None before the first episode.
        noise: State of the generator of observation noise.
        fingerprint: Hash of the physical state, to compare the copy with.
    """

    seed: int
    actions: tuple[Actions, ...] | None
    noise: Mapping[str, Any]
    fingerprint: str


class Copyable:
    """An environment that is copied and pickled by replaying its episode."""

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
    """Attributes that are copied as usual: generators, spaces, and those set by users."""
    return {name: value for name, value in vars(env).items() if name not in _REBUILT}


def _recipe(env: Copyable) -> Recipe:
    """The recipe of an environment.

    Raises:
        UsageError: It is closed, or its actions do not lead to its state.
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
    """Rebuild an environment from its recipe.

    Raises:
        UsageError: Its state differs from that of the original.
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
    """A hash of the physical state and of the outcome."""
    return blake2b(repr(list(_moving(episode))).encode(), digest_size=16).hexdigest()


def _moving(episode: Episode) -> Iterator[Any]:
    world = episode.world
    yield world.time, world.quantities, episode.steps, episode.outcome.team
    bodies = [robot.body for robot in world.robots.values()]
    for body in (*bodies, *(thing.body for thing in world.objects.values())):
        yield body.pose(), body.velocity(), body.joint_states(tuple(range(len(body.joints))))
