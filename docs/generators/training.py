"""Results of training runs, from the files that the benchmarks wrote."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from generators.results import read, signed
from generators.tasks import title
from taskbuilder import load_suite
from taskbuilder.learn.logs import read_run
from taskbuilder.policies.zoo import load_policy, zoo_names
from taskbuilder.reference.markdown import table

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from kept_runs import unpacked

PHASE = 5_000
"""Training episodes in a row of the tables on the paper's learner."""

NONE = "–"
"""In a table, for what was not measured."""

DASH = "A dash means that the policies were not evaluated in this way. "
"""Below a table with `NONE`."""

RATCHET = ("handover-1-saturated", "handover-2-saturated")
"""Trials with the reward `ratchet` and with the settings of the ablation's other runs."""

PAPER = sorted(load_suite("seed").tasks)
"""The tasks of the paper."""

ALGORITHMS = {
    ("maddpg", "scratch"): "MADDPG (`maddpg`)",
    ("ppo", "mappo"): "MAPPO (`ppo`, preset `mappo`)",
    ("ppo", "ippo"): "independent PPO (`ppo`, preset `ippo`)",
}
"""Algorithms of the comparison, by name and preset."""

OBSERVED = {"scene": "the whole scene", "task": "as the task lists"}
"""What policies observe, by the option `observe`."""

COMPARED_SEEDS = 2
"""Seeds of each task and algorithm in the comparison: the first that are kept."""

TRAINED = (
    ("MADDPG, 200 demonstrations", "scene", "learning.json", {"preset": "demos"}),
    ("MADDPG, from scratch", "scene", "learning.json", {"preset": "scratch"}),
    ("MAPPO, from scratch", "scene", "learning.json", {"preset": "mappo"}),
    ("independent PPO, from scratch", "scene", "learning.json", {"preset": "ippo"}),
    ("distilled from MADDPG, from scratch", "task", "distillation.json", {}),
    ("MADDPG, from scratch", "task", "learning.json", {"preset": "scratch"}),
)
"""Ways of training: what policies observe, the file of the runs, and what they have in common."""

WAYS = {
    "team": "team reward",
    "local": "local rewards",
    "shaped": "team reward, shaped by progress",
    "wrong_order": "team reward, small handover bonus",
    "demos": "team reward, 200 demonstrations",
    "ratchet": "progress only (ratchet)",
    "own": "progress only, own observations",
}
"""Ways of training in the ablation of Handover."""

LONGER = {
    "team_long": "from the task's own initial states",
    "starts_long": "half of the training episodes from states of the expert",
}
"""Longer runs with the team reward, by where training episodes start."""


def lasting(_: str) -> str:
    """Success at the last step of the tasks of the paper, every seed, by way of training."""
    cloned = [
        {"task": run["task"], **played}
        for run in read("robust_cloning.json")["runs"]
        for played in run["evaluations"].get("fresh", ())
    ]
    rows = [["behaviour cloning, 600 demonstrations", OBSERVED["scene"], *_each_seed(cloned)]]
    for way, observe, file, common in TRAINED:
        same = {**common, "observe": observe}.items()
        runs = [run for run in read(file)["runs"] if same <= run.items()]
        rows.append([way, OBSERVED[observe], *_each_seed(runs)])
    return table(["learned by", "policies observe", *map(title, PAPER)], rows)


