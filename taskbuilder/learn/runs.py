"""Training runs in their folders: starting, resuming and locking them."""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Unpack

from taskbuilder._version import __version__
from taskbuilder.data.dataset import Dataset, load_dataset
from taskbuilder.env.factory import with_choices
from taskbuilder.env.keywords import takes_options
from taskbuilder.env.options import TrainingOptions
from taskbuilder.errors import UsageError, display_path
from taskbuilder.learn.algorithms import find_algorithm, package_of
from taskbuilder.learn.checkpoint_evaluator import CheckpointEvaluator
from taskbuilder.learn.demonstrations import DEMONSTRATIONS_FILE, record
from taskbuilder.learn.expert_waits import with_measures
from taskbuilder.learn.ladders import check_ladder, with_ladder
from taskbuilder.learn.plan import Plan, check_source, digest, load_plan, make_plan, save_plan
from taskbuilder.learn.recordings import check_pictures, check_recorded, identity, task_in
from taskbuilder.learn.run_folders import INIT_FILE, default_folder, locked
from taskbuilder.learn.run_setup import RunSetup
from taskbuilder.machine import processor, system, versions
from taskbuilder.policies.runs import named_task, task_of_run
from taskbuilder.policies.trained import TrainedPolicy
from taskbuilder.policies.zoo import load_policy, save_policy
from taskbuilder.rollout.files import save_rollouts
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.choices import LadderChoice
from taskbuilder.schema.grasping import grasp_rules
from taskbuilder.task import Task, load_task
from taskbuilder.untrusted import names_within

if TYPE_CHECKING:  # loads PyTorch
    from taskbuilder.learn.training import OnStatus

START_EPISODES = 50
"""Expert episodes for start states, if the run has no demonstrations."""

TrackRollouts = Callable[[Iterable[Rollout], int], Iterable[Rollout]]
"""Wraps the demonstrations as they are recorded, given their total number."""


@dataclass(frozen=True)
class TrainedRun:
    """A finished training run.

    Attributes:
        folder: Folder of the run, with its tables.
        plan: The plan.
        policy: The policy with the best evaluation.
    """

    folder: Path
    plan: Plan
    policy: TrainedPolicy


@takes_options
def train(
    task: str | Path | Task | None = None,
    *,
    out: str | Path | None = None,
    algorithm: str | None = None,
    preset: str | None = None,
    settings: Mapping[str, Any] | Sequence[str] = (),
    reward: Literal["team", "local", "sparse", "shaped", "ratchet"] | None = None,
    steps: int | None = None,
    seed: int | None = None,
    envs: int | None = None,
    workers: int | None = None,
    demos: int | str | Path | None = None,
    starts: float | None = None,
    no_progress_timeout_s: float | None = None,
    ladder: LadderChoice | None = None,
    init: str | None = None,
    data: str | Path | None = None,
    device: Literal["cpu", "cuda"] | None = None,
    evaluate_every: int | None = None,
    evaluate_episodes: int | None = None,
    film_every: int | None = None,
    checkpoint_every: int | None = None,
    stop_at: float | None = None,
    watch: OnStatus = lambda _: None,
    **options: Unpack[TrainingOptions],
) -> TrainedRun:
    """Train a policy for each robot of a task.

    Args:
        task: Name or path of the task, or the task itself. With ``data``, the task of the data set
            is the default.
        out: Folder of the run; by default ``runs/TASK-TRACK-SEED``, such as
            ``runs/handover-scratch-0``.
        algorithm: The algorithm; by default ``maddpg``.
        preset: The preset of settings of the algorithm.
        settings: Settings of the algorithm, as a dictionary from names to values.
        reward: The training reward; by default ``ratchet``.
        steps: Control steps, summed over all environments; with a data set, updates.
        seed: Seed of everything random in the run.
        envs: Number of parallel environments.
        workers: Processes for the environments; 0 for this one. Results do not depend on it.
        demos: Expert episodes to learn from: their number, or the folder of a data set.
        starts: Fraction of the training episodes that begin in a state of an expert episode.
        no_progress_timeout_s: Time without progress after which a training episode ends, in
            seconds. By default measured, if the reward has such a rule: 1.5 times the longest time
            that the expert needs, and at least 1.5 s. A time that cuts the expert is warned of.
        ladder: Where the progress comes from that training sees: ``task`` for the description,
            which is the default if it has any, or ``expert`` for the expert's stages.
        init: The trained policy to start from, by name.
        data: The data set to learn from, for algorithms that learn from one.
        device: Device of the networks.
        evaluate_every: Control steps between evaluations.
        evaluate_episodes: Episodes per evaluation.
        film_every: Evaluations between films of an episode; 0 for no films.
        checkpoint_every: Control steps between checkpoints.
        stop_at: Stop when, in two evaluations in a row, success holds at the last control step in
            this share of the episodes.
        watch: Function that is called with the status of the run after each step of all
            environments.
        options: Options of the environments; see `Options`. Those that a data set or the policy
            ``init`` decides need not be given.

    Raises:
        UsageError: An option is invalid, the folder already has a run, or PyTorch is missing.
        FileError: The files of the task have errors.
    """
    run = set_up(
        task,
        settings,
        algorithm=algorithm,
        preset=preset,
        reward=reward,
        steps=steps,
        seed=seed,
        envs=envs,
        workers=workers,
        demos=demos,
        starts=starts,
        no_progress_timeout_s=no_progress_timeout_s,
        ladder=ladder,
        init=init,
        data=data,
        device=device,
        evaluate_every=evaluate_every,
        evaluate_episodes=evaluate_episodes,
        film_every=film_every,
        checkpoint_every=checkpoint_every,
        stop_at=stop_at,
        **options,
    )
    folder = Path(out) if out is not None else default_folder(run)
    with locked(folder, new=True):
        run = create(folder, run)
        if run.waits is not None and run.waits.cut:
            warnings.warn(str(run.waits), stacklevel=2)
        go_on(folder, run, watch)
    return TrainedRun(folder, run.plan, load_policy(str(folder)))


