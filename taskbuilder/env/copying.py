"""Copies of environments, which build a world of their own and replay the episode so far.

A copy that shared the physics would move the original. So a copy is made from the task, the
options and a saved state, whose actions are played again. If these do not lead to the current
state, copying is refused. A forked process may not step the physics of its parent, but it may copy
an environment of its parent, as SuperSuit's processes do.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from copy import deepcopy
from typing import TYPE_CHECKING, Any, Self, TypeVar

from taskbuilder.description.load import load_description
from taskbuilder.env.episode import Episode
from taskbuilder.env.episode_state import EpisodeState
from taskbuilder.env.observing import Observer
from taskbuilder.env.options import Options
from taskbuilder.errors import FileError, UsageError
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.task import Task

Env = TypeVar("Env", bound="Copyable")

_REBUILT = ("task", "options", "episode", "_observer")


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
        packed = pickle.dumps((self.task, self.options, _state(self)))
        return _unpacked, (type(self), self.task.file.entry, packed, _rest(self))

    def __copy__(self) -> Self:
        return deepcopy(self)

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        state, rest = _state(self), deepcopy(_rest(self), memo)
        made = _rebuilt(type(self), self.task, self.options, state, rest)
        memo[id(self)] = made
        return made


def _rest(env: Copyable) -> dict[str, Any]:
    """Attributes that are copied as usual: generators, spaces, and those set by users."""
    return {name: value for name, value in vars(env).items() if name not in _REBUILT}


def _state(env: Copyable) -> EpisodeState | None:
    """The state of an environment's episode; None before the first reset.

    Raises:
        UsageError: The environment is closed, or its physics diverged.
    """
    episode = env.episode
    if episode.closed:
        raise UsageError("this environment is closed; make another")
    if episode.exploded:
        raise UsageError("an environment whose physics diverged; reset it first")
    return episode.save(snapshot=False) if episode.begun else None


def _unpacked(kind: type[Env], entry: CatalogueEntry, packed: bytes, rest: dict[str, Any]) -> Env:
    try:
        load_description(entry)
        task, options, state = pickle.loads(packed)  # noqa: S301  # as whatever this is a part of
    except (FileError, ImportError, AttributeError) as error:
        what = f"{entry.name} has changed since this copy was made; make it anew"
        raise UsageError(what) from error
    return _rebuilt(kind, task, options, state, rest)


def _rebuilt(
    kind: type[Env], task: Task, options: Options, state: EpisodeState | None, rest: dict[str, Any]
) -> Env:
    """Rebuild an environment.

    Raises:
        UsageError: Its actions do not lead to its state.
    """
    env = kind.__new__(kind)
    vars(env).update(rest, task=task, options=options, episode=Episode(task, options))
    env._observer = Observer(task, options, env.episode.world)
    if state is not None:
        try:
            env.episode.load(state)
        except UsageError:
            env.episode.close()
            raise
    return env
