"""`taskbuilder train`."""

from __future__ import annotations

import argparse
import importlib.util
import platform
import shlex
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import fields, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder._version import __version__
from taskbuilder.cli.output import paint, progress, say
from taskbuilder.cli.tasks import catalogue_of, make_folder
from taskbuilder.cli.trained import task_of_run
from taskbuilder.env.actions import HYSTERESIS
from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import UsageError, display_path
from taskbuilder.expert.player import Expert
from taskbuilder.jobs import cores, workers
from taskbuilder.learn.expertise import EXPERT_FILE, SEEDS_FROM
from taskbuilder.learn.judging import Judge
from taskbuilder.learn.plan import (
    RUN_FILE,
    Plan,
    digest,
    load_plan,
    read_settings,
    save_plan,
)
from taskbuilder.rollout.files import save_rollouts
from taskbuilder.rollout.record import Rollout
from taskbuilder.spec.catalogue import Catalogue
from taskbuilder.task import Task, load_task

START_EPISODES = 50
"""Expert episodes to begin in, where none are asked for as demonstrations."""


def run(arguments: argparse.Namespace) -> int:
    """Train, or go on training, and say how it goes."""
    if importlib.util.find_spec("torch") is None:
        raise UsageError('training needs PyTorch; pip install "taskbuilder[train]"')
    catalogue = catalogue_of(arguments)
    if arguments.resume:
        _check_alone(arguments)
        folder = arguments.resume
        plan, about = load_plan(folder)
        task = _same_task(folder, about, catalogue)
    else:
        plan, task = _planned(arguments, catalogue)
        folder = arguments.out or Path("runs") / f"{task.name}-{plan.track}-{plan.seed}"
    with _locked(folder, new=not arguments.resume):
        if not arguments.resume:
            _found(folder, plan, task, catalogue, arguments)
        _train(folder, plan, task)
    return 0


def _check_alone(arguments: argparse.Namespace) -> None:
    """Refuse changes to a run that has begun.

    Raises:
        UsageError: There is more beside --resume.
    """
    names = [*(field.name for field in fields(Plan) if field.name != "settings"), "out", "set"]
    given = [name for name in names if getattr(arguments, name, None) is not None]
    if given:
        words = ["TASK" if name == "task" else f"--{name.replace('_', '-')}" for name in given]
        raise UsageError(f"--resume goes on as the run began; leave {' and '.join(words)} out")


def _planned(arguments: argparse.Namespace, catalogue: Catalogue) -> tuple[Plan, Task]:
    from taskbuilder.learn.algorithms import settings_of

    if not arguments.task:
        raise UsageError("which task? give a name or a path, or --resume RUN to go on")
    task = load_task(arguments.task, catalogue=catalogue)
    names = {field.name for field in fields(Plan)} - {"settings"}
    given = {name: value for name, value in vars(arguments).items() if name in names}
    entry = task.file.entry  # of an installed task the name; another is found by its whole path
    given["task"] = entry.name if entry.module else str(entry.file)
    plan = Plan(**{name: value for name, value in given.items() if value is not None})
    plan.check()
    chosen = read_settings(settings_of(plan.algorithm), arguments.set or ())
    plan = replace(plan, settings={**plan.preset, **chosen})
    if (plan.demos or plan.starts) and not task.file.spec.expert:
        raise UsageError(f"{task.name} has no expert; --demos and --starts need its episodes")
    if plan.reward in ("shaped", "ratchet") and task.description.progress is None:
        raise UsageError(
            f"{task.name} has no progress; write it into its description, or choose --reward team"
        )
    return plan, task


def _same_task(folder: Path, about: dict[str, Any], catalogue: Catalogue) -> Task:
    """The task of a run, if it is still the same.

    Raises:
        UsageError: Its files have changed, or are nowhere that the user has named.
    """
    task = load_task(task_of_run(folder, catalogue), catalogue=catalogue)
    if about.get("digest") != _digest(task):
        raise UsageError(
            f"{task.name} has changed since this run began; train anew, or put its files back"
        )
    return task


def _digest(task: Task) -> str:
    return digest([task.file.entry.file, task.file.entry.description_file])


