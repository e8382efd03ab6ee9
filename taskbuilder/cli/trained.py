"""Trained policies on the command line: which they are, where they play, what they came from."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from taskbuilder.cli.output import can_ask, confirmed
from taskbuilder.policies.runs import RUN_FILE, task_to_trust
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.wording import excerpt

_OBSERVED = {
    "scene": "the whole scene, more than the task file lists for each robot",
    "task": "what the task file lists for each robot",
}
_SAID = ("observe", "frame", "grasp")
"""Options of a policy's environment that are printed, where they are recorded."""

_HELPED = {
    "scratch": "no demonstrations, no special starts",
    "resets": "episodes that may begin in states of the expert, no demonstrations",
    "finetuned": "a trained policy to start from",
    "demos": "demonstrations of the expert",
    "cloned": "recorded episodes alone",
    "distilled": "recorded episodes of a trained policy alone",
}


def trusts(arguments: argparse.Namespace, run: str | Path | None, catalogue: Catalogue) -> bool:
    """Whether the task of a run may be run: what --trust says, or who sits at the terminal.

    Args:
        arguments: The command line.
        run: The folder of a run; what is none needs no trust.
        catalogue: Where its task is looked up.
    """
    if arguments.trust or not can_ask() or not run or not (Path(run) / RUN_FILE).is_file():
        return bool(arguments.trust)
    file = task_to_trust(Path(run), catalogue)
    return file is not None and confirmed(
        f"The run is of the task {excerpt(file)}, which is not in the catalogue. It is a Python "
        "program. Run it?"
    )


def origin(about: Mapping[str, Any]) -> list[list[str]]:
    """What a policy observes and how it was trained: rows of a word and a text to print."""
    return [[word, excerpt(text)] for word, text in _origin(about)]


def _origin(about: Mapping[str, Any]) -> list[list[str]]:
    track = about.get("track")
    helped = _HELPED.get(str(track), "not known what helped")
    if about.get("starts") and track != "resets":
        helped += ", episodes that may begin in its states"
    step, unit = about.get("step"), "updates" if about.get("data") else "control steps"
    trained = [
        f"{about.get('algorithm')} {_source(about)}",
        f"{step:,} {unit}" if isinstance(step, int) else f"unknown {unit}",
        f"seed {about.get('seed')}",
    ]
    rows = [
        *_observed(about.get("env", {})),
        ["track", f"{track}: {helped}"],
        ["trained", " · ".join(trained)],
    ]
    return [*rows, ["command", str(about["command"])]] if about.get("command") else rows


def _observed(env: Mapping[str, Any]) -> list[list[str]]:
    """What a policy observes, in words, and the options of its environment."""
    if env.get("cameras"):
        width, height = env["camera_size"]
        drawn = f"{width}x{height}, renderer {env.get('renderer')}"
        saw = f"pictures of {', '.join(env['cameras'])} ({drawn}), its own robot, the time left"
        return [["observed", saw]]
    options = ", ".join(f"{name}: {env[name]}" for name in _SAID if name in env)
    saw = _OBSERVED.get(str(env.get("observe")), "not known")
    return [["observed", saw], ["options", options or "not known"]]


def _source(about: Mapping[str, Any]) -> str:
    """What a policy was trained by: a data set, or a reward."""
    if about.get("data"):
        teachers = ", ".join(about.get("teachers", ()))
        return f"from the data set {about['data']}" + (f" of {teachers}" if teachers else "")
    return f"with the reward {about.get('reward')}"
