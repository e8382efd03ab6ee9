"""Training: collect, learn, evaluate, keep; and go on exactly after whatever ended it.

A run is cut into stretches by its checkpoints. At each cut all environments begin new episodes,
from seeds that follow from the run's own and the step. So nothing of the physics has to be kept,
and a run that goes on from a checkpoint is the same, to the bit, as one that was never stopped.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import flatdim
from numpy.typing import NDArray

from taskbuilder.env.vector import TaskVectorEnv, make_vec
from taskbuilder.errors import DivergenceError, UsageError
from taskbuilder.learn.algorithms import find_algorithm
from taskbuilder.learn.checkpoint_evaluator import Evaluation
from taskbuilder.learn.checkpoints import Checkpoint, Checkpoints
from taskbuilder.learn.collector import Collector, Finished
from taskbuilder.learn.demonstrations import load_demonstrations, transitions
from taskbuilder.learn.learner import Collection, Learner
from taskbuilder.learn.logger import RunLogger
from taskbuilder.learn.plan import Plan, make_settings
from taskbuilder.learn.policy import TrainedPolicy
from taskbuilder.learn.shapes import Shapes
from taskbuilder.learn.training_rewards import TRAINING_REWARDS
from taskbuilder.learn.wrappers import StartPrefix, TrainingWrappers
from taskbuilder.learn.zoo import POLICY_FILE, load_policy, save_policy
from taskbuilder.task import Task

INIT_FILE = "init.npz"
"""In a run's folder, the trained policy that it starts from."""

LOG_EVERY = 1_000
"""Control steps between rows about updates."""


@dataclass(frozen=True)
class TrainingStatus:
    """How a run stands, for whoever watches it.

    Attributes:
        step: Control steps so far.
        steps_per_second: Of this sitting.
        evaluation: The latest one, if it was made just now.
    """

    step: int
    steps_per_second: float
    evaluation: Evaluation | None = None


Evaluate = Callable[[TrainedPolicy], Evaluation]
Watch = Callable[[TrainingStatus], None]


def train(
    plan: Plan,
    task: Task,
    folder: Path,
    evaluate: Evaluate,
    about: Mapping[str, Any],
    watch: Watch = lambda _: None,
) -> None:
    """Train as planned, from the newest checkpoint in the run's folder if there is one.

    Args:
        plan: What to train and how.
        task: The plan's.
        folder: The run's; demonstrations and the policy to start from, if any, are there already.
        evaluate: Plays a policy in episodes of its own.
        about: What the policies' files say of themselves.
        watch: Told how the run stands, after each step of all environments.

    Raises:
        StoreError: Checkpoints are damaged, all of them.
        OSError: Something cannot be written; the newest checkpoint is still there.
        UsageError: An option does not fit the task.
    """
    torch.set_num_threads(1)  # small networks gain nothing by more, and results would depend on it
    with ExitStack() as stack:
        run = Trainer.prepare(plan, task, folder, stack)
        while not run.finished:
            for status in run.stretch():
                watch(status)
                if run.at_evaluation:
                    evaluation = evaluate(run.policy(about))
                    run.note(evaluation, run.policy(about))
                    watch(run.status(evaluation))
            run.save()


@dataclass
class Counters:
    """Where a run stands, beside what its learner has learned.

    Attributes:
        step: Control steps of all environments so far.
        episode: Episodes that have ended.
        best: Success rate of the policy that was kept.
        reached: Evaluations in a row that reached the rate to stop at.
        seconds: Of all sittings, evaluations included.
    """

    step: int = 0
    episode: int = 0
    best: float = -1.0
    reached: int = 0
    seconds: float = 0.0


