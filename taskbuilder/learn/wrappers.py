"""Training wrappers: episodes that end early, or begin in the middle of recorded ones.

Wrappers change the episodes that a learner trains on, and not the task: evaluations do not use
them. `TrainingWrappers` applies several of them, also to environments in workers of `make_vec`:

    wrappers = TrainingWrappers(end_on_setback=True, no_progress_timeout_s=1.5)
    envs = taskbuilder.make_vec("handover", 8, workers=2, wrap=wrappers)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pettingzoo.utils.wrappers import BaseParallelWrapper

from taskbuilder.env.parallel import Infos, TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.expert.ladder.ladder import StageLadder
from taskbuilder.learn.demonstration import Demonstration
from taskbuilder.rollout.progress import LEAST_RISE, ProgressCount, ProgressRange
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.choices import LadderChoice
from taskbuilder.world.randomness import EpisodeRandomness

Returned = tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], Infos]
"""The result of a step: observations, rewards, terminations, truncations and infos."""

LEAST_RAW_RISE = 0.05
"""The minimum rise of a description's own progress that restarts the time without progress."""

STEPS_WITHOUT_PROGRESS = "steps_without_progress"
"""Key of the info that `NoProgressTimeout` adds."""

TRAINING_PROGRESS = "training_progress"
"""Key of the info that `TrainingProgress` adds."""


class EpisodeWrapper(BaseParallelWrapper):  # type: ignore[misc]  # pettingzoo ships no types
    """The base class of wrappers around a `TaskEnv` or another wrapper.

    Subclasses with state of their own override `save` and `load`, so that `save_state` and
    `load_state` include it.
    """

    def save(self) -> Any:
        """The state of the wrapper itself."""
        return None

    def load(self, kept: Any) -> None:
        """Restore the state that `save` returned."""

    def save_state(self) -> tuple[Any, Any]:
        """Save the state of the environment and of the wrapper; see `TaskEnv.save_state`."""
        return self.env.save_state(), self.save()

    def load_state(self, state: tuple[Any, Any]) -> Any:
        """Restore a saved state of this environment; see `TaskEnv.load_state`."""
        inner, kept = state
        self.load(kept)
        return self.env.load_state(inner)

    def end_episode(self) -> None:
        """End the episode, so that the next call must be a reset."""
        self.unwrapped.agents = []


class EndOnSetback(EpisodeWrapper):
    """Terminates episodes when the description's ``setback`` holds."""

    def step(self, actions: Mapping[str, Any]) -> Returned:
        """Step the environment; see `TaskEnv.step`."""
        observations, rewards, terminations, truncations, infos = self.env.step(actions)
        info = next(iter(infos.values()))
        if info["condition/setback"]:
            terminations = dict.fromkeys(terminations, True)
            truncations = dict.fromkeys(truncations, False)
            self.end_episode()
        return observations, rewards, terminations, truncations, infos


class TrainingProgress(EpisodeWrapper):
    """Adds the progress that training sees to the infos, as ``training_progress``, from 0 to 1.

    Args:
        env: The environment, wrapped or not.
        ladder: ``task`` for the description's progress, or ``expert`` for the ladder that is made
            from the expert's stages; see `StageLadder`.
        range_: For ``task``: the values of the progress that are mapped to 0 and to 1.

    Raises:
        UsageError: The task has no expert to make a ladder from, or the range is empty.
    """

    def __init__(
        self, env: Any, ladder: LadderChoice, range_: tuple[float, float] | None = None
    ) -> None:
        super().__init__(env)
        if ladder == "task" and not (range_ and range_[0] < range_[1]):
            raise UsageError(f"the range of progress is {range_}; two numbers, the lower one first")
        self._range = ProgressRange(*range_) if range_ else None
        self._stages = StageLadder(env.unwrapped) if ladder == "expert" else None

    @property
    def info_keys(self) -> tuple[str, ...]:
        """Keys of every agent's info."""
        return (*self.env.info_keys, TRAINING_PROGRESS)

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], Infos]:
        """Reset the environment."""
        observations, infos = self.env.reset(seed=seed, options=options)
        if self._stages is not None:
            self._stages.begin()
        return observations, self._with_progress(infos)

    def step(self, actions: Mapping[str, Any]) -> Returned:
        """Step the environment; see `TaskEnv.step`."""
        observations, rewards, terminations, truncations, infos = self.env.step(actions)
        if self._stages is not None:
            self._stages.advance()
        return observations, rewards, terminations, truncations, self._with_progress(infos)

    def _with_progress(self, infos: Infos) -> Infos:
        raw = next(iter(infos.values()))["progress"]
        now = self._stages.value if self._stages else self._range.share(raw) if self._range else 0.0
        return {agent: {**info, TRAINING_PROGRESS: now} for agent, info in infos.items()}

    def save(self) -> Any:
        """The position in the expert's stages, if they are the ladder."""
        return self._stages.position if self._stages is not None else None

    def load(self, kept: Any) -> None:
        """Restore the state that `save` returned."""
        if self._stages is not None:
            self._stages.position = kept