@contextmanager
def _locked(folder: Path, *, new: bool) -> Iterator[None]:
    """Keep other processes from training in the same folder.

    Raises:
        UsageError: One does, or a new run is to be made where one is already.
    """
    import fcntl

    if new:
        if (folder / RUN_FILE).exists():
            name = display_path(folder)
            raise UsageError(f"{name} is a training run already; --resume {name}, or another --out")
        make_folder(folder)
    with (folder / ".lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UsageError(f"{display_path(folder)} is being trained in already") from None
        yield


# Beginning


def _found(
    folder: Path, plan: Plan, task: Task, catalogue: Catalogue, arguments: argparse.Namespace
) -> None:
    """Record expert episodes where any are needed, then write down what the run is."""
    count = max(plan.demos, START_EPISODES if plan.starts else 0)
    if count:
        save_rollouts(folder / EXPERT_FILE, _record(plan, count, catalogue))
    save_plan(
        folder,
        plan,
        {
            "digest": _digest(task),
            "horizon": task.file.spec.timing.episode_steps,
            "stages": list(task.description.stages),
            "versions": _versions(),
            "command": shlex.join(["taskbuilder", *arguments.words]),
        },
    )


def _versions() -> dict[str, str]:
    from importlib.metadata import version

    packages = ("pybullet", "numpy", "torch", "gymnasium", "pettingzoo")
    found = {package: version(package) for package in packages}
    return {"taskbuilder": __version__, "python": platform.python_version(), **found}


def _record(plan: Plan, count: int, catalogue: Catalogue) -> list[Rollout]:
    """Expert episodes, failed ones too, played in as many processes as there are cores."""
    play = partial(_play_elsewhere, plan.task, catalogue, tuple(plan.env.items()))
    seeds = range(SEEDS_FROM, SEEDS_FROM + count)
    with workers(min(cores(), count)) as spread:
        played = list(progress(spread(play, seeds), "expert episodes", total=count))
    good = sum(episode.success for episode in played)
    say(f"expert: {good} of {count} episodes succeeded; in {EXPERT_FILE}")
    return played


def _play_elsewhere(
    task: str, catalogue: Catalogue, options: tuple[tuple[str, Any], ...], seed: int
) -> Rollout:
    expert = _expert_once(task, catalogue, options)
    played = expert.play(seed)
    robots = expert.env.episode.world.scene.robots
    actions = {
        agent: _explicit(told) if robots[agent].action.gripper == "binary" else told
        for agent, told in played.actions.items()
    }
    return replace(played, actions=actions)


def _explicit(actions: NDArray[np.float32]) -> NDArray[np.float32]:
    """The same with a binary gripper told at every step what it was told last.

    An expert says once that it opens or closes, and then leaves it. A network that imitates this
    says something between the two at each step, which is nothing.
    """
    told = actions.copy()
    last = np.float32(1.0)
    for row in told:
        last = row[-1] = row[-1] if abs(row[-1]) > HYSTERESIS else last
    return told


@lru_cache(maxsize=1)
def _expert_once(task: str, catalogue: Catalogue, options: tuple[tuple[str, Any], ...]) -> Expert:
    """An expert that is kept for as long as its process lives."""
    return Expert(parallel_env(load_task(task, catalogue=catalogue), **dict(options)))


# Going on


def _train(folder: Path, plan: Plan, task: Task) -> None:
    from taskbuilder.learn.training import Moment, train

    about = {
        "task": task.name,
        "algorithm": plan.algorithm,
        "reward": plan.reward,
        "track": plan.track,
        "demos": plan.demos,
        "starts": plan.starts,
        "env": plan.env,
        "stages": list(task.description.stages),
        "seed": plan.seed,
        "command": load_plan(folder)[1]["command"],
        "taskbuilder": __version__,
    }

    def watch(moment: Moment) -> None:
        if moment.evaluation is not None:
            say(_line(plan, moment))

    with closing(Judge(task, plan.env, plan.evaluate_episodes)) as judge:
        train(plan, task, folder, judge, about, watch)
    print(f"policy and tables: {display_path(folder)}")


def _line(plan: Plan, moment: Any) -> str:
    """How a run stands after an evaluation."""
    evaluation = moment.evaluation
    success = paint(f"success {evaluation.success:4.0%}", "bold")
    left = (plan.steps - moment.step) / max(moment.steps_per_second, 1e-9)
    parts = (
        f"step {moment.step:{len(str(plan.steps))}}",
        success,
        f"return {evaluation.row['team_return']:7.1f}",
        f"{moment.steps_per_second:4.0f} steps/s",
        f"{left / 60.0:.0f} min left",
    )
    return "  ".join(parts)
