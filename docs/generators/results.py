"""Measured results, from the files that the benchmarks and the validator wrote."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from taskbuilder.learn.zoo import load_policy, zoo_names
from taskbuilder.reference.markdown import table

RESULTS = Path(__file__).parents[2] / "benchmarks" / "results"


def probes(task: str) -> str:
    """What ways of playing a task earn, the best first."""
    report = next(report for report in _read("proofs.json")["tasks"] if report["task"] == task)
    ways = sorted(report["probes"], key=lambda way: -way["return"])
    return table(
        ["", "return", "discounted by 0.95"],
        (
            [way["name"], _signed(way["return"]), _signed(way["discounted_return"])]
            for way in ways
            if not way["name"].startswith(("drop", "throw"))
        ),
    )


def experts(_: str) -> str:
    """How reliably and how soon experts do their tasks."""
    rows = []
    for scene, found in _read("experts.json")["scenes"].items():
        task, _, variation = scene.partition("/")
        low, high = (100.0 * bound for bound in found["interval"])
        rows.append(
            [
                task,
                variation,
                f"{found['solved']} of {found['episodes']} ({low:.1f}–{high:.1f} %)",
                f"{found['at_end']} of {found['episodes']}",
                f"{found['first_success_median']:g}, at most {found['first_success_last']}",
                f"{found['peak_force_largest']:.0f} N",
                f"{found['planning_median_s']:.2f} s",
            ]
        )
    head = ["task", "variation", "succeeds", "still at the last step"]
    head += ["after control steps, median", "force between robots, largest", "planning, median"]
    return table(head, rows)


def learning(_: str) -> str:
    """What came of the learning runs."""
    rows = []
    for run in _read("learning.json")["runs"]:
        low, high = (100.0 * bound for bound in run["interval"])
        rows.append(
            [
                run["task"],
                run["track"],
                str(run["seed"]),
                {"scene": "the whole scene", "task": "as the task says"}[run["observe"]],
                f"{run['steps']:,}",
                f"{100.0 * run['success_rate']:.1f} % ({low:.1f}–{high:.1f} %)",
                _stages(run["stages"]),
                f"{run['minutes']:.0f}",
            ]
        )
    if not rows:
        return "No run is kept yet."
    head = ["task", "track", "seed", "policies see", "control steps", "success (95 % interval)"]
    return table([*head, "furthest stage", "minutes"], rows)


def _stages(stages: dict[str, int]) -> str:
    """How many episodes got how far and no further, the furthest first."""
    reached = [f"{name or 'none'} {count}" for name, count in stages.items() if count]
    return ", ".join(reversed(reached))


def zoo(_: str) -> str:
    """The policies that come with the package, what they achieve, and what made them."""
    rows, commands = [], []
    runs = {run["run"]: run for run in _read("learning.json")["runs"]}
    measured = _read("zoo.json")
    for name in zoo_names():
        about = load_policy(name).about
        run = runs[f"{about['task']}-{about['track']}-{about['seed']}"]
        found = measured["policies"][name]
        low, high = (100.0 * bound for bound in found["interval"])
        rows.append(
            [
                f"`{name}`",
                f"{about['step']:,}",
                f"{found['successes']} of {found['episodes']} ({low:.1f}–{high:.1f} %)",
                f"{100.0 * found['success_at_end_rate']:.1f} %",
                f"{found['peak_robot_force']['median']:.0f} N",
                f"{100.0 * run['success_rate']:.1f} %",
            ]
        )
        commands.append(run["command"])
    if not rows:
        return "None yet."
    head = ["policy", "control steps", "success that lasts (95 % interval)", "at the last step"]
    head += ["force between robots, median peak", "success for a moment, as trained for"]
    made = "\n".join(["Made by", "", "```text", *commands, "```"])
    asked = f"Measured by `{measured['command']}`, for as many episodes as the table says."
    return f"{table(head, rows)}\n\n{asked}\n\n{made}"


def _read(name: str) -> Any:
    return json.loads((RESULTS / name).read_text(encoding="utf-8"))


def _signed(value: float) -> str:
    return f"{value:.1f}".replace("-", "−")
