"""Training runs in their folders: begun, gone on with, and kept from other processes meanwhile."""

from __future__ import annotations

import importlib.util
import platform
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskbuilder._version import __version__
from taskbuilder.errors import UnknownNameError, UsageError, display_path
from taskbuilder.learn.checkpoint_evaluator import CheckpointEvaluator
from taskbuilder.learn.demonstrations import DEMONSTRATIONS_FILE, record, reference_of
from taskbuilder.learn.plan import RUN_FILE, Plan, digest, load_plan, make_plan, save_plan
from taskbuilder.learn.policy import TrainedPolicy
from taskbuilder.learn.zoo import load_policy, save_policy
from taskbuilder.rollout.files import save_rollouts
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.catalogue import Catalogue, looks_like_path
from taskbuilder.task import Task, load_task

START_EPISODES = 50
"""Expert episodes to begin in, where none are asked for as demonstrations."""

Watch = Callable[[Any], None]
"""Told how a run stands, a `TrainingStatus`, after each step of all environments."""

Track = Callable[[Iterable[Rollout], int], Iterable[Rollout]]
"""Sees demonstrations pass as they are recorded, so many in all."""


@dataclass(frozen=True)
class TrainedRun:
    """A training run that has ended.

    Attributes:
        folder: Where it is, with its tables.
        plan: What was trained and how.
        policy: The policy that did best in its evaluations.
    """

    folder: Path
    plan: Plan
    policy: TrainedPolicy


def train(
    task: str | Path | Task,
    *,
    out: str | Path | None = None,
    settings: Any = (),
    watch: Watch = lambda _: None,
    **plan: Any,
) -> TrainedRun:
    """Train a policy for each robot of a task.

    Args:
        task: Its name, the path of its YAML file, or the task itself.
        out: Folder of the run; by default ``runs/TASK-TRACK-SEED``.
        settings: Of the algorithm, by name.
        watch: Told how the run stands, after each step of all environments.
        plan: All else of `Plan`, such as ``algorithm``, ``steps``, ``seed``, ``demos``.

    Raises:
        UsageError: Something does not fit, there is a run in the folder, or no PyTorch.
        FileError: The task is wrong.
    """
    check_torch()
    loaded = task if isinstance(task, Task) else load_task(task)
    made = make_plan(reference_of(loaded), settings, **plan)
    check_task(made, loaded)
    folder = Path(out) if out is not None else default_folder(made, loaded)
    with locked(folder, new=True):
        create(folder, made, loaded)
        go_on(folder, made, loaded, watch)
    return TrainedRun(folder, made, load_policy(str(folder)))


def resume(folder: str | Path, *, watch: Watch = lambda _: None) -> TrainedRun:
    """Go on with a training run, from its newest checkpoint and as it began.

    Args:
        folder: Its folder.
        watch: Told how the run stands, after each step of all environments.

    Raises:
        UsageError: There is no run, its task has changed, or it is being trained in already.
    """
    check_torch()
    path = Path(folder)
    plan, task = find(path)
    with locked(path, new=False):
        go_on(path, plan, task, watch)
    return TrainedRun(path, plan, load_policy(str(path)))


def check_torch() -> None:
    """Refuse to train without PyTorch.

    Raises:
        UsageError: It is not installed.
    """
    if importlib.util.find_spec("torch") is None:
        raise UsageError('training needs PyTorch; pip install "taskbuilder[train]"')


def check_task(plan: Plan, task: Task) -> None:
    """Refuse a plan that needs what its task does not have.

    Raises:
        UsageError: An expert or progress is missing.
    """
    if (plan.demos or plan.starts) and not task.file.spec.expert:
        raise UsageError(f"{task.name} has no expert; --demos and --starts need its episodes")
    if plan.reward in ("shaped", "ratchet") and task.description.progress is None:
        raise UsageError(
            f"{task.name} has no progress; write it into its description, or choose --reward team"
        )


def default_folder(plan: Plan, task: Task) -> Path:
    """Where a run goes that was given no folder."""
    return Path("runs") / f"{task.name}-{plan.track}-{plan.seed}"


@contextmanager
def locked(folder: Path, *, new: bool) -> Iterator[None]:
    """Keep other processes from training in the same folder.

    Raises:
        UsageError: One does, or a new run is to be made where one is already.
    """
    import fcntl

    if new:
        if (folder / RUN_FILE).exists():
            name = display_path(folder)
            raise UsageError(f"{name} is a training run already; --resume {name}, or another --out")
        folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UsageError(f"{display_path(folder)} is being trained in already") from None
        yield


