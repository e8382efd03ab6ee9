"""`taskbuilder plot`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from taskbuilder.cli.tasks import make_folder
from taskbuilder.errors import UsageError, display_path
from taskbuilder.extras import extra_needed
from taskbuilder.files import write_whole
from taskbuilder.learn.logs import RunLog, read_run
from taskbuilder.learn.other_curves import OtherCurves, read_curves
from taskbuilder.learn.run_groups import (
    WINDOW,
    RunCurve,
    RunGroup,
    aggregate,
    episodes_at,
    group_runs,
    labels_of,
    names_of,
)

if TYPE_CHECKING:
    from taskbuilder.visual.curves import Curve, Group


def run(arguments: argparse.Namespace) -> int:
    """Draw the learning curves of runs of one task, those alike together."""
    form = _form(arguments.out)
    folders = {Path(name).resolve(): Path(name) for name in arguments.runs}
    runs = [read_run(folder) for folder in folders.values()]
    groups = group_runs(runs)
    others = [read_curves(path) for path in arguments.beside]
    with extra_needed("plot", "plot"):  # a second, when all else is in order
        from taskbuilder.visual.curves import learning_curves
    make_folder(arguments.out.parent)

    names = names_of(groups)
    task = Path(runs[0].plan.task).stem
    picture = learning_curves(
        arguments.title or task,
        _subtitle([task] if arguments.title else [], names, runs, others),
        [*_drawn(groups, names, runs), *map(_drawn_other, others)],
        max((run.stages for run in runs), key=len),
        episodes_at(runs),
        form,
    )
    write_whole(arguments.out, picture)
    print(display_path(arguments.out))
    return 0


def _form(path: Path) -> Literal["png", "svg"]:
    match path.suffix.lower():
        case ".png":
            return "png"
        case ".svg":
            return "svg"
    raise UsageError(f"{display_path(path)}: a picture is a .png or an .svg; name it so")


def _longest(runs: Sequence[RunLog]) -> float:
    """Environment steps of the longest run."""
    return max(float(run.evaluations["step"][-1]) for run in runs)


def _subtitle(
    task: list[str], names: Sequence[str], runs: Sequence[RunLog], others: Sequence[OtherCurves]
) -> list[str]:
    """What was drawn, and how."""
    total = len(runs) + sum(other.seeds for other in others)
    count = f"{total} run{'s' * (total > 1)}"
    what = [*task, *names, count] if len(names) == 1 and not others else [*task, count]
    how = [f"training episodes averaged over {WINDOW * _longest(runs):,.0f} steps"]
    if total > len(names) + len(others):
        how.append("every run faint, in bold their interquartile mean with its 95% band")
    if len({run.evaluations["step"][-1] for run in runs}) > 1:
        how.append("stages of the runs that came so far")
    return [" · ".join(what), " · ".join(how)]


def _drawn(groups: Sequence[RunGroup], names: Sequence[str], runs: Sequence[RunLog]) -> list[Group]:
    """The groups as they are drawn."""
    from taskbuilder.visual.curves import Group

    longest, labels = _longest(runs), labels_of(runs)
    return [
        Group(
            name,
            len(group.runs),
            _curve(group.success()),
            _curve(at_end) if (at_end := group.success_at_end()) else None,
            _curve(group.smoothed("team_return", longest)),
            {label: _curve(group.smoothed(f"term/{label}", longest)) for label in labels},
            group.stages(),
        )
        for group, name in zip(groups, names, strict=True)
    ]


def _drawn_other(other: OtherCurves) -> Group:
    """Curves of other software as they are drawn."""
    from taskbuilder.visual.curves import Group

    success, team_return = (
        _curve(lines) if lines else None for lines in (other.success, other.team_return)
    )
    return Group(other.name, other.seeds, success, None, team_return, {}, None)


def _curve(lines: Sequence[RunCurve]) -> Curve:
    """Runs and what they have in common; the same draws for all, so that pictures repeat."""
    from taskbuilder.visual.curves import Curve

    found = aggregate(lines, np.random.default_rng(0))
    return Curve(lines, (found.steps, found.iqm, found.low, found.high) if found else None)
