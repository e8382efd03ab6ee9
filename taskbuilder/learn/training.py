"""The training loop: collect, learn, evaluate and save, with exact resuming.

Checkpoints divide a run into stretches. At each checkpoint all environments are reset, with seeds
that depend on the run's seed and the step. So no physics state has to be saved, and a run that is
resumed from a checkpoint is the same, to the bit, as one that was never stopped.
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

from taskbuilder.data.dataset import Dataset
from taskbuilder.env.vector import TaskVectorEnv, make_vec
from taskbuilder.errors import UsageError
from taskbuilder.learn.algorithms import find_algorithm
from taskbuilder.learn.checkpoint_evaluator import Evaluation
from taskbuilder.learn.checkpoints import Checkpoint, Checkpoints
from taskbuilder.learn.collector import Collector, Finished
from taskbuilder.learn.demonstration import Demonstration
from taskbuilder.learn.demonstrations import load_demonstrations, transitions
from taskbuilder.learn.learner import Trainable
from taskbuilder.learn.logger import RunLogger
from taskbuilder.learn.n_step import NStepTransitions
from taskbuilder.learn.plan import Plan
from taskbuilder.learn.practice import Batches, Interaction, Practice
from taskbuilder.learn.recordings import read_demonstrations, recorded_demonstrations
from taskbuilder.learn.replayed import Replayer
from taskbuilder.learn.run_folders import INIT_FILE
from taskbuilder.learn.run_setup import RunSetup
from taskbuilder.learn.settings import make_settings
from taskbuilder.learn.shapes import Shapes
from taskbuilder.learn.training_rewards import RAW_REWARDS, TRAINING_REWARDS
from taskbuilder.learn.wrappers import StartPrefix, TrainingWrappers
from taskbuilder.policies.trained import TrainedPolicy
from taskbuilder.policies.zoo import POLICY_FILE, load_policy, save_policy

LOG_EVERY = 1_000
"""Control steps between rows of the table of updates."""


@dataclass(frozen=True)
class TrainingStatus:
    """The status of a run, for progress displays.

    Attributes:
        step: Control steps so far.
        steps_per_second: Speed since the run was started or resumed.
        evaluation: The latest evaluation, if it was made at this step.
    """

    step: int
    steps_per_second: float
    evaluation: Evaluation | None = None


Evaluate = Callable[[TrainedPolicy], Evaluation]
OnStatus = Callable[[TrainingStatus], None]
"""Called with the status of a run after each step of all environments."""


def train(
    run: RunSetup,
    folder: Path,
    evaluate: Evaluate,
    about: Mapping[str, Any],
    watch: OnStatus = lambda _: None,
) -> None:
    """Train from the newest checkpoint in the run's folder, or from the start.

    Args:
        run: What the run works with.
        folder: Folder of the run, with the demonstrations and the initial policy if there are any.
        evaluate: Evaluates a policy in episodes of its own.
        about: Metadata for the files of policies.
        watch: Called with the status of the run after each step of all environments.

    Raises:
        StoreError: All checkpoints are damaged.
        OSError: A file cannot be written; the newest checkpoint is still there.
        UsageError: An option does not fit the task.
    """
    torch.set_num_threads(1)  # more are no faster here, and results would depend on them
    with ExitStack() as stack:
        trainer = Trainer.prepare(run, folder, stack)
        while not trainer.finished:
            for status in trainer.stretch():
                watch(status)
                if trainer.at_evaluation:
                    evaluation = evaluate(trainer.policy(about))
                    trainer.note(evaluation, trainer.policy(about))
                    watch(trainer.status(evaluation))
            trainer.save()


@dataclass
class Counters:
    """Counters of a run.

    Attributes:
        step: Control steps so far, summed over all environments.
        episode: Number of finished episodes.
        best: Rate of success at the last control step of the saved policy.
        reached: Latest evaluations in a row that reached the rate to stop at.
        seconds: Total time, evaluations included.
    """

    step: int = 0
    episode: int = 0
    best: float = -1.0
    reached: int = 0
    seconds: float = 0.0


class Trainer:
    """The state of a running training; `prepare` makes one."""

    def __init__(self, plan: Plan, folder: Path, learner: Trainable, practice: Practice) -> None:
        self._plan, self._folder = plan, folder
        self._learner, self._practice = learner, practice
        self._rng = np.random.default_rng(plan.seed)
        self._checkpoints = Checkpoints(folder)
        self._counters, lengths = Counters(), {}
        checkpoint = self._checkpoints.load(practice.memories)
        if checkpoint is not None:
            learner.load(checkpoint.arrays)
            kept = checkpoint.counters["counters"]
            self._counters = Counters(**{f.name: kept[f.name] for f in fields(Counters)})
            practice.load(kept)
            self._rng.bit_generator.state = checkpoint.counters["rng"]
            lengths = checkpoint.counters["lengths"]
        elif plan.init:
            learner.start_from(load_policy(str(folder / INIT_FILE)))
        self.logger = RunLogger(folder, lengths, self._counters.step)
        self._losses: dict[str, float] = {}
        self._since = (time.perf_counter(), self._counters.step)

    @classmethod
    def prepare(cls, run: RunSetup, folder: Path, stack: ExitStack) -> Trainer:
        """Make a trainer in the state of the newest checkpoint.

        Args:
            run: What the run works with.
            folder: Folder of the run.
            stack: Closes the trainer's resources.

        Raises:
            UsageError: There is no such device.
        """
        if run.plan.device == "cuda" and not torch.cuda.is_available():
            raise UsageError("PyTorch finds no CUDA device here; leave --device cuda out")
        if run.plan.data and run.dataset is not None:
            learner, practice = _data_set(run, run.dataset)
        else:
            learner, practice = _environments(run, folder, stack)
        trainer = cls(run.plan, folder, learner, practice)
        stack.callback(trainer.close)
        return trainer

    # --- status

    @property
    def finished(self) -> bool:
        """Whether all steps are done, or the success rate to stop at is reached."""
        return self._counters.step >= self._plan.steps or self._counters.reached >= 2

    @property
    def at_evaluation(self) -> bool:
        """Whether an evaluation is due."""
        every = self._plan.evaluate_every
        return self._passed(every) or self._counters.step >= self._plan.steps

    def _passed(self, every: int) -> bool:
        """Whether the last step reached or passed a multiple of a number."""
        return self._counters.step % every < self._plan.envs

    def status(self, evaluation: Evaluation | None = None) -> TrainingStatus:
        """The status of the run."""
        started, first = self._since
        rate = (self._counters.step - first) / max(time.perf_counter() - started, 1e-9)
        return TrainingStatus(self._counters.step, rate, evaluation)

    def policy(self, about: Mapping[str, Any]) -> TrainedPolicy:
        """The current policy."""
        return self._learner.policy({**about, "step": self._counters.step})

    # --- training

    def stretch(self) -> Iterator[TrainingStatus]:
        """Train until the next checkpoint is due, and yield after each step of all environments.

        All environments are reset first, with seeds that depend on the run's seed and the step.
        """
        entropy = np.random.SeedSequence((self._plan.seed, self._counters.step))
        self._practice.begin(int(entropy.generate_state(1)[0]))
        number = self._counters.step // self._plan.checkpoint_every
        due = False
        while not (self.finished or (due and self._practice.at_rest)):
            self._step()
            yield self.status()
            due = self._counters.step // self._plan.checkpoint_every > number

    def _step(self) -> None:
        """Step all environments, or the data set once, and update the learner."""
        result = self._practice.step(self._rng, self._counters.step)
        self._counters.step += self._plan.envs
        self._losses |= result.losses
        self._log(result.finished)

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
            terms = {f"term/{label}": value for label, value in episode.terms.items()}
            self.logger.add("episodes", counters.step, {**row, **terms})
        if self._losses and self._passed(LOG_EVERY):
            status = self.status()
            row = {"seconds": self._seconds(), "steps_per_second": status.steps_per_second}
            self.logger.add("updates", counters.step, {**row, **self._losses})

    def _seconds(self) -> float:
        return self._counters.seconds + time.perf_counter() - self._since[0]

    def note(self, evaluation: Evaluation, policy: TrainedPolicy) -> None:
        """Log an evaluation, and save the policy if no earlier one was better."""
        counters, plan = self._counters, self._plan
        row = {"episode": counters.episode, **evaluation.row}
        self.logger.add("evaluations", counters.step, row)
        if evaluation.success_at_end >= counters.best:
            counters.best = evaluation.success_at_end
            save_policy(self._folder / POLICY_FILE, policy)
        good_enough = plan.stop_at is not None and evaluation.success_at_end >= plan.stop_at
        counters.reached = counters.reached + 1 if good_enough else 0

    def save(self) -> None:
        """Make a checkpoint."""
        kept = {
            "counters": {
                **asdict(self._counters),
                "seconds": self._seconds(),
                **self._practice.counters(),
            },
            "rng": self._rng.bit_generator.state,
            "lengths": self.logger.lengths(),
        }
        checkpoint = Checkpoint(self._counters.step, self._learner.arrays(), kept)
        self._checkpoints.save(checkpoint, self._practice.memories)

    def close(self) -> None:
        """Close the logs."""
        self.logger.close()


def _environments(run: RunSetup, folder: Path, stack: ExitStack) -> tuple[Trainable, Practice]:
    """The learner of a run in environments, and its practice in them."""
    plan, task = run.plan, run.task
    algorithm = find_algorithm(plan.algorithm)
    settings = make_settings(algorithm.settings, plan.settings)
    # In runs of earlier versions, rewards have the description's progress as it is.
    reward = (TRAINING_REWARDS if plan.ladder else RAW_REWARDS)[plan.reward]
    options: dict[str, Any] = {**plan.env, "reward": reward.sharing}
    demonstrations = _demonstrations(run, folder)
    timeout = plan.no_progress_timeout_s
    if timeout is None:  # as in runs of earlier versions
        timeout = reward.no_progress_timeout_s
    ends = TrainingWrappers(
        reward.end_on_setback, timeout, ladder=plan.ladder, progress_range=plan.progress_range
    )
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
    demo_rows = None
    if plan.demos:
        count = plan.demos if isinstance(plan.demos, int) else None
        with closing(make_vec(task, 1, wrap=ends, **options)) as env:
            own = reward(1, settings.discount)
            joined = NStepTransitions(shapes.layout, 1, settings.n_step, settings.discount)
            demo_rows = transitions(demonstrations[:count], env, own, shapes, joined)
    collection = algorithm.collection(learner, shapes.layout, plan.envs, demo_rows)
    collector = Collector(envs, reward(plan.envs, settings.discount), shapes)
    return learner, Interaction(learner, collector, collection, plan.steps, plan.envs)


def _demonstrations(run: RunSetup, folder: Path) -> Sequence[Demonstration]:
    """The episodes to learn from: those of the data set, or those that the run recorded."""
    if run.dataset is None:
        return load_demonstrations(folder)
    variation = run.plan.options.variation
    number = variation if isinstance(variation, int) else 0
    return recorded_demonstrations(run.dataset, run.task.name, number)


def _data_set(run: RunSetup, dataset: Dataset) -> tuple[Trainable, Practice]:
    """The learner of a run on a data set, and its practice with it."""
    plan, task = run.plan, run.task
    algorithm = find_algorithm(plan.algorithm)
    learner = algorithm.learner(
        read_demonstrations(
            dataset,
            task.name,
            plan.options.cameras,
            run.observed,
            Replayer(task, plan.env),
        ),
        make_settings(algorithm.settings, plan.settings),
        seed=plan.seed,
        device=plan.device,
    )
    return learner, Batches(learner, plan.steps)


def shapes_of(envs: TaskVectorEnv, features: int) -> Shapes:
    """The sizes of observations, state and actions, and which actions command grippers.

    Args:
        envs: The environments.
        features: Number of features that the training reward adds for the critics.
    """
    observed: Any = envs.single_observation_space
    acted: Any = envs.single_action_space
    sizes = [{agent: flatdim(space[agent]) for agent in envs.agents} for space in (observed, acted)]
    names = [name for agent in envs.agents for name in envs.action_names[agent]]
    grippers = tuple(i for i, name in enumerate(names) if name.endswith(".gripper"))
    return Shapes(sizes[0], sizes[1], flatdim(envs.state_space) + features, grippers)
