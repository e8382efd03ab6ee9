"""`taskbuilder train`."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from taskbuilder.cli.env_options import asked_options
from taskbuilder.cli.output import paint, progress, say
from taskbuilder.cli.spreading import spread_over
from taskbuilder.cli.tasks import catalogue_of, make_folder
from taskbuilder.cli.trained import trusts
from taskbuilder.env.options import flag_of, option_infos
from taskbuilder.errors import UsageError, display_path
from taskbuilder.learn import run_folders, runs
from taskbuilder.learn.demonstrations import DEMONSTRATIONS_FILE
from taskbuilder.learn.expert_waits import has_to_measure
from taskbuilder.learn.plan import Plan
from taskbuilder.learn.recordings import unlike_recorded
from taskbuilder.learn.run_setup import RunSetup
from taskbuilder.policies.runs import RUN_FILE
from taskbuilder.rollout.progress import EPISODES
from taskbuilder.rollout.record import Rollout
from taskbuilder.task import other_version

if TYPE_CHECKING:  # loads PyTorch
    from taskbuilder.learn.checkpoint_evaluator import Evaluation
    from taskbuilder.learn.training import TrainingStatus


def run(arguments: argparse.Namespace) -> int:
    """Train, or go on training, and say how it goes."""
    if arguments.resume:
        runs.check_torch()
        _check_alone(arguments)
        catalogue = catalogue_of(arguments)
        trust = trusts(arguments, arguments.resume, catalogue)
        found = runs.find(arguments.resume, catalogue, trust=trust)
        with run_folders.locked(arguments.resume, new=False):
            _go_on(arguments.resume, found)
        return 0
    seeds = list(dict.fromkeys(arguments.seed or [0]))
    each = [_of_seed(arguments, seed, alone=len(seeds) == 1) for seed in seeds]
    for one in each:  # what is wrong with one is told before any begins
        planned = _planned(one)
        one.out = _new_folder(one, planned)
    if len(each) == 1 and not arguments.ray:
        _begin(each[0], planned)
        return 0
    with spread_over(arguments, len(each), default=1) as spread:
        for _ in spread(_train_one, each):
            pass
    return 0


def _of_seed(arguments: argparse.Namespace, seed: int, *, alone: bool) -> argparse.Namespace:
    """What one run of several is asked for, in a form that other processes can be told."""
    names = [*Plan("").values, "out", "set", "task_path", "words"]
    one = {name: getattr(arguments, name) for name in names if hasattr(arguments, name)}
    if arguments.out and not alone:
        one["out"] = arguments.out.with_name(f"{arguments.out.name}-{seed}")
    return argparse.Namespace(**{**one, "seed": seed})


def _new_folder(arguments: argparse.Namespace, planned: RunSetup) -> Path:
    """The folder of a run that can begin.

    Raises:
        UsageError: It cannot.
    """
    folder: Path = arguments.out or run_folders.default_folder(planned)
    run_folders.check_new(folder)
    make_folder(folder)
    return folder


def _train_one(arguments: argparse.Namespace) -> None:
    """Train, or go on after a process was lost that had begun to."""
    folder: Path = arguments.out
    if (folder / RUN_FILE).exists():
        found = runs.find(folder, catalogue_of(arguments), trust=True)  # this command has begun it
        with run_folders.locked(folder, new=False):
            _go_on(folder, found)
        return
    _begin(arguments, _planned(arguments))


def _begin(arguments: argparse.Namespace, planned: RunSetup) -> None:
    """Train from the start."""
    folder, catalogue = arguments.out, catalogue_of(arguments)
    if planned.dataset is not None:
        for difference in unlike_recorded(planned.dataset, planned.plan.options):
            say(f"on request: {difference}")
        about = planned.dataset.about["tasks"][planned.task.name]
        if other := other_version(about, planned.task):
            say(f"the data set is of another version of the task: {other}")
    with run_folders.locked(folder, new=True):
        command = shlex.join(["taskbuilder", *arguments.words])
        if has_to_measure(planned):
            say(f"the expert plays {EPISODES} episodes, to measure how long it waits")
        planned = runs.create(folder, planned, command=command, catalogue=catalogue, track=_track)
        if planned.waits is not None:
            say(f"{'careful: ' * bool(planned.waits.cut)}{planned.waits}")
        _go_on(folder, planned)


def _check_alone(arguments: argparse.Namespace) -> None:
    """Refuse changes to a run that has begun.

    Raises:
        UsageError: There is more beside --resume.
    """
    names = [*Plan("").values, "out", "set", "jobs", "ray"]
    given = [name for name in names if getattr(arguments, name, None) is not None]
    if given:
        flags = {name: flag_of(name) for name in option_infos()} | {"task": "TASK"}
        words = [flags.get(name, f"--{name.replace('_', '-')}") for name in given]
        raise UsageError(f"--resume goes on as the run began; leave {' and '.join(words)} out")


def _planned(arguments: argparse.Namespace) -> RunSetup:
    names = Plan("").values.keys() - {"settings", "task"}
    given = {name: value for name, value in vars(arguments).items() if name in names}
    given |= asked_options(arguments, ("scene", "observed"))
    catalogue = catalogue_of(arguments)
    return runs.set_up(arguments.task, arguments.set or (), catalogue=catalogue, **given)


def _track(episodes: Iterable[Rollout], count: int) -> list[Rollout]:
    """Demonstrations with a bar, and how many are good."""
    played = list(progress(episodes, "expert episodes", total=count))
    good = sum(episode.success for episode in played)
    say(f"expert: {good} of {count} episodes succeeded; in {DEMONSTRATIONS_FILE}")
    return played


def _go_on(folder: Path, run: RunSetup) -> None:
    def watch(status: TrainingStatus) -> None:
        if status.evaluation is not None:
            say(_line(run.plan, status, status.evaluation))

    runs.go_on(folder, run, watch)
    print(f"policy and tables: {display_path(folder)}")


def _line(plan: Plan, status: TrainingStatus, evaluation: Evaluation) -> str:
    """How a run stands after an evaluation."""
    success = paint(f"success {evaluation.row['success_rate']:4.0%}", "bold")
    left = max(0, plan.steps - status.step) / max(status.steps_per_second, 1e-9)
    parts = (
        f"step {status.step:{len(str(plan.steps))}}",
        success,
        f"at the end {evaluation.success_at_end:4.0%}",
        f"return {evaluation.row['team_return']:7.1f}",
        f"{status.steps_per_second:4.0f} steps/s",
        f"{left / 60.0:.0f} min left",
    )
    return "  ".join(parts)
