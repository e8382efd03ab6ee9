"""Measured results, from the files that the benchmarks and the validator wrote."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from taskbuilder.reference.markdown import table
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.validate.runner import families_of

RESULTS = Path(__file__).parents[2] / "benchmarks" / "results"

WHEN = ("before", "now")
"""The two sides of a comparison."""


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
            [_way(way["way"]), signed(way["return"]), signed(way["discounted_return"])]
            for way in ways
            if way["way"]["kind"] != "fail"
        ),
    )


def stopping(_: str) -> str:
    """How often comparisons find a lead where there is none."""
    found = read("stopping.json")
    rows = [
        [name, *(f"{100 * rates[how]:.1f} %" for how in ("stopping", "all seeds", "quick"))]
        for name, rates in found["errors"].items()
    ]
    head = ["differences", "at four looks", "from 40 seeds at once", "with `--quick`"]
    return f"{table(head, rows)}\n\nEach row has {found['trials']:,} trials."


def stopping_verdicts(_: str) -> str:
    """Whether proofs with looks find what proofs from all seeds find."""
    both, replayed = read("stopping_compared.json"), read("stopping_replayed.json")
    ours = sum(name in Catalogue().tasks for name in replayed)
    comparisons = sum(row["probes"] for row in replayed.values())
    differ = len(both["differ"]) + sum(len(row["differ"]) for row in replayed.values())
    return (
        f"{both['tasks']} tasks of the library were proved in both ways, from all forty seeds and "
        f"at looks: {both['checks']} checks. {ours} more tasks, and {len(replayed) - ours} that "
        f"are broken on purpose, were played from all seeds, and their {comparisons} comparisons "
        f"were judged in both ways. {differ or 'No'} verdict{'s' if differ > 1 else ''} differed."
    )


def proofs_elsewhere(_: str) -> str:
    """Whether the library's proofs have the same verdicts on two machines."""
    found = read("proofs_compared.json")
    differ = len(found["differ"])
    return (
        f"All {found['tasks']} tasks of the library were proved on two machines whose processors "
        f"differ ({found['machine']['processor']} in the second). In {found['other_returns']} of "
        f"them, returns of some episodes differ. Of {found['checks']:,} checks, "
        f"{differ or 'no'} verdict{'s' if differ > 1 else ''} differ{'' if differ > 1 else 's'}."
    )


def proof_times(_: str) -> str:
    """CPU-seconds of proofs by family, in the earlier checkout and today."""
    tasks = read("proof_times.json")["tasks"]
    families = ("static", *(family.name for family in families_of("full", None)))

    def row(name: str, *chosen: str) -> list[str]:
        cells = [name]
        for both in tasks.values():
            spent = (sum(both[at]["families"].get(n, 0.0) for n in chosen) for at in WHEN)
            cells.append(" → ".join(f"{seconds:.0f}" for seconds in spent))
        return cells

    rows = [*(row(name, name) for name in families), row("all", *families)]
    return table(["family", *(f"`{task}`" for task in tasks)], rows)


def solver(task: str) -> str:
    """What the limits of the solver cost in a task, and what they let slip."""
    found = read("solver.json")
    head = [
        "iterations at most",
        "residual",
        "iterations, nothing held",
        "iterations, something held",
        "slip, median and maximum",
        "CPU time of a control step, expert and random",
    ]
    rows = []
    for row in found["rows"]:
        measured = row["tasks"][task]
        slip, step = measured["slip_mm"], measured["step_ms"]
        today = [row["iterations"], row["residual"]] == found["today"]
        cells = [
            str(row["iterations"]),
            f"{row['residual']:.0e}",
            *(f"{measured['iterations'][when]:.0f}" for when in ("free", "held")),
            f"{slip['median']:.1f} mm, {slip['max']:.1f} mm",
            f"{step['expert']:.1f} ms, {step['random']:.1f} ms",
        ]
        rows.append([f"**{cell}**" for cell in cells] if today else cells)
    return table(head, rows)


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
    ways = [way for way in read("holding_on.json")["ways"] if way["task"] == task]
    if not ways:
        raise LookupError(f"holding_on.json has no task {task!r}")
    rows = []
    for way in sorted(ways, key=lambda way: -way["return"]):
        row = [way["way"], f"{way['successes']} of {way['episodes']}"]
        for column in ("return", "discounted_return"):
            lead, half = way[f"{column}_behind"]
            behind = f"{signed(lead, 2)} ± {half:.2f}"
            row += [signed(way[column], 2), "" if way["way"] == "expert" else behind]
        rows.append(row)
    head = ["way to play", "success", "return", "lead of the expert"]
    return table([*head, "discounted return", "discounted lead of the expert"], rows)


def experts(_: str) -> str:
    """Success rates and times of the experts."""
    rows = []
    for scene, found in read("experts.json")["scenes"].items():
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


def collecting(_: str) -> str:
    """What collecting a thousand episodes takes."""
    found = read("collecting.json")
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


def _proof(task: str) -> Any:
    """The proof of a task.

    Raises:
        LookupError: It has none.
    """
    try:
        return read(f"proofs/{task}.json")
    except FileNotFoundError:
        raise LookupError(f"{task} has no proof; run python benchmarks/proofs.py {task}") from None


def read(name: str) -> Any:
    """The content of a JSON file among the results."""
    return json.loads((RESULTS / name).read_text(encoding="utf-8"))


def signed(value: float, digits: int = 1) -> str:
    """A number with a true minus."""
    return f"{value:.{digits}f}".replace("-", "−")


def install_sizes(_: str) -> str:
    """The sizes of fresh installations."""
    found = json.loads((RESULTS / "install_size.json").read_text(encoding="utf-8"))
    rows = [
        [
            name,
            f"{each['mb']} MB",
            str(each.get("packages", "")),
            ", ".join(f"{package} {mb}" for package, mb in each.get("largest", {}).items()),
        ]
        for name, each in found["environments"].items()
    ]
    head = ["environment", "size", "packages", "largest packages, MB"]
    about = f"Measured on Linux with Python {found['python']} by `{found['command']}`:"
    return f"{about}\n\n{table(head, rows)}"
