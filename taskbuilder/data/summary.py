"""What is in a data set, as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from statistics import fmean, median
from typing import Any

from taskbuilder.data.dataset import Dataset
from taskbuilder.data.index import success_rates


def summarize_dataset(dataset: Dataset) -> dict[str, Any]:
    """The contents of a data set: tasks, policies, lengths, success, cameras, size.

    Args:
        dataset: The data set.
    """
    about, index = dataset.about, dataset.contents
    rates = success_rates(index)
    files = [file for file in dataset.folder.rglob("*") if file.is_file()]
    return {
        "folder": str(dataset.folder),
        "format": about["format"],
        "license": about["license"],
        "episodes": len(dataset),
        "steps": sum(line["steps"] for line in index["episodes"]),
        "bytes": sum(file.stat().st_size for file in files),
        "cameras": list(about["collected"]["cameras"]),
        "depth": about["collected"]["depth"],
        "renderer": about["renderer"],
        "options": dict(about["options"]),
        "collected": dict(about["collected"]),
        "tasks": {name: _of_task(dataset, name, rates.get(name, {})) for name in dataset.tasks},
        "versions": dict(about["versions"]),
        "processor": dict(about["processor"]),
    }


def _of_task(dataset: Dataset, name: str, rates: Mapping[str, tuple[int, int]]) -> dict[str, Any]:
    task = dataset.about["tasks"][name]
    lines = [line for line in dataset.contents["episodes"] if line["task"] == name]
    variations = sorted({line["variation"] for line in lines})
    seeds = [line["seed"] for line in lines]
    return {
        "summary": task["summary"],
        "episodes": len(lines),
        "successes": sum(line["success"] for line in lines),
        "variations": {str(v): sum(line["variation"] == v for line in lines) for v in variations},
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