class Trainer:
    """A training run under way; see `train`. Made by `prepare`."""

    def __init__(
        self,
        plan: Plan,
        folder: Path,
        learner: Learner,
        collector: Collector,
        collection: Collection,
    ) -> None:
        self._plan, self._folder = plan, folder
        self._learner, self._collector, self._collection = learner, collector, collection
        self._rng = np.random.default_rng(plan.seed)
        self._checkpoints = Checkpoints(folder)
        self._counters, lengths = Counters(), {}
        found = self._checkpoints.load(collection.memories)
        if found is not None:
            learner.load(found.arrays)
            kept = found.counters["counters"]
            self._counters = Counters(**{f.name: kept[f.name] for f in fields(Counters)})
            collection.load(kept)
            self._rng.bit_generator.state = found.counters["rng"]
            lengths = found.counters["lengths"]
        elif plan.init:
            learner.start_from(load_policy(str(folder / INIT_FILE)))
        self.logger = RunLogger(folder, lengths, self._counters.step)
        self._losses: dict[str, float] = {}
        self._since = (time.perf_counter(), self._counters.step)

    @classmethod
    def prepare(cls, plan: Plan, task: Task, folder: Path, stack: ExitStack) -> Trainer:
        """Make all that a run needs, as it was at its newest checkpoint.

        Args:
            plan: What to train and how.
            task: The plan's.
            folder: The run's.
            stack: Frees it again.

        Raises:
            UsageError: There is no such device.
        """
        if plan.device == "cuda" and not torch.cuda.is_available():
            raise UsageError("PyTorch finds no CUDA device here; leave --device cuda out")
        algorithm = find_algorithm(plan.algorithm)
        settings = make_settings(algorithm.settings, plan.settings)
        reward = TRAINING_REWARDS[plan.reward]
        options: dict[str, Any] = {**plan.env, "reward": reward.sharing}
        demonstrations = load_demonstrations(folder)
        ends = TrainingWrappers(reward.end_on_setback, reward.no_progress_timeout_s)
        prefixes = tuple(map(StartPrefix.before_success, demonstrations)) if plan.starts else ()
        wrap = replace(ends, start_prefixes=prefixes, start_share=plan.starts)
        envs = make_vec(task, plan.envs, plan.workers, wrap=wrap, **options)
        stack.enter_context(closing(envs))
        shapes = shapes_of(envs, reward.feature_count)
        learner = algorithm.learner(
            shapes,
            settings,
            shared_reward=reward.shared,
            seed=plan.seed,
            device=plan.device,
        )
        shown = None
        if plan.demos:
            with closing(make_vec(task, 1, wrap=ends, **options)) as env:
                own = reward(1, settings.discount)
                shown = transitions(demonstrations[: plan.demos], env, own, shapes)
        collection = algorithm.collection(learner, shapes.layout.width, plan.envs, shown)
        collector = Collector(envs, reward(plan.envs, settings.discount), shapes)
        trainer = cls(plan, folder, learner, collector, collection)
        stack.callback(trainer.close)
        return trainer

    # --- where it stands

    @property
    def finished(self) -> bool:
        """Whether all steps are taken, or success is as sure as was asked for."""
        return self._counters.step >= self._plan.steps or self._counters.reached >= 2

    @property
    def at_evaluation(self) -> bool:
        """Whether the policy is to be evaluated now."""
        every = self._plan.evaluate_every
        return self._passed(every) or self._counters.step >= self._plan.steps

    def _passed(self, every: int) -> bool:
        """Whether the last step of all environments reached or passed a multiple of a number."""
        return self._counters.step % every < self._plan.envs

    def status(self, evaluation: Evaluation | None = None) -> TrainingStatus:
        """How the run stands."""
        started, first = self._since
        rate = (self._counters.step - first) / max(time.perf_counter() - started, 1e-9)
        return TrainingStatus(self._counters.step, rate, evaluation)

    def policy(self, about: Mapping[str, Any]) -> TrainedPolicy:
        """The present policy."""
        return self._learner.policy({**about, "step": self._counters.step})

    # --- what it does

    def stretch(self) -> Iterator[TrainingStatus]:
        """Go on until a checkpoint is to be made, a step of all environments at a time.

        New episodes begin everywhere, from seeds that follow from the run's and the step.
        """
        entropy = np.random.SeedSequence((self._plan.seed, self._counters.step))
        self._collector.begin(int(entropy.generate_state(1)[0]))
        number = self._counters.step // self._plan.checkpoint_every
        due = False
        while not (self.finished or (due and self._collection.at_rest)):
            self._step()
            yield self.status()
            due = self._counters.step // self._plan.checkpoint_every > number

    def _step(self) -> None:
        """Let all environments take a step, and learn meanwhile or from it."""
        counters, plan, collection = self._counters, self._plan, self._collection
        collection.before_step(self._rng, counters.step)
        actions = self._learner.act(
            self._collector.observations, self._rng, self._progress_fraction
        )
        self._check_finite(actions)
        self._collector.step_async(actions)
        self._losses |= collection.during_step(self._rng, counters.step)
        rows, lost, finished = self._collector.step_wait()
        counters.step += plan.envs
        self._losses |= collection.after_step(rows, lost, self._rng, self._progress_fraction)
        self._log(finished)

    def _check_finite(self, actions: Mapping[str, NDArray[Any]]) -> None:
        """Refuse to go on with a learner that has diverged."""
        for agent, action in actions.items():
            if not np.isfinite(action).all():
                raise DivergenceError(
                    f"learning diverged: after {self._counters.step:,} control steps the actions "
                    f"of {agent} are not finite. Its logs and checkpoints are kept; begin anew "
                    "with a smaller lr, or with another seed"
                )

    @property
    def _progress_fraction(self) -> float:
        """Of the training that has been done."""
        return min(self._counters.step / self._plan.steps, 1.0)

    def _log(self, finished: Sequence[Finished]) -> None:
        counters = self._counters
        for episode in finished:
            counters.episode += 1
            row = {
                "episode": counters.episode,
                "steps": episode.steps,
                "success": int(episode.success),
                "stage": episode.stage,
                "team_return": episode.team_return,
                "training_return": episode.training_return,
            }
            terms = {f"term/{label}": pay for label, pay in episode.terms.items()}
            self.logger.add("episodes", counters.step, {**row, **terms})
        if self._losses and self._passed(LOG_EVERY):
            status = self.status()
            row = {"seconds": self._seconds(), "steps_per_second": status.steps_per_second}
            self.logger.add("updates", counters.step, {**row, **self._losses})

    def _seconds(self) -> float:
        return self._counters.seconds + time.perf_counter() - self._since[0]

    def note(self, evaluation: Evaluation, policy: TrainedPolicy) -> None:
        """Keep the result of an evaluation, and the policy if none before did better."""
        counters, plan = self._counters, self._plan
        row = {"episode": counters.episode, **evaluation.row}
        self.logger.add("evaluations", counters.step, row)
        if evaluation.success >= counters.best:
            counters.best = evaluation.success
            save_policy(self._folder / POLICY_FILE, policy)
        sure = plan.stop_at is not None and evaluation.success >= plan.stop_at
        counters.reached = counters.reached + 1 if sure else 0

    def save(self) -> None:
        """Make a checkpoint."""
        kept = {
            "counters": {
                **asdict(self._counters),
                "seconds": self._seconds(),
                **self._collection.counters(),
            },
            "rng": self._rng.bit_generator.state,
            "lengths": self.logger.lengths(),
        }
        checkpoint = Checkpoint(self._counters.step, self._learner.arrays(), kept)
        self._checkpoints.save(checkpoint, self._collection.memories)

    def close(self) -> None:
        """Finish the logs."""
        self.logger.close()


def shapes_of(envs: TaskVectorEnv, features: int) -> Shapes:
    """The sizes of what agents and critics observe, and of actions.

    Args:
        envs: The environments.
        features: Numbers that a training reward shows the critics besides.
    """
    observed: Any = envs.single_observation_space
    acted: Any = envs.single_action_space
    sizes = [{agent: flatdim(space[agent]) for agent in envs.agents} for space in (observed, acted)]
    return Shapes(sizes[0], sizes[1], flatdim(envs.state_space) + features)