def _each_seed(runs: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Success at the last step in percent, every seed, one task after the other."""
    for task in PAPER:
        rates = [100.0 * run["success_at_end_rate"] for run in runs if run["task"] == task]
        yield " · ".join(f"{rate:.1f}".removesuffix(".0") for rate in rates) or NONE


def learning(which: str) -> str:
    """Runs of `maddpg`, by whether the paper has their tasks, or trials and earlier runs.

    Args:
        which: "" for the tasks of the paper, "library" for the other tasks, "earlier" for the runs
            under the earlier definition of success, or the last word of the trials' names.
    """
    earlier = which == "earlier"
    if earlier:
        runs = read("learning_earlier.json")["runs"]
    elif which in ("", "library"):
        kept = [run for run in read("learning.json")["runs"] if run["algorithm"] == "maddpg"]
        runs = [run for run in kept if (run["task"] in PAPER) == (which == "")]
    else:
        trials = read("learning_trials.json")["runs"]
        runs = [run for run in trials if run["run"].endswith(f"-{which}")]
    rows = [
        [
            run["task"],
            run["track"],
            str(run["seed"]),
            OBSERVED[run["observe"]],
            *_outcome(run, at_end=not earlier),
        ]
        for run in runs
    ]
    if not rows:
        return "No run is kept yet."
    head = ["task", "track", "seed", "policies observe", "control steps", "success (95 % interval)"]
    head += [] if earlier else ["success at the last step"]
    return table([*head, "furthest stage", "minutes"], rows)


def algorithms(_: str) -> str:
    """Runs from scratch that observe the whole scene, by task and algorithm."""
    kept = read("learning.json")["runs"]
    kept = [run for run in kept if run["track"] == "scratch" and run["observe"] == "scene"]
    rows = []
    for task in PAPER:
        for key, name in ALGORITHMS.items():
            runs = [run for run in kept if run["task"] == task]
            runs = [run for run in runs if (run["algorithm"], run["preset"]) == key]
            rows += [
                [task, name, str(run["seed"]), *_outcome(run)]
                for run in sorted(runs, key=lambda run: run["seed"])[:COMPARED_SEEDS]
            ]
    head = ["task", "algorithm", "seed", "control steps", "success (95 % interval)"]
    return table([*head, "success at the last step", "furthest stage", "minutes"], rows)


def whole_scene(_: str) -> str:
    """Behaviour cloning in tasks whose fixed objects are placed at random."""
    rows = [
        [
            title(run["task"]),
            OBSERVED[run["observe"]],
            f"{run['demonstrations']}",
            f"{run['updates']:,}",
            f"{run['successes']} of {run['episodes']}",
        ]
        for run in read("whole_scene.json")["runs"]
    ]
    head = ["task", "policies observe", "demonstrations", "updates", "episodes with success"]
    return table(head, rows)


def recovery(_: str) -> str:
    """Behaviour cloning from demonstrations with and without recovery, by preset."""
    rows = [
        [
            title(run["task"]),
            f"`{run['demonstrator']}`",
            f"`{' '.join(filter(None, [run['preset'], run['setting']]))}`",
            f"{run['successes_at_end']} of {run['episodes']}",
        ]
        for run in read("recovery.json")["policies"]
    ]
    return table(["task", "demonstrations by", "preset", "success at the last step"], rows)


def distillation(_: str) -> str:
    """Students of policies that were learned from scratch, every seed."""
    rows = []
    for run in read("distillation.json")["runs"]:
        (played,) = run["teacher"].values()
        taught = f"{played['successes']} of {played['attempts']}"
        rows.append(
            [run["task"], str(run["seed"]), taught, OBSERVED[run["observe"]], *_outcome(run)]
        )
    head = ["task", "seed", "teacher's episodes with success", "student observes", "updates"]
    head += ["success (95 % interval)", "success at the last step", "furthest stage", "minutes"]
    return table(head, rows)


def deadlock(which: str) -> str:
    """What each way of training Handover came to: in the ablation, or in the `longer` runs."""
    tables = {"": (WAYS, "way of training"), "longer": (LONGER, "training episodes start")}
    names, first = tables[which]
    rows = [
        [
            names[way],
            str(run["seed"]),
            f"{run['steps']:,}",
            _success(run),
            f"{100.0 * _handed_over(run):.1f} %",
            _stages(run["stages"]),
        ]
        for way, runs in ablation(names).items()
        for run in runs
    ]
    head = [first, "seed", "control steps", "success (95 % interval)"]
    return table([*head, "handed over", "furthest stage"], rows)


def ablation(ways: Iterable[str] = WAYS) -> dict[str, list[dict[str, Any]]]:
    """The runs of Handover by way of training, in the order of `ways`.

    Ways without a run are left out.
    """
    kept = {"ratchet": ("learning_trials.json", RATCHET)}
    found = {}
    for way in ways:
        file, names = kept.get(way, ("deadlock.json", (f"{way}-1", f"{way}-2")))
        found[way] = [run for run in read(file)["runs"] if run["run"] in names]
    return {way: runs for way, runs in found.items() if runs}


def _outcome(run: Mapping[str, Any], *, at_end: bool = True) -> list[str]:
    """Control steps, success, success at the last step, furthest stage and minutes of a run."""
    kept = [f"{100.0 * run['success_at_end_rate']:.1f} %"] if at_end else []
    steps, minutes = f"{run['steps']:,}", f"{run['minutes']:.0f}"
    return [steps, _success(run), *kept, _stages(run["stages"]), minutes]


def _success(run: Mapping[str, Any]) -> str:
    """A success rate with its interval."""
    return f"{100.0 * run['success_rate']:.1f} % {_interval(run)}"


def _interval(run: Mapping[str, Any]) -> str:
    low, high = (100.0 * bound for bound in run["interval"])
    return f"({low:.1f}–{high:.1f} %)"


def _handed_over(run: Mapping[str, Any]) -> float:
    """The share of episodes in which only the right arm held the stick at some time."""
    counts = run["stages"]
    reached = list(counts)[list(counts).index("handed over") :]
    return sum(counts[stage] for stage in reached) / sum(counts.values())


def cloning(_: str) -> str:
    """The results of behaviour cloning, every seed."""
    found = read("cloning.json")
    rows = [
        [
            run["task"],
            _inputs(run),
            str(run["seed"]),
            f"{run['demonstrations']}",
            f"{run['updates']:,}",
            _success(run),
            _stages(run["stages"]),
            f"{run['minutes']:.0f}",
        ]
        for run in found["runs"]
    ]
    head = ["task", "inputs", "seed", "demonstrations", "updates", "success (95 % interval)"]
    episodes = {run["episodes"] for run in found["runs"]}
    count = ", ".join(map(str, sorted(episodes)))
    told = (
        f"Each policy was evaluated in {count} episodes, with seeds from 2000000. The column "
        "*minutes* shows how long the training run took on one core, including its evaluations."
    )
    return f"{table([*head, 'furthest stage', 'minutes'], rows)}\n\n{told}"


def _inputs(run: Mapping[str, Any]) -> str:
    """What a policy observes."""
    size = run.get("picture_size")
    return f"{run['inputs']}, {size}×{size}" if size else str(run["inputs"])


def robust(_: str) -> str:
    """The results of cloning from demonstrations of every variation."""
    found = read("robust_cloning.json")
    rows = [
        [
            run["task"],
            str(run["seed"]),
            *(_worst(run["evaluations"].get(name)) for name in ("fresh", "noise", "randomized")),
            f"{run['minutes']:.0f}",
        ]
        for run in found["runs"]
    ]
    noise = f"worst variation, noise of {1000.0 * found['noise_m']:g} mm"
    head = ["task", "seed", "variation 0", noise, "worst variation, randomised", "minutes"]
    told = (
        f"Measured with `{found['command']}`. The table shows success rates over "
        f"{found['episodes']} episodes, with 95 % intervals in brackets. *Variation 0* was played "
        "without noise. The next two columns show the lowest success rate among all variations "
        "(*worst variation*). In the first of them, noise was added to all observed positions. In "
        "the second (*randomised*), quantities were drawn at random in each episode. "
        f"{DASH * any(NONE in row for row in rows)}The column *minutes* shows how long the "
        "training run took on one core, including its evaluations."
    )
    return f"{table(head, rows)}\n\n{told}"


def _worst(evaluations: Sequence[Mapping[str, Any]] | None) -> str:
    """The lowest success rate of several variations, with its interval."""
    if not evaluations:
        return NONE
    return _success(min(evaluations, key=lambda each: each["success_rate"]))


def phases(run: str) -> str:
    """The training episodes of a run of the paper's learner, 5,000 at a time."""
    with unpacked("paper") as runs:
        table_of = read_run(runs / run).episodes
    terms = [name for name in table_of if name.startswith("term/")]
    bonuses = [name for name in terms if table_of[name].min() >= 0.0]
    distances = [name for name in terms if name not in bonuses]
    rows = []
    for first in range(0, len(table_of["episode"]), PHASE):
        part = {name: column[first : first + PHASE] for name, column in table_of.items()}
        rows.append(
            [
                f"{first + 1:,}–{first + len(part['episode']):,}",
                signed(part["team_return"].mean()),
                *(signed(part[name].mean()) for name in distances),
                *(f"{np.count_nonzero(part[name]):,}" for name in bonuses),
                f"{np.count_nonzero(part['success']):,}",
            ]
        )
    labels = [name.removeprefix("term/") for name in (*distances, *bonuses)]
    return table(["episodes", "return", *(f"`{label}`" for label in labels), "success"], rows)


def _stages(stages: dict[str, int]) -> str:
    """The number of episodes by the last stage that they reached, the furthest first."""
    reached = [f"{name or 'none'}: {count}" for name, count in stages.items() if count]
    return ", ".join(reversed(reached))


def zoo(_: str) -> str:
    """The pretrained policies, their success rates, and the commands that trained them."""
    rows, commands = [], []
    measured = read("zoo.json")
    for name in zoo_names():
        about = load_policy(name).about
        found = measured["policies"][name]
        rows.append(
            [
                f"`{name}`",
                f"{about['step']:,} {'updates' if about['algorithm'] == 'bc' else 'steps'}",
                f"{found['successes']} of {found['episodes']} {_interval(found)}",
                f"{100.0 * found['success_at_end_rate']:.1f} %",
                f"{found['peak_robot_force']['median']:.0f} N",
            ]
        )
        commands.append(about["command"])
    if not rows:
        return "None yet."
    head = ["policy", "trained for", "success (95 % interval)", "success at the last step"]
    head += ["largest force between robots, median"]
    made = "\n".join(["These commands trained the policies:", "", "```text", *commands, "```"])
    asked = f"Measured with `{measured['command']}`, by `python benchmarks/zoo.py`."
    return f"{table(head, rows)}\n\n{asked}\n\n{made}"
