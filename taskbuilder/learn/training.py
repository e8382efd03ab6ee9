"""Training: collect, learn, evaluate, keep; and go on exactly after whatever ended it.

A run is cut into stretches by its checkpoints. At each cut all environments begin new episodes,
from seeds that follow from the run's own and the step. So nothing of the physics has to be kept,
and a run that goes on from a checkpoint is the same, to the bit, as one that was never stopped.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import flatdim

from taskbuilder.env.vector import TaskVectorEnv, make_vec
from taskbuilder.learn.algorithms import Learner, make_learner
from taskbuilder.learn.checkpoints import Checkpoint, Checkpoints
from taskbuilder.learn.collection import Collector, Finished
from taskbuilder.learn.expertise import load_episodes, transitions
from taskbuilder.learn.journal import Journal
from taskbuilder.learn.judging import Evaluation
from taskbuilder.learn.plan import Plan
from taskbuilder.learn.policy import Policy
from taskbuilder.learn.replay import Replay
from taskbuilder.learn.shapes import Rows, Shapes
from taskbuilder.learn.signals import SIGNALS
from taskbuilder.learn.wrappers import StartPrefix, TrainingWrappers
from taskbuilder.learn.zoo import POLICY_FILE, save_policy
from taskbuilder.task import Task

DEMO_SHARE = 0.5
"""Of every batch, where there are demonstrations."""

LOG_EVERY = 1_000
"""Control steps between rows about updates."""


@dataclass(frozen=True)
class Moment:
    """How a run stands, for whoever watches it.

    Attributes:
        step: Control steps so far.
        steps_per_second: Of this sitting.
        evaluation: The latest one, if it was made just now.
    """

    step: int
    steps_per_second: float
    evaluation: Evaluation | None = None


Evaluate = Callable[[Policy], Evaluation]
Watch = Callable[[Moment], None]


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
        folder: The run's; its expert episodes, if any, are there already.
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
        run = Run.prepare(plan, task, folder, stack)
        while not run.done:
            for moment in run.stretch():
                watch(moment)
                if run.at_evaluation:
                    evaluation = evaluate(run.policy(about))
                    run.note(evaluation, run.policy(about))
                    watch(run.moment(evaluation))
            run.save()


@dataclass
class Counters:
    """Where a run stands, beside what its learner has learned.

    Attributes:
        step: Control steps of all environments so far.
        episode: Episodes that have ended.
        due: Updates that are owed, part of one included.
        begun: Whether learning has begun.
        best: Success rate of the policy that was kept.
        reached: Evaluations in a row that reached the rate to stop at.
        seconds: Of all sittings, evaluations included.
    """

    step: int = 0
    episode: int = 0
    due: float = 0.0
    begun: bool = False
    best: float = -1.0
    reached: int = 0
    seconds: float = 0.0


class Run:
    """A training run; see `train`. Made by `prepare`."""

    def __init__(
        self, plan: Plan, folder: Path, learner: Learner, collector: Collector, memory: Experience
    ) -> None:
        self._plan, self._folder = plan, folder
        self._learner, self._collector, self._memory = learner, collector, memory
        self._rng = np.random.default_rng(plan.seed)
        self._checkpoints = Checkpoints(folder)
        self._counters, lengths = Counters(), {}
        found = self._checkpoints.load(memory.parts)
        if found is not None:
            learner.load(found.arrays)
            self._counters = Counters(**found.counters["counters"])
            self._rng.bit_generator.state = found.counters["rng"]
            lengths = found.counters["lengths"]
        self.journal = Journal(folder, lengths, self._counters.step)
        self._losses: dict[str, float] = {}
        self._since = (time.perf_counter(), self._counters.step)

    @classmethod
    def prepare(cls, plan: Plan, task: Task, folder: Path, stack: ExitStack) -> Run:
        """Make all that a run needs, as it was at its newest checkpoint.

        Args:
            plan: What to train and how.
            task: The plan's.
            folder: The run's.
            stack: Frees it again.
        """
        episodes = load_episodes(folder)
        pays = SIGNALS[plan.reward]
        options: dict[str, Any] = {**plan.env, "reward": pays.sharing}
        ends = TrainingWrappers(pays.end_on_setback, pays.no_progress_timeout_s)
        prefixes = tuple(map(StartPrefix.before_success, episodes)) if plan.starts else ()
        wrap = replace(ends, start_prefixes=prefixes, start_share=plan.starts)
        envs = make_vec(task, plan.envs, plan.workers, wrap=wrap, **options)
        stack.enter_context(closing(envs))
        shapes = shapes_of(envs, pays.size)
        learner = make_learner(plan, shapes, alike=pays.alike)
        discount = learner.settings.discount
        shown = None
        if plan.demos:
            with closing(make_vec(task, 1, wrap=ends, **options)) as env:
                shown = transitions(episodes[: plan.demos], env, pays(1, discount), shapes)
        memory = Experience(shapes.layout.width, learner.settings.capacity, shown)
        collector = Collector(envs, pays(plan.envs, discount), shapes)
        run = cls(plan, folder, learner, collector, memory)
        stack.callback(run.close)
        return run

    # --- where it stands

    @property
    def done(self) -> bool:
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

    def moment(self, evaluation: Evaluation | None = None) -> Moment:
        """How the run stands."""
        started, first = self._since
        rate = (self._counters.step - first) / max(time.perf_counter() - started, 1e-9)
        return Moment(self._counters.step, rate, evaluation)

    def policy(self, about: Mapping[str, Any]) -> Policy:
        """The present policy."""
        return self._learner.policy({**about, "step": self._counters.step})

    # --- what it does

    def stretch(self) -> Iterator[Moment]:
        """Go on until a checkpoint is to be made, a step of all environments at a time.

        New episodes begin everywhere, from seeds that follow from the run's and the step.
        """
        entropy = np.random.SeedSequence((self._plan.seed, self._counters.step))
        self._collector.begin(int(entropy.generate_state(1)[0]))
        cut = False
        while not cut:
            self._step()
            yield self.moment()
            cut = self.done or self._passed(self._plan.checkpoint_every)

    def _step(self) -> None:
        """Let all environments take a step, and learn meanwhile from what there was before it."""
        counters, plan = self._counters, self._plan
        self._begin_learning_in_time()
        done = min(counters.step / plan.steps, 1.0)
        actions = self._learner.act(self._collector.observations, self._rng, done)
        self._collector.step_async(actions)
        self._learn()
        rows, finished = self._collector.step_wait()
        self._memory.experience.add(rows)
        counters.step += plan.envs
        self._log(finished)

    def _begin_learning_in_time(self) -> None:
        counters = self._counters
        if counters.begun:
            return
        if self._memory.shown is not None or counters.step >= self._learner.settings.warm_up:
            self._learner.begin(self._memory.rows(), self._rng)
            counters.begun = True

    def _learn(self) -> None:
        counters, settings = self._counters, self._learner.settings
        if not counters.begun:
            return
        counters.due += self._plan.envs / settings.update_every
        while counters.due >= 1.0:
            self._losses |= self._learner.update(self._memory, self._rng, counters.step)
            counters.due -= 1.0

    def _log(self, finished: Sequence[Finished]) -> None:
        counters = self._counters
        for episode in finished:
            counters.episode += 1
            row = {
                "episode": counters.episode,
                "steps": episode.steps,
                "success": int(episode.success),
                "stage": episode.stage,
                "team_return": episode.team,
                "paid": episode.paid,
            }
            terms = {f"term/{label}": pay for label, pay in episode.terms.items()}
            self.journal.add("episodes", counters.step, {**row, **terms})
        if self._losses and self._passed(LOG_EVERY):
            moment = self.moment()
            row = {"seconds": self._seconds(), "steps_per_second": moment.steps_per_second}
            self.journal.add("updates", counters.step, {**row, **self._losses})

    def _seconds(self) -> float:
        return self._counters.seconds + time.perf_counter() - self._since[0]

    def note(self, evaluation: Evaluation, policy: Policy) -> None:
        """Keep the result of an evaluation, and the policy if none before did better."""
        counters, plan = self._counters, self._plan
        row = {"episode": counters.episode, **evaluation.row}
        self.journal.add("evaluations", counters.step, row)
        if evaluation.success >= counters.best:
            counters.best = evaluation.success
            save_policy(self._folder / POLICY_FILE, policy)
        sure = plan.stop_at is not None and evaluation.success >= plan.stop_at
        counters.reached = counters.reached + 1 if sure else 0

    def save(self) -> None:
        """Make a checkpoint."""
        kept = {
            "counters": {**asdict(self._counters), "seconds": self._seconds()},
            "rng": self._rng.bit_generator.state,
            "lengths": self.journal.lengths(),
        }
        checkpoint = Checkpoint(self._counters.step, self._learner.arrays(), kept)
        self._checkpoints.save(checkpoint, self._memory.parts)

    def close(self) -> None:
        """Finish the logs."""
        self.journal.close()


class Experience:
    """What a run learns from: its own experience, and demonstrations if there are any.

    Args:
        width: Numbers of a row.
        capacity: Rows of experience that are kept.
        shown: Rows of demonstrations, or None.
    """

    def __init__(self, width: int, capacity: int, shown: Rows | None) -> None:
        self.experience = Replay(width, capacity)
        self.shown: Replay | None = None
        if shown is not None:
            self.shown = Replay(width, len(shown))
            self.shown.add(shown)

    @property
    def parts(self) -> dict[str, Replay]:
        """What a checkpoint keeps: demonstrations are played again."""
        return {"experience": self.experience}

    def rows(self) -> Rows:
        """All rows."""
        return (self.experience if self.shown is None else self.shown).since(0)

    def sample(self, count: int, rng: np.random.Generator) -> Rows:
        """See `Memory`; half are demonstrations, or all until there is experience."""
        if self.shown is None:
            return self.experience.sample(count, rng)
        shown = round(count * DEMO_SHARE) if len(self.experience) else count
        rows = [self.shown.sample(shown, rng)]
        if shown < count:
            rows.append(self.experience.sample(count - shown, rng))
        return np.concatenate(rows)


def shapes_of(envs: TaskVectorEnv, memory: int) -> Shapes:
    """The sizes of what agents and critics see and say.

    Args:
        envs: The environments.
        memory: Numbers that a training signal shows the critics besides.
    """
    seen: Any = envs.single_observation_space
    said: Any = envs.single_action_space
    sizes = [{agent: flatdim(space[agent]) for agent in envs.agents} for space in (seen, said)]
    return Shapes(sizes[0], sizes[1], flatdim(envs.state_space) + memory)
