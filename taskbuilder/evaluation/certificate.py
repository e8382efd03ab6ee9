"""Certificates: the results of a trial, with everything needed to play it again."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from taskbuilder.digests import Digests, digest, digest_of
from taskbuilder.errors import UsageError, display_path
from taskbuilder.evaluation.arms import SUBJECT
from taskbuilder.evaluation.comparison import Arms
from taskbuilder.evaluation.results import as_data, record
from taskbuilder.files import write_whole
from taskbuilder.machine import processor, system, versions
from taskbuilder.sources import digests_of_library, digests_of_task
from taskbuilder.task import Task
from taskbuilder.untrusted import parse_json, read_plain
from taskbuilder.wording import excerpt

KIND, FORMAT = "taskbuilder certificate", 1

MOST_BYTES = 32 << 20
"""Maximum size of a certificate in bytes."""

_SECTIONS = (
    *("task", "task_version", "policy", "options", "seeds", "controls_seeds", "digests"),
    *("versions", "processor", "system", "results", "episodes"),
)
"""The sections with a seal each, so that an edited section can be named."""


@dataclass(frozen=True)
class Trial:
    """The trial of a certificate.

    Attributes:
        task: The task.
        policy: Name of the policy, as on a command line.
        policy_file: File of the policy, or None.
        options: Options of the environment, by name.
        seeds: Seeds of all episodes.
        compared: Number of first seeds that the baselines played too.
    """

    task: Task
    policy: str
    policy_file: Path | None
    options: Mapping[str, Any]
    seeds: Sequence[int]
    compared: int


def certificate_of(trial: Trial, arms: Arms, command: str) -> dict[str, Any]:
    """The certificate of a trial, as data.

    Args:
        trial: The trial.
        arms: Its episodes.
        command: The command that made it.
    """
    stages = ("", *trial.task.description.stages)
    content = {
        "kind": KIND,
        "format": FORMAT,
        "made": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": command,
        "task": trial.task.name,
        "task_version": trial.task.version,
        "policy": trial.policy,
        "options": dict(trial.options),
        "seeds": list(trial.seeds),
        "controls_seeds": trial.compared,
        "digests": sources(trial),
        "versions": versions(),
        "processor": processor(),
        "system": system(),
        "results": as_data(arms, stages),
        "episodes": {
            str(baseline): [record(r) for r in played] for baseline, played in arms.items()
        },
    }
    plain: dict[str, Any] = json.loads(json.dumps(content))  # as it will be read
    return {**plain, "seals": seals(plain)}


def sources(trial: Trial) -> dict[str, Digests]:
    """Digests of the files that determine a trial: library, task and policy."""
    file = trial.policy_file
    return {
        "library": digests_of_library(),
        "task": digests_of_task(trial.task),
        "policy": {trial.policy: digest(file.read_bytes())} if file else {},
    }


def seals(data: Mapping[str, Any]) -> dict[str, str]:
    """A digest of each section of a certificate, to detect edits."""
    return {name: digest_of(data[name]) for name in _SECTIONS if name in data}


def task_version(data: Mapping[str, Any]) -> int:
    """The version of the task; certificates from before there were any are of version 1."""
    version: int = data.get("task_version", 1)
    return version


def write_certificate(path: Path, data: Mapping[str, Any]) -> None:
    """Write a certificate atomically.

    Raises:
        OSError: It cannot be written.
    """
    write_whole(path, (json.dumps(data, indent=1) + "\n").encode())


def read_certificate(path: Path) -> dict[str, Any]:
    """Read a certificate, without trusting its contents.

    Raises:
        UsageError: It is damaged, not a certificate, or of another version.
        OSError: It cannot be read, is too large, or is a device or a FIFO.
    """
    name = display_path(path)
    content = read_plain(path, MOST_BYTES)
    try:
        data = parse_json(content)
    except ValueError as error:
        raise UsageError(f"{name} is damaged, or no certificate ({error})") from None
    if not isinstance(data, dict) or data.get("kind") != KIND:
        raise UsageError(f"{name} is no certificate; evaluate --certificate FILE writes one")
    if data.get("format") != FORMAT:
        version = excerpt(data.get("format"))
        raise UsageError(f"{name} has format {version}; this version reads {FORMAT}")
    if wrong := next(_misshapen(data), None):
        raise UsageError(f"{name} is damaged: {wrong}")
    return data


def _misshapen(data: Mapping[str, Any]) -> Iterator[str]:
    """What is missing or malformed in a certificate."""
    shapes = {
        **dict.fromkeys(("task", "policy", "made"), str),
        **dict.fromkeys(("options", "digests", "versions", "processor", "system"), dict),
        **dict.fromkeys(("results", "episodes", "seals"), dict),
        "seeds": list,
        "controls_seeds": int,
    }
    for name, shape in shapes.items():
        if not isinstance(data.get(name), shape):
            yield f"it has no {name}"
            return
    if type(data.get("task_version", 1)) is not int:
        yield "its task_version is no whole number"
    keys = {"kind", "format", "command", "task_version", *shapes}
    yield from (f"it has {excerpt(name)}, which no certificate has" for name in {*data} - keys)
    seeds, compared = data["seeds"], data["controls_seeds"]
    if not seeds or not all(type(seed) is int and seed >= 0 for seed in seeds):
        yield "its seeds are no whole numbers"
    if isinstance(compared, bool) or not 0 <= compared <= len(seeds):
        yield f"controls_seeds is {compared}, and it has {len(seeds)} seeds"
    for name in ("library", "task", "policy"):
        if not isinstance(data["digests"].get(name), dict):
            yield f"it has no digests of the {name}"
    for name, listed in data["episodes"].items():
        if not isinstance(listed, list) or not all(isinstance(each, dict) for each in listed):
            yield f"the episodes of {excerpt(name)} are no list of records"
        elif len(listed) > len(seeds):
            yield f"it has {len(listed)} episodes of {excerpt(name)} and {len(seeds)} seeds"
    if len(data["episodes"].get(str(SUBJECT), ())) != len(seeds):
        yield "it does not have an episode for each seed"
