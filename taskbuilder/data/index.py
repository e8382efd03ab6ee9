"""The index of a data set: a line for every episode, and the failed attempts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from taskbuilder.data.layout import FAILURES, read_episode, read_json

_SHOWN = (
    *("name", "task", "seed", "variation", "policy", "instruction"),
    *("steps", "success", "success_at_end", "return"),
)

_NOT_KEPT = ("name", "task", "variation", "policy")


def make_index(folder: Path, names: Sequence[str], failed: Sequence[str]) -> dict[str, Any]:
    """The index of a data set.

    Args:
        folder: Of the data set.
        names: The episodes, in order.
        failed: Files of the attempts that were not kept.
    """
    abouts = (read_episode(folder, name) for name in names)
    lost = [read_json(folder, f"{FAILURES}/{name}") for name in failed]
    return {
        "episodes": [{key: about[key] for key in _SHOWN} for about in abouts],
        "not_kept": [{key: about[key] for key in _NOT_KEPT} for about in lost],
    }


def success_rates(index: Mapping[str, Any]) -> dict[str, dict[str, tuple[int, int]]]:
    """By task and policy: the attempts that succeeded, and all attempts."""
    rates: dict[str, dict[str, tuple[int, int]]] = {}
    outcomes = [(each, bool(each["success"])) for each in index["episodes"]]
    for each, success in (*outcomes, *((each, False) for each in index["not_kept"])):
        of_task = rates.setdefault(each["task"], {})
        won, played = of_task.get(each["policy"], (0, 0))
        of_task[each["policy"]] = (won + success, played + 1)
    return rates


class VariationCount(NamedTuple):
    """What came of the attempts at one variation of a task.

    Attributes:
        attempts: Episodes that were played.
        episodes: Those of them that were kept.
    """

    attempts: int
    episodes: int


def variation_counts(
    about: Mapping[str, Any], index: Mapping[str, Any]
) -> dict[str, dict[int, VariationCount]]:
    """The attempts and the kept episodes by task and variation; also of variations without any.

    Args:
        about: What the data set says of itself.
        index: Its index.
    """
    asked = about["collected"]["variations"]
    counts: dict[str, dict[int, VariationCount]] = {}
    for name, task in about["tasks"].items():
        numbers = range(task["variations"]) if asked == "all" else asked
        counts[name] = dict.fromkeys(numbers, VariationCount(0, 0))
    for lines, kept in ((index["episodes"], 1), (index["not_kept"], 0)):
        for line in lines:
            if line["task"] in counts and "variation" in line:
                of_task, number = counts[line["task"]], line["variation"]
                before = of_task.get(number, VariationCount(0, 0))
                of_task[number] = VariationCount(before.attempts + 1, before.episodes + kept)
    return counts
