"""Evaluating a policy from Python."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.jobs import workers
from taskbuilder.learn import evaluation
from taskbuilder.learn.demonstrations import reference_of
from taskbuilder.learn.plan import RUN_FILE
from taskbuilder.learn.policy import TrainedPolicy
from taskbuilder.learn.runs import named_task, task_of_run
from taskbuilder.learn.zoo import load_policy
from taskbuilder.processes import cores
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task, load_task


@dataclass(frozen=True)
class _EnvFactory:
    """Makes the environment of a policy, also in another process."""

    task: str
    options: tuple[tuple[str, Any], ...]

    def __call__(self) -> TaskEnv:
        return parallel_env(self.task, **dict(self.options))


def evaluate(
    policy: TrainedPolicy | str | Path,
    episodes: int = evaluation.EPISODES,
    *,
    task: str | Path | Task | None = None,
    first_seed: int = evaluation.SEED,
    jobs: int | None = None,
    trust: bool = False,
    **options: Any,
) -> evaluation.EvaluationSummary:
    """Evaluate a policy without exploration, by default in episodes that training did not use.

    Args:
        policy: The policy, or a name or path that `load_policy` accepts.
        episodes: Number of episodes, with consecutive seeds.
        task: The task to play; by default the task that the policy was trained on.
        first_seed: Seed of the first episode.
        jobs: Number of processes; by default one for each CPU core.
        trust: Whether to run the task at the path that the folder of a run records, if the
            catalogue does not have it. A task is a Python program.
        options: Options of the environment that differ from those used in training; see `Options`.

    Returns:
        The success rate with its confidence interval, the returns, and the stages reached.

    Raises:
        UsageError: The policy does not fit the task, its file does not exist, or the task that it
            was trained on is not in the catalogue or not trusted.
        UnknownNameError: The zoo has no policy of this name, or ``task`` names an unknown task.
    """
    named = "the policy"
    if not isinstance(policy, TrainedPolicy):
        named = str(policy)
        if task is None and (Path(named) / RUN_FILE).is_file():
            task = task_of_run(Path(named), Catalogue.discover(), trust=trust)
        policy = load_policy(named)
    place = task
    if place is None:  # a file may come from anybody, so its task is only looked up by name
        place = named_task(named, policy.about.get("task"), Catalogue.discover())
    loaded = place if isinstance(place, Task) else load_task(place)
    where = reference_of(loaded) if isinstance(place, Task) else str(place)
    made = evaluation.options_for(policy, options, named)
    factory = _EnvFactory(where, tuple(made.items()))
    env = factory()
    evaluation.check_fits(policy, env, named, any_grasp="grasp" in options)
    env.close()
    seeds = range(first_seed, first_seed + episodes)
    with workers(min(cores() if jobs is None else jobs, episodes)) as spread:
        played = list(evaluation.evaluate(factory, policy, seeds, spread))
    return evaluation.summarise(played, len(loaded.description.stages))
