"""Measured results, from the files that the benchmarks and the validator wrote."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from taskbuilder.learn.logs import read_run
from taskbuilder.learn.zoo import load_policy, zoo_names
from taskbuilder.reference.markdown import table

RESULTS = Path(__file__).parents[2] / "benchmarks" / "results"

PHASE = 5_000
"""Training episodes in a row of the tables on the paper's learner."""

NONE = "–"
"""In a table, for what was not measured."""

DASH = "A dash means that the policies were not evaluated in this way. "
"""Below a table with `NONE`."""


def proof(task: str) -> str:
    """When and how a task was proved, and how its expert does it."""
    found = _proof(task)
    making, expert = found["making"], found["expert"]
    checks = {check["code"]: check for check in found["checks"]}
    passed = "All" if found["ok"] else "Not all"
    head = (
        f"`{making['command']}` proved the task on {making['date']}, with taskbuilder "
        f"{making['versions']['taskbuilder']} and {making['seeds']} seeds per variation. "
        f"{passed} {len(checks)} checks passed. {_solved(checks['TB531']['value'])}"
    )
    rows = [
        ["number of stages", str(expert["stages"])],
        ["control steps until success", f"{expert['steps']:g}"],
    ]
    robots = list(expert["waiting"])
    if len(robots) > 1:
        moving, touching = expert["moving_together"], expert["touching_together"]
        rows += [
            ["time in which more than one robot moves", _percent(moving)],
            ["time in which more than one robot touches the same object", _percent(touching)],
            *(
                [f"time in which `{r}` stands still while another robot moves", _percent(waiting)]
                for r, waiting in expert["waiting"].items()
            ),
        ]
    rows += [
        [f"path length of the tool of `{robot}`", f"{length:.2f} m"]
        for robot, length in expert["path_m"].items()
    ]
    about = (
        f"The table shows medians over {expert['episodes']} episodes of the expert. Each episode "
        "is measured until success."
    )
    return f"{head}\n\n{about}\n\n{table(['quantity', 'median'], rows)}"


def _solved(share: float) -> str:
    """How often the expert succeeded, from its share in the worst variation."""
    if share == 1.0:
        return "The expert succeeded in every episode."
    return f"In each variation, the expert succeeded in at least {100 * share:.1f} % of episodes."


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.0f} %"


def probes(task: str) -> str:
    """The returns of the expert and the probes of a task, the best first."""
    report = _proof(task)
    ways = sorted(report["probes"], key=lambda way: -way["return"])
    return table(
        ["way to play", "return", "discounted return"],
        (
            [_way(way["way"]), _signed(way["return"]), _signed(way["discounted_return"])]
            for way in ways
            if way["way"]["kind"] != "fail"
        ),
    )


def _way(way: Mapping[str, Any]) -> str:
    """A way to play a task, in words."""
    match way["kind"]:
        case "expert":
            return "the expert plays"
        case "stall":
            stage = f"until stage {way['stage']} is done"
            return f"the expert plays {stage}, then all robots hold still"
        case "without":
            return f"the expert plays, but `{way['robot']}` holds still"
        case "nothing":
            return "all robots hold still"
        case "random":
            return "all robots act at random"
    raise LookupError(f"no words for a way {way['kind']!r}")


def holding(task: str) -> str:
    """The returns of the expert, of stalls and of holding still, the highest first."""
    ways = [way for way in _read("holding_on.json")["ways"] if way["task"] == task]
    if not ways:
        raise LookupError(f"holding_on.json has no task {task!r}")
    rows = []
    for way in sorted(ways, key=lambda way: -way["return"]):
        row = [way["way"], f"{way['successes']} of {way['episodes']}"]
        for column in ("return", "discounted_return"):
            lead, half = way[f"{column}_behind"]
            behind = f"{_signed(lead, 2)} ± {half:.2f}"
            row += [_signed(way[column], 2), "" if way["way"] == "expert" else behind]
        rows.append(row)
    head = ["way to play", "success", "return", "lead of the expert"]
    return table([*head, "discounted return", "discounted lead of the expert"], rows)


def experts(_: str) -> str:
    """Success rates and times of the experts."""
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
    head = ["task", "variation", "success", "still at the last step"]
    head += ["control steps to success, median", "force between robots, largest"]
    head += ["planning time, median"]
    return table(head, rows)