def resume(
    folder: str | Path, *, watch: OnStatus = lambda _: None, trust: bool = False
) -> TrainedRun:
    """Resume a training run from its newest checkpoint.

    Args:
        folder: Folder of the run.
        watch: Called with the status of the run after each step of all environments.
        trust: Whether to run the task at the path that the run records, if the catalogue does not
            have it. A task is a Python program.

    Raises:
        UsageError: There is no run, its task has changed or is not trusted, the folder has links,
            or another process is training in it.
    """
    check_torch()
    path = Path(folder)
    run = find(path, trust=trust)
    with locked(path, new=False):
        go_on(path, run, watch)
    return TrainedRun(path, run.plan, load_policy(str(path)))


def set_up(
    task: str | Path | Task | None,
    settings: Any = (),
    *,
    catalogue: Catalogue | None = None,
    **given: Any,
) -> RunSetup:
    """Plan a new run, and check that the task and the data set have what it needs.

    Args:
        task: Name or path of the task, or the task itself; None for that of the data set.
        settings: Settings of the algorithm; see `make_plan`.
        catalogue: Where the task is looked up.
        given: See `make_plan`.

    Raises:
        UsageError: Nothing names a task, a value is invalid, or they do not fit each other.
    """
    check_torch()
    catalogue = catalogue or Catalogue.discover()
    from_data = find_algorithm(given.get("algorithm") or Plan.algorithm).from_data
    if from_data and not given.get("data") and isinstance(given.get("demos"), str | Path | Dataset):
        given["data"] = given.pop("demos")
    dataset: Dataset | None = None
    for name in ("data", "demos"):
        source = given.get(name)
        if isinstance(source, str | Path | Dataset):
            check_source(given)
            given[name] = dataset = source if isinstance(source, Dataset) else load_dataset(source)
    if task is None:
        if dataset is None:
            raise UsageError("which task? give a name or a path, or --resume RUN to go on")
        task = named_task(display_path(dataset.folder), task_in(dataset), catalogue)
    loaded = task if isinstance(task, Task) else load_task(task, catalogue=catalogue)
    plan = make_plan(loaded.reference, settings, **with_choices(loaded, given))
    return checked(with_ladder(plan, loaded), loaded, dataset)


def check_torch() -> None:
    """Check that PyTorch is installed.

    Raises:
        UsageError: It is not installed.
    """
    if importlib.util.find_spec("torch") is None:
        raise UsageError('training needs PyTorch; pip install "taskbuilder[train]"')