class NoProgressTimeout(EpisodeWrapper):
    """Truncates episodes in which the progress has not risen for some time.

    The time does not run while success holds. Infos have ``steps_without_progress``, in control
    steps. The progress is that of `TrainingProgress`, if the environment is wrapped in it, and has
    to rise by 1/300; otherwise it is that of the description, and has to rise by 0.05.

    Args:
        env: The environment, wrapped or not.
        seconds: Maximum time without progress, in episode time.

    Raises:
        UsageError: The time is not positive.
    """

    def __init__(self, env: Any, seconds: float) -> None:
        super().__init__(env)
        if not seconds > 0.0:
            raise UsageError(f"no_progress_timeout_s is {seconds}; seconds, more than 0")
        self._limit = seconds * env.metadata["render_fps"]
        normalized = TRAINING_PROGRESS in env.info_keys
        self._key = TRAINING_PROGRESS if normalized else "progress"
        self._rise = LEAST_RISE if normalized else LEAST_RAW_RISE
        self._count = ProgressCount()

    @property
    def info_keys(self) -> tuple[str, ...]:
        """Keys of every agent's info."""
        return (*self.env.info_keys, STEPS_WITHOUT_PROGRESS)

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], Infos]:
        """Reset the environment."""
        observations, infos = self.env.reset(seed=seed, options=options)
        self._count = ProgressCount(next(iter(infos.values()))[self._key])
        return observations, self._with_steps(infos)

    def step(self, actions: Mapping[str, Any]) -> Returned:
        """Step the environment; see `TaskEnv.step`."""
        observations, rewards, terminations, truncations, infos = self.env.step(actions)
        info = next(iter(infos.values()))
        if not info["exploded"]:
            won = info["success"] > 0.0
            self._count = self._count.after(info[self._key], success=won, rise=self._rise)
        if self._count.steps >= self._limit and not any(terminations.values()):
            truncations = dict.fromkeys(truncations, True)
            self.end_episode()
        return observations, rewards, terminations, truncations, self._with_steps(infos)

    def _with_steps(self, infos: Infos) -> Infos:
        steps = float(self._count.steps)
        return {agent: {**info, STEPS_WITHOUT_PROGRESS: steps} for agent, info in infos.items()}

    def save(self) -> ProgressCount:
        """The highest progress, and the control steps since it rose."""
        return self._count

    def load(self, kept: ProgressCount) -> None:
        """Restore the state that `save` returned."""
        self._count = kept


@dataclass(frozen=True)
class StartPrefix:
    """The first steps of a recorded episode, after any of which a training episode may begin.

    Attributes:
        seed: Seed of the recorded episode.
        actions: Recorded actions of every agent: (steps, n) each.
    """

    seed: int
    actions: Mapping[str, NDArray[np.float32]]

    @property
    def steps(self) -> int:
        """Its length in control steps."""
        return min(len(actions) for actions in self.actions.values())

    @classmethod
    def before_success(cls, episode: Rollout | Demonstration) -> StartPrefix:
        """The part of an episode before its success."""
        first = episode.first_success or 0
        end = first - 1 if first > 1 else None
        return cls(episode.seed, {agent: values[:end] for agent, values in episode.actions.items()})


