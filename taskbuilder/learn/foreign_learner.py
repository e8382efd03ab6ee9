"""Learners of other packages: what they return is checked, and their errors name the package."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import wraps
from typing import Any

import numpy as np

from taskbuilder.extensions import ForeignPart
from taskbuilder.learn.learner import Algorithm, collects
from taskbuilder.learn.shapes import Shapes
from taskbuilder.policies.trained import Array32


@dataclass(frozen=True)
class ForeignLearner:
    """A learner of another package.

    Attributes:
        part: Where it comes from.
        learner: The learner itself.
        action_sizes: Numbers of an action by agent; none for learners from data.
    """

    part: ForeignPart
    learner: Any
    action_sizes: Mapping[str, int]

    def act(
        self,
        observations: Mapping[str, Array32],
        rng: np.random.Generator,
        progress_fraction: float,
    ) -> dict[str, Array32]:
        """Exploratory actions, of the right shape and finite; see `Learner.act`."""
        act = self.__getattr__("act")
        actions: dict[str, Array32] = act(observations, rng, progress_fraction)
        for agent, size in self.action_sizes.items():
            wanted = (len(observations[agent]), size)
            returned = np.asarray(actions.get(agent, ()))
            which = f"actions of {agent} from `act`"
            if returned.shape != wanted:
                raise self.part.error(f"returns {which} of shape {returned.shape}, not {wanted}")
            if not np.isfinite(returned).all():
                raise self.part.error(f"returns {which} that are not finite")
        return actions

    def __getattr__(self, name: str) -> Any:
        """What the learner has; its methods name the package in errors of its code."""
        if name.startswith("__"):
            raise AttributeError(name)
        if not hasattr(self.learner, name):
            raise self.part.error(f"makes a learner without `{name}`")
        value = getattr(self.learner, name)
        return _guarded(self.part, value) if callable(value) else value


def load_algorithm(part: ForeignPart) -> Algorithm:
    """The algorithm of another package, whose learners name the package in their errors.

    Raises:
        ExtensionError: It cannot be used.
    """
    algorithm: Algorithm = part.load(_problem_of_algorithm)

    @wraps(algorithm.learner)
    def make(source: Any, settings: Any, **more: Any) -> ForeignLearner:
        with part.at_work():
            learner = algorithm.learner(source, settings, **more)
        sizes = source.actions if isinstance(source, Shapes) else {}
        return ForeignLearner(part, learner, sizes)

    return replace(algorithm, learner=make)


def _problem_of_algorithm(part: object) -> str | None:
    """What is wrong with what a package declares as an algorithm, or None."""
    if not isinstance(part, Algorithm):
        return "is no object of taskbuilder.learn.learner.Algorithm"
    if not is_dataclass(part.settings):
        return "has settings that are no dataclass"
    if not part.from_data and not collects(part):
        return (
            "has no `collection`; give it OnPolicy of taskbuilder.learn.on_policy or OffPolicy of "
            "taskbuilder.learn.off_policy, or from_data=True"
        )
    has = {field.name for field in fields(part.settings)}
    needed = () if part.from_data else ("discount", *getattr(part.collection, "needs", ()))
    missing = [name for name in needed if name not in has and not hasattr(part.settings, name)]
    if missing:
        return f"has settings without {', '.join(missing)}, which its collection needs"
    return None


def _guarded(part: ForeignPart, method: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(method)
    def guarded(*arguments: Any, **more: Any) -> Any:
        with part.at_work():
            return method(*arguments, **more)

    return guarded
