"""`taskbuilder dataset`."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

from taskbuilder.cli.output import (
    can_ask,
    confirmed,
    paint,
    print_json,
    print_table,
    progress,
    warn,
)
from taskbuilder.cli.tasks import catalogue_of, make_folder
from taskbuilder.data.checking import CheckResult, check_dataset
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.environment import make_from, tasks_to_trust, where_carried
from taskbuilder.data.formats import ExportOptions, export_dataset
from taskbuilder.data.names import FORMAT_NAMES
from taskbuilder.data.summary import summarize_dataset
from taskbuilder.errors import UsageError, display_path
from taskbuilder.rollout.play import play
from taskbuilder.rollout.players import RecordedActions
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.summaries import summarize
from taskbuilder.visual.film import save_film
from taskbuilder.wording import printable


def run(arguments: argparse.Namespace) -> int:
    """Show, check, film or export a data set."""
    actions = {"info": _info, "check": _check, "film": _film, "export": _export}
    return actions[arguments.action](arguments)


# --- info


def _info(arguments: argparse.Namespace) -> int:
    told = summarize_dataset(load_dataset(arguments.folder))
    catalogue = catalogue_of(arguments)
    for name, task in told["tasks"].items():
        entry = catalogue.tasks.get(name)
        task["version_here"] = summarize(entry, catalogue).version if entry else None
    if arguments.json:
        print_json(told)
    else:
        print_summary(told)
    return 0


def print_summary(told: Mapping[str, Any]) -> None:
    """Print what is in a data set, for people.

    Args:
        told: As `summarize_dataset` has it.
    """
    print(paint(told["folder"], "bold"))
    rows = [
        ["episodes", f"{told['episodes']} ({told['steps']:,} control steps)"],
        ["size", _size(told["bytes"])],
        ["licence", told["license"]],
    ]
    if told["cameras"]:
        kinds = "colour and depth" if told["depth"] else "colour"
        cameras = ", ".join(told["cameras"])
        rows.append(["cameras", f"{cameras} ({kinds}, renderer {told['renderer']})"])
    if told["options"]:
        rows.append(["options", ", ".join(f"{n}: {v}" for n, v in told["options"].items())])
    print_table(rows, indent="  ")
    for name, task in told["tasks"].items():
        print()
        print(f"{paint(name, 'bold')}: {task['summary']}")
        print_table(_task_rows(task), indent="  ")


def _task_rows(task: Mapping[str, Any]) -> list[list[str]]:
    steps, seeds = task["steps"], task["seeds"]
    robots = [
        f"{agent} ({r['model']}, {r['action']}: {len(r['action_names'])} numbers; observes "
        f"{len(r['observation_names'])})"
        for agent, r in task["robots"].items()
    ]
    policies = [
        f"{name}: {p['episodes']} episodes, {p['successes']} of {p['attempts']} attempts succeeded"
        for name, p in task["policies"].items()
    ]
    variations = [
        f"{number}: {of['episodes']} episodes, {of['attempts']} attempts"
        for number, of in task["variations"].items()
    ]
    return [
        ["episodes", f"{task['episodes']}, {task['successes']} with success"],
        *(["policy", line] for line in policies),
        *(["robot", line] for line in robots),
        *(["variation", line] for line in variations),
        ["seeds", f"{seeds[0]} to {seeds[1]}"],
        ["steps", f"median {steps['median']:g}, at most {steps['most']}; {task['control_hz']} Hz"],
        ["version", _version(task)],
        ["return", f"mean {task['return']:.2f}"],
        ["instructions", f"{len(task['instructions'])}, such as: {task['instructions'][0]}"],
    ]


def _version(task: Mapping[str, Any]) -> str:
    """The version of the task, and that of today where it is another one."""
    here = task.get("version_here")
    other = here is not None and here != task["version"]
    return f"{task['version']}; the task here has version {here}" if other else f"{task['version']}"


def _size(count: int) -> str:
    return f"{count / 1e6:.1f} MB" if count < 1e9 else f"{count / 1e9:.2f} GB"


# --- check


def _check(arguments: argparse.Namespace) -> int:
    catalogue = catalogue_of(arguments)
    trust = bool(arguments.replay) and _trust(arguments, catalogue)
    result = check_dataset(arguments.folder, arguments.replay, catalogue=catalogue, trust=trust)
    if arguments.json:
        print_json({"ok": result.ok, **asdict(result)})
    else:
        _print_check(result)
    return 0 if result.ok else 1


def _print_check(result: CheckResult) -> None:
    for line in result.damaged:
        print(f"  {paint('damaged', 'red')}  {printable(line)}")
    if result.damaged:
        print(f"{len(result.damaged)} of {result.files} files are not as they were written")
        return
    print(f"{result.files} files are as they were written")
    for line in result.invalid:
        print(f"  {paint('invalid', 'red')}  {printable(line)}")
    if result.invalid:
        return
    if result.unplayed:
        print(f"no episode could be played again: {result.unplayed}")
        print("give --replay 0 to check the files alone")
    differs = result.differs or {}
    for name, said in differs.items():
        print(f"  {name}: {said}")
    if result.replayed:
        same = len(result.replayed) - len(differs)
        print(f"{same} of {len(result.replayed)} episodes played again are the same to the bit")
    if differs and result.elsewhere:
        print("this is no sign of damage, because something else is not the same here:")
    for line in result.elsewhere if differs or result.unplayed else ():
        print(f"  {line}")


def _trust(
    arguments: argparse.Namespace, catalogue: Catalogue, task: str | None = None
) -> bool | str:
    """What --trust says, or the answer of whoever sits at the terminal."""
    if arguments.trust or not can_ask():
        return arguments.trust or False
    about = load_dataset(arguments.folder).about
    tasks = tasks_to_trust(about, arguments.folder, catalogue, task)
    for carried in tasks:
        where = where_carried(arguments.folder, carried)
        question = (
            f"The task {carried.name} comes with the data set. It is a Python program of whoever "
            f"made the data set ({where}, SHA-256 {carried.digest}). Run it?"
        )
        if not confirmed(question):
            return False
    return bool(tasks)


# --- film


def _film(arguments: argparse.Namespace) -> int:
    if arguments.episode is None:
        raise UsageError("which episode? give its number by --episode, from 0")
    dataset = load_dataset(arguments.folder)
    if arguments.episode >= len(dataset):
        raise UsageError(
            f"{display_path(arguments.folder)} has {len(dataset)} episodes, numbered from 0"
        )
    episode = dataset[arguments.episode]
    catalogue = catalogue_of(arguments)
    trust = _trust(arguments, catalogue, episode.task)
    out: Path = arguments.out or Path("films")
    env = make_from(
        arguments.folder,
        task=episode.task,
        variation=episode.variation,
        cameras=False,
        catalogue=catalogue,
        trust=trust,
    )
    with closing(env):
        env.task.file.check_cameras(arguments.cameras, episode.variation)
        make_folder(out)
        rollout = play(env, RecordedActions(episode.actions), episode.seed)
        files = save_film(
            env,
            rollout,
            arguments.cameras,
            out / episode.name,
            size=arguments.size,
            progress=lambda frames, count: progress(frames, "filming", count),
        )
    names = [display_path(file) for file in files]
    if arguments.json:
        print_json({"episode": episode.name, "files": names})
    else:
        print("\n".join(names))
    return 0


# --- export


def _export(arguments: argparse.Namespace) -> int:
    if not arguments.export:
        raise UsageError(f"which format? give --format with one of {', '.join(FORMAT_NAMES)}")
    if not arguments.out:
        raise UsageError("where to? name a new folder by --out")
    dataset = load_dataset(arguments.folder)
    options = ExportOptions(arguments.pictures, arguments.language, warn)
    out = export_dataset(dataset, arguments.export, arguments.out, options)
    told = {"format": arguments.export, "folder": display_path(out), "episodes": len(dataset)}
    if arguments.json:
        print_json(told)
    else:
        print(f"{len(dataset)} episodes in {display_path(out)}")
    return 0