class StartPrefixes(EpisodeWrapper):
    """Begins a fraction of the episodes in the middle of recorded ones, with the remaining time.

    Args:
        env: The environment, wrapped or not, in the variation of the recording.
        prefixes: Recorded prefixes; an episode begins after a random step of a random one.
        share: Fraction of the episodes that do, from 0 to 1.

    Raises:
        UsageError: The share is not in this range, or the environment draws its variation.
    """

    def __init__(self, env: Any, prefixes: Sequence[StartPrefix], share: float) -> None:
        super().__init__(env)
        if not 0.0 <= share <= 1.0:
            raise UsageError(f"start_share is {share}; 0 to 1")
        if env.options.variation == "random":
            raise UsageError("start_prefixes belong to one variation; variation is random")
        self._prefixes, self._share = tuple(prefixes), share
        self._seeds = np.random.default_rng()

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], Infos]:
        """Reset the environment, or begin in the middle of a recorded episode; the seed decides."""
        if seed is not None:
            self._seeds = np.random.default_rng(seed)
        own = seed if seed is not None else int(self._seeds.integers(2**31))
        rng = EpisodeRandomness(own).start()
        if self._prefixes and rng.random() < self._share:
            prefix = self._prefixes[rng.integers(len(self._prefixes))]
            begun = self._play(prefix, int(rng.integers(1, prefix.steps + 1)), own)
            if begun is not None:
                return begun
        started: tuple[dict[str, Any], Infos] = self.env.reset(seed=own, options=options)
        return started

    def _play(
        self, prefix: StartPrefix, steps: int, seed: int
    ) -> tuple[dict[str, Any], Infos] | None:
        """Play the first steps of a recorded episode; None if the episode ends with them."""
        _, infos = self.env.reset(seed=prefix.seed)
        for step in range(steps):
            actions = {agent: values[step] for agent, values in prefix.actions.items()}
            *_, after = self.env.step(actions)
            infos = {agent: info | after[agent] for agent, info in infos.items()}
            if not self.env.agents:  # recorded with other options, or up to its last step
                return None
        env: TaskEnv = self.unwrapped
        env.episode.noise_rng = EpisodeRandomness(seed).noise()  # noise differs between episodes
        return env.observe(), infos

    def save(self) -> Any:
        """The state of the generator of seeds."""
        return self._seeds.bit_generator.state

    def load(self, kept: Any) -> None:
        """Restore the state that `save` returned."""
        self._seeds.bit_generator.state = kept


@dataclass(frozen=True)
class TrainingWrappers:
    """The wrappers of a training run; calling this applies them to an environment.

    Attributes:
        end_on_setback: Terminate episodes on a setback.
        no_progress_timeout_s: Truncate episodes after this time without progress; None for never.
        start_prefixes: Recorded prefixes that episodes may begin after.
        start_share: Fraction of the episodes that do.
        ladder: Where the progress comes from that training sees; None for the
            unscaled progress of the description.
        progress_range: The values of the description's progress that are mapped to 0 and to 1.
    """

    end_on_setback: bool = False
    no_progress_timeout_s: float | None = None
    start_prefixes: tuple[StartPrefix, ...] = ()
    start_share: float = 0.0
    ladder: LadderChoice | None = None
    progress_range: tuple[float, float] | None = None

    def __call__(self, env: TaskEnv) -> Any:
        """Wrap an environment."""
        wrapped: Any = env
        if self.end_on_setback:
            wrapped = EndOnSetback(wrapped)
        if self.ladder is not None:
            wrapped = TrainingProgress(wrapped, self.ladder, self.progress_range)
        if self.no_progress_timeout_s is not None:
            wrapped = NoProgressTimeout(wrapped, self.no_progress_timeout_s)
        if self.start_prefixes:
            wrapped = StartPrefixes(wrapped, self.start_prefixes, self.start_share)
        return wrapped