def create(
    folder: Path,
    plan: Plan,
    task: Task,
    *,
    command: str = "",
    catalogue: Catalogue | None = None,
    track: Track = lambda episodes, _: episodes,
) -> None:
    """Record demonstrations where any are needed, then write down what the run is.

    Args:
        folder: The run's.
        plan: What to train and how.
        task: The plan's.
        command: That asked for it.
        catalogue: Where the task is looked up by other processes.
        track: Sees the demonstrations pass.
    """
    from taskbuilder.learn.training import INIT_FILE

    count = max(plan.demos, START_EPISODES if plan.starts else 0)
    if count:
        episodes = list(track(record(plan.task, count, plan.env, catalogue=catalogue), count))
        save_rollouts(folder / DEMONSTRATIONS_FILE, episodes)
    if plan.init:
        save_policy(folder / INIT_FILE, load_policy(plan.init))
    save_plan(
        folder,
        plan,
        {
            "digest": _digest(task),
            "horizon": task.file.spec.timing.episode_steps,
            "stages": list(task.description.stages),
            "versions": _versions(),
            "command": command,
        },
    )


def find(folder: Path, catalogue: Catalogue | None = None) -> tuple[Plan, Task]:
    """The plan of a run, and its task if that is still the same.

    Raises:
        UsageError: There is no run, or the task's files have changed.
    """
    plan, about = load_plan(folder)
    file = task_of_run(folder, catalogue or Catalogue.discover())
    task = load_task(file, catalogue=catalogue)
    if about.get("digest") != _digest(task):
        raise UsageError(
            f"{task.name} has changed since this run began; train anew, or put its files back"
        )
    return plan, task


def task_of_run(folder: Path, catalogue: Catalogue) -> Path:
    """The file of the task that is trained in a run's folder; nothing is imported to find it.

    Whoever names the folder says by it that they trained there, so the path of the task that
    training wrote down holds. One that leads into the folder does not, nor one from wherever the
    command happens to be called: a folder from somebody else would bring its own code with it.

    Args:
        folder: Of the run.
        catalogue: Where its task is looked up by name, and by the name of its file.

    Raises:
        UsageError: It is nowhere that the user has named.
    """
    task = load_plan(folder)[0].task
    if task not in catalogue.tasks:
        path = Path(task)
        within = path.resolve().is_relative_to(folder.resolve())
        if path.is_absolute() and path.is_file() and not within:
            return path
        if looks_like_path(task):
            task = path.stem
    return named_task(display_path(folder), task, catalogue)


def named_task(name: str, task: object, catalogue: Catalogue) -> Path:
    """The file of a task that something names by a plain name of the catalogue.

    Args:
        name: Of what names it.
        task: What it says.
        catalogue: Where it is looked up.

    Raises:
        UsageError: The catalogue has none of that name.
    """
    try:
        return catalogue.named_task(task).file
    except UnknownNameError as error:
        hint = "name the folder of its files by --task-path"
        raise UsageError(f"{name} is for a task that is not here ({error}); {hint}") from None


def go_on(folder: Path, plan: Plan, task: Task, watch: Watch = lambda _: None) -> None:
    """Train from the newest checkpoint, or from the beginning; see `training.train`."""
    from taskbuilder.learn import training

    about = {
        "task": task.name,
        "algorithm": plan.algorithm,
        "reward": plan.reward,
        "track": plan.track,
        "demos": plan.demos,
        "starts": plan.starts,
        **({"init": plan.init} if plan.init else {}),
        "env": plan.env,
        "stages": list(task.description.stages),
        "seed": plan.seed,
        "command": load_plan(folder)[1]["command"],
        "taskbuilder": __version__,
    }
    with closing(CheckpointEvaluator(task, plan.env, plan.evaluate_episodes)) as evaluator:
        training.train(plan, task, folder, evaluator, about, watch)


def _digest(task: Task) -> str:
    return digest([task.file.entry.file, task.file.entry.description_file])


def _versions() -> dict[str, str]:
    from importlib.metadata import version

    packages = ("pybullet", "numpy", "torch", "gymnasium", "pettingzoo")
    found = {package: version(package) for package in packages}
    return {"taskbuilder": __version__, "python": platform.python_version(), **found}
