"""The index of a data set: a line for every episode, and the failed attempts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from taskbuilder.data.layout import EPISODES, FAILURES, read_episode, read_json

_SHOWN = (
    *("name", "task", "seed", "variation", "policy", "instruction"),
    *("steps", "success", "success_at_end", "return"),
)


def make_index(folder: Path, names: Sequence[str], failed: Sequence[str]) -> dict[str, Any]:
    """The index of a data set.

    Args:
        folder: Of the data set.
        names: The episodes, in order.
        failed: Files of the attempts that were not kept.
    """
    abouts = (read_episode(folder / EPISODES / name) for name in names)
    lost = [read_json(folder / FAILURES / name) for name in failed]
    return {
        "episodes": [{key: about[key] for key in _SHOWN} for about in abouts],
        "not_kept": [{key: about[key] for key in ("name", "task", "policy")} for about in lost],
    }


def success_rates(index: Mapping[str, Any]) -> dict[str, dict[str, tuple[int, int]]]:
    """By task and policy: the attempts that succeeded, and all attempts."""
    found: dict[str, dict[str, tuple[int, int]]] = {}
    outcomes = [(each, bool(each["success"])) for each in index["episodes"]]
    for each, success in (*outcomes, *((each, False) for each in index["not_kept"])):
        of_task = found.setdefault(each["task"], {})
        won, played = of_task.get(each["policy"], (0, 0))
        of_task[each["policy"]] = (won + success, played + 1)
    return found