def learning(which: str) -> str:
    """The results of the learning runs, or of those under the earlier definition of success."""
    rows = []
    for run in _read("learning_earlier.json" if which else "learning.json")["runs"]:
        low, high = (100.0 * bound for bound in run["interval"])
        rows.append(
            [
                run["task"],
                run["track"],
                str(run["seed"]),
                {"scene": "the whole scene", "task": "as the task lists"}[run["observe"]],
                f"{run['steps']:,}",
                f"{100.0 * run['success_rate']:.1f} % ({low:.1f}–{high:.1f} %)",
                *([] if which else [f"{100.0 * run['success_at_end_rate']:.1f} %"]),
                _stages(run["stages"]),
                f"{run['minutes']:.0f}",
            ]
        )
    if not rows:
        return "No run is kept yet."
    head = ["task", "track", "seed", "policies observe", "control steps", "success (95 % interval)"]
    head += [] if which else ["success at the last step"]
    return table([*head, "furthest stage", "minutes"], rows)


def cloning(_: str) -> str:
    """The results of behaviour cloning, every seed."""
    found = _read("cloning.json")
    rows = []
    for run in found["runs"]:
        low, high = (100.0 * bound for bound in run["interval"])
        rows.append(
            [
                run["task"],
                _inputs(run),
                str(run["seed"]),
                f"{run['demonstrations']}",
                f"{run['updates']:,}",
                f"{100.0 * run['success_rate']:.1f} % ({low:.1f}–{high:.1f} %)",
                _stages(run["stages"]),
                f"{run['minutes']:.0f}",
            ]
        )
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
    found = _read("robust_cloning.json")
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
    found = min(evaluations, key=lambda each: each["success_rate"])
    low, high = (100.0 * bound for bound in found["interval"])
    return f"{100.0 * found['success_rate']:.1f} % ({low:.1f}–{high:.1f} %)"


def collecting(_: str) -> str:
    """What collecting a thousand episodes takes."""
    found = _read("collecting.json")
    rows = [
        [
            what,
            f"{measured['seconds']:.0f} s",
            f"{measured['processor_s_per_episode']:.2f} s",
            f"{measured['megabytes']:.0f} MB",
        ]
        for what, measured in zip(
            ("no pictures", "two cameras at 128×128, exported to LeRobot"),
            found["measured"].values(),
            strict=True,
        )
    ]
    head = [f"{found['episodes']:,} episodes of Handover", "time", "CPU time per episode", "size"]
    told = f"Measured with `{found['command']}`, with {found['jobs']} processes on two cores."
    return f"{table(head, rows)}\n\n{told}"


def phases(run: str) -> str:
    """The training episodes of a run of the paper's learner, 5,000 at a time."""
    table_of = read_run(RESULTS / "paper" / run).episodes
    terms = [name for name in table_of if name.startswith("term/")]
    bonuses = [name for name in terms if table_of[name].min() >= 0.0]
    distances = [name for name in terms if name not in bonuses]
    rows = []
    for first in range(0, len(table_of["episode"]), PHASE):
        part = {name: column[first : first + PHASE] for name, column in table_of.items()}
        rows.append(
            [
                f"{first + 1:,}–{first + len(part['episode']):,}",
                _signed(part["team_return"].mean()),
                *(_signed(part[name].mean()) for name in distances),
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
    measured = _read("zoo.json")
    for name in zoo_names():
        about = load_policy(name).about
        found = measured["policies"][name]
        low, high = (100.0 * bound for bound in found["interval"])
        rows.append(
            [
                f"`{name}`",
                f"{about['step']:,} {'updates' if about['algorithm'] == 'bc' else 'steps'}",
                f"{found['successes']} of {found['episodes']} ({low:.1f}–{high:.1f} %)",
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


def _proof(task: str) -> Any:
    """The proof of a task.

    Raises:
        LookupError: It has none.
    """
    try:
        return _read(f"proofs/{task}.json")
    except FileNotFoundError:
        raise LookupError(f"{task} has no proof; run python benchmarks/proofs.py {task}") from None


def _read(name: str) -> Any:
    return json.loads((RESULTS / name).read_text(encoding="utf-8"))


def _signed(value: float, digits: int = 1) -> str:
    return f"{value:.{digits}f}".replace("-", "−")
