"""What is in a data set, as plain data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from statistics import fmean, median
from typing import Any

from taskbuilder.data.dataset import Dataset
from taskbuilder.data.index import success_rates, variation_counts
from taskbuilder.data.layout import FAILURES, read_json
from taskbuilder.data.playing import why_not
from taskbuilder.untrusted import names_within


def summarize_dataset(dataset: Dataset) -> dict[str, Any]:
    """The contents of a data set: tasks, policies, lengths, success, cameras, size.

    Args:
        dataset: The data set.
    """
    about, index = dataset.about, dataset.contents
    rates, counts = success_rates(index), variation_counts(about, index)
    files = [dataset.folder / name for name in names_within(dataset.folder)]
    return {
        "folder": str(dataset.folder),
        "format": about["format"],
        "license": about["license"],
        "episodes": len(dataset),
        "steps": sum(line["steps"] for line in index["episodes"]),
        "bytes": sum(file.lstat().st_size for file in files),
        "cameras": list(about["collected"]["cameras"]),
        "depth": about["collected"]["depth"],
        "renderer": about["renderer"],
        "options": dict(about["options"]),
        "collected": dict(about["collected"]),
        "tasks": {
            name: {
                **_of_task(dataset, name, rates.get(name, {})),
                "variations": {str(n): c._asdict() for n, c in counts[name].items()},
            }
            for name in dataset.tasks
        },
        "versions": dict(about["versions"]),
        "processor": dict(about["processor"]),
    }


def _of_task(dataset: Dataset, name: str, rates: Mapping[str, tuple[int, int]]) -> dict[str, Any]:
    task = dataset.about["tasks"][name]
    lines = [line for line in dataset.contents["episodes"] if line["task"] == name]
    seeds = [line["seed"] for line in lines]
    return {
        "version": task.get("task_version", 1),
        "summary": task["summary"],
        "episodes": len(lines),
        "successes": sum(line["success"] for line in lines),
        "seeds": [min(seeds), max(seeds)] if seeds else [],
        "steps": {
            "median": median(line["steps"] for line in lines),
            "most": max(line["steps"] for line in lines),
        },
        "return": fmean(line["return"] for line in lines),
        "instructions": sorted({line["instruction"] for line in lines}),
        "policies": {
            policy: {"attempts": played, "successes": won, "episodes": _kept(lines, policy)}
            for policy, (won, played) in rates.items()
        },
        "robots": {
            agent: {
                "model": robot["model"],
                "action": robot["action"]["arm"],
                "action_names": robot["action_names"],
                "observation_names": robot["observation_names"],
            }
            for agent, robot in task["robots"].items()
        },
        "control_hz": task["control_hz"],
        "max_episode_steps": task["max_episode_steps"],
    }


def _kept(lines: list[Mapping[str, Any]], policy: str) -> int:
    return sum(line["policy"] == policy for line in lines)


@dataclass(frozen=True)
class MissingVariation:
    """A variation of which a data set has fewer episodes than it should.

    Attributes:
        task: Name of the task.
        variation: Its number.
        attempts: Episodes that were played.
        episodes: Those of them that were kept.
        wanted: The least number of episodes that should be there.
        reason: Why the first of the others was not kept, or "".
    """

    task: str
    variation: int
    attempts: int
    episodes: int
    wanted: int
    reason: str


def missing_variations(dataset: Dataset) -> Iterator[MissingVariation]:
    """The variations without an episode, or with fewer than were asked for of each.

    Args:
        dataset: The data set.
    """
    collected = dataset.about["collected"]
    wanted = collected["episodes"] if collected.get("per_variation") else 1
    for task, counts in variation_counts(dataset.about, dataset.contents).items():
        for variation, count in counts.items():
            if count.episodes < wanted:
                reason = _reason(dataset, task, variation)
                yield MissingVariation(task, variation, *count, wanted, reason)


def _reason(dataset: Dataset, task: str, variation: int) -> str:
    """Why the first attempt at a variation that was not kept did not succeed, or ""."""
    for line in dataset.contents["not_kept"]:
        if line["task"] == task and line.get("variation") == variation:
            return why_not(read_json(dataset.folder, f"{FAILURES}/{line['name']}.json"))
    return ""