def checked(plan: Plan, task: Task, dataset: Dataset | None = None) -> RunSetup:
    """Check that the task and the data set have what the plan needs.

    Raises:
        UsageError: The task lacks an expert or progress, no robot can have the plan's rule of
            grasping, its robots observe pictures that the run does not learn from, or the data set
            is not of this task.
    """
    if dataset is None and (plan.demos or plan.starts) and not task.file.spec.expert:
        raise UsageError(f"{task.name} has no expert; --demos and --starts need its episodes")
    names = check_recorded(dataset, task, plan.env) if dataset is not None else {}
    if plan.data:
        return RunSetup(plan, task, dataset, names)
    check_pictures(task, plan.env)
    check_ladder(plan, task)
    return RunSetup(plan, task, dataset)


def create(
    folder: Path,
    run: RunSetup,
    *,
    command: str = "",
    catalogue: Catalogue | None = None,
    track: TrackRollouts = lambda episodes, _: episodes,
) -> RunSetup:
    """Record demonstrations if the plan needs any, measure the expert, then write the plan.

    Args:
        folder: Folder of the run.
        run: What it works with.
        command: The command that started the run.
        catalogue: The catalogue in which other processes look up the task.
        track: Wraps the demonstrations as they are recorded.

    Returns:
        The run with the plan as it was written.
    """
    plan, task = run.plan, run.task
    episodes: list[Rollout] = []
    asked = plan.demos if isinstance(plan.demos, int) else 0
    count = 0 if run.dataset else max(asked, START_EPISODES if plan.starts else 0)
    if count:
        episodes = list(track(record(plan.task, count, plan.env, catalogue=catalogue), count))
        save_rollouts(folder / DEMONSTRATIONS_FILE, episodes)
    run = with_measures(run, episodes, catalogue)
    if plan.init:
        save_policy(folder / INIT_FILE, load_policy(plan.init))
    save_plan(
        folder,
        run.plan,
        {
            "digest": _digest(task),
            "algorithm_package": package_of(plan.algorithm),
            **({"data_seal": identity(run.dataset)} if run.dataset else {}),
            "horizon": plan.options.applied(task).spec.timing.episode_steps,
            "stages": list(task.description.stages),
            "versions": versions(),
            "processor": processor(),
            "system": system(),
            "command": command,
        },
    )
    return run


def find(folder: Path, catalogue: Catalogue | None = None, *, trust: bool = False) -> RunSetup:
    """What a run that is to be resumed works with, if it has not changed.

    Raises:
        UsageError: There is no run, the task is not trusted, the task's files or the data set have
            changed, or the folder has links, through which training would write to other files.
    """
    plan, about = load_plan(folder)
    for name in names_within(folder):
        if (folder / name).is_symlink():
            where = display_path(folder / name)
            raise UsageError(f"{where} is a link; put the file itself there to resume the run")
    file = task_of_run(folder, catalogue or Catalogue.discover(), trust=trust)
    task = load_task(file, catalogue=catalogue)
    if about.get("digest") != _digest(task):
        raise UsageError(
            f"{task.name} has changed since this run began; train anew, or put its files back"
        )
    folders = [each for each in (plan.data, plan.demos) if each and isinstance(each, str)]
    dataset = load_dataset(folders[0]) if folders else None
    if dataset is None:
        return RunSetup(plan, task)
    if about.get("data_seal") != identity(dataset):
        where = display_path(dataset.folder)
        raise UsageError(f"{where} has changed since this run began; train anew, or put it back")
    return checked(plan, task, dataset)


def go_on(folder: Path, run: RunSetup, watch: OnStatus = lambda _: None) -> None:
    """Train from the newest checkpoint, or from the start; see `training.train`."""
    from taskbuilder.learn import training

    plan, task = run.plan, run.task
    about = {
        "task": task.name,
        "task_version": task.version,
        "algorithm": plan.algorithm,
        "reward": plan.reward,
        **({"ladder": plan.ladder} if plan.ladder else {}),
        "track": plan.track,
        "demos": plan.demos if isinstance(plan.demos, int) else Path(plan.demos).name,
        "starts": plan.starts,
        **({"data": Path(plan.data).name} if plan.data else {}),
        **({"teachers": list(plan.teachers)} if plan.teachers else {}),
        **({"init": plan.init} if plan.init else {}),
        "env": plan.env,
        "grasp_rules": dict(grasp_rules(plan.options.applied(task))),
        "stages": list(task.description.stages),
        "seed": plan.seed,
        "command": load_plan(folder)[1]["command"],
        "taskbuilder": __version__,
    }
    with closing(CheckpointEvaluator(task, plan, folder)) as evaluator:
        training.train(run, folder, evaluator, about, watch)


def _digest(task: Task) -> str:
    return digest([task.file.entry.file, task.file.entry.description_file])
