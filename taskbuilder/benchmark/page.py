"""The report of a benchmark: a page in Markdown, a picture, and the figures as CSV and JSON."""

from __future__ import annotations

import html
import json
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from taskbuilder.benchmark.cells import Cell, command_of
from taskbuilder.benchmark.records import CELLS, cell_folder
from taskbuilder.benchmark.results import MethodResults, as_csv, as_data
from taskbuilder.benchmark.statistics import SCORES, Banded
from taskbuilder.benchmark.tables import (
    Rows,
    baseline_table,
    beside_table,
    cost_table,
    marks,
    suite_table,
    task_table,
)
from taskbuilder.extras import extra_needed
from taskbuilder.files import write_whole

if TYPE_CHECKING:  # loads matplotlib
    from taskbuilder.visual.profiles import MethodLine

PAGE, PICTURE, TABLE, DATA = "README.md", "benchmark.png", "results.csv", "results.json"


def drawing_needed() -> AbstractContextManager[None]:
    """Load what draws the picture within this block.

    Raises:
        UsageError: It is not installed.
    """
    return extra_needed("plot", "the picture of a benchmark")


def write_report(several: Sequence[MethodResults], folder: Path) -> list[Path]:
    """Write page, picture and figures of one or several methods; their paths.

    Args:
        several: The results, of the same suite and track.
        folder: Where to.

    Raises:
        OSError: A file cannot be written.
        UsageError: The package that draws the picture is not installed.
    """
    with drawing_needed():
        from taskbuilder.visual.profiles import benchmark_picture  # loads matplotlib

    picture = benchmark_picture(_title(several), _subtitle(several), SCORES, _lines(several))
    text = json.dumps(as_data(several), indent=1, ensure_ascii=False) + "\n"
    contents = {
        PAGE: page(several).encode(),
        PICTURE: picture,
        TABLE: as_csv(several).encode(),
        DATA: text.encode(),
    }
    for name, content in contents.items():
        write_whole(folder / name, content)
    return [folder / name for name in contents]


def _title(several: Sequence[MethodResults]) -> str:
    about = several[0].about
    return f"{about.suite.name} · {about.track.name}"


def _subtitle(several: Sequence[MethodResults]) -> list[str]:
    about = several[0].about
    counts = sorted({len(each.about.seeds) for each in several})
    seeds = " or ".join(map(str, counts))
    return [
        f"{about.track.label} · {len(about.suite.tasks)} tasks, {seeds} "
        f"seed{'s' * (counts != [1])} each",
        f"{about.track.episodes} episodes in each test variation, from seed "
        f"{about.track.first_seed} on · bands: 95 %, stratified bootstrap",
    ]


def _lines(several: Sequence[MethodResults]) -> list[MethodLine]:
    from taskbuilder.visual.profiles import MethodLine

    return [
        MethodLine(
            each.name,
            _ends(each.profile()),
            _ends(each.interquartile_mean()),
            {t.task: t.scores for t in each.tasks if t.there and not t.impossible},
        )
        for each in several
    ]


def _ends(found: Banded | None) -> tuple[Any, Any, Any] | None:
    return None if found is None else (found.value, found.low, found.high)


def page(several: Sequence[MethodResults]) -> str:
    """The page of one or several methods, in Markdown."""
    methods = map(_method, several)
    parts = (_head(several), _figures(several), *methods, _reading(several), _protocol(several))
    return "\n".join(line for part in parts for line in part)


def _head(several: Sequence[MethodResults]) -> Iterator[str]:
    about = several[0].about
    names = ", ".join(f"`{each.name}`" for each in several)
    yield from (f"# Benchmark: {about.suite.name}, {about.track.name}", "")
    yield f"{names} on the suite {about.suite.name}; the track is {about.track.label}."
    if not about.track.is_official:
        yield "**Not comparable with other results**: the track was shortened or changed."
    for each in several:
        if each.missing:
            yield f"**Not complete**: cells of `{each.name}` are missing, {each.missing} in all."
        if len(each.states) > 1:
            yield f"**Made by different states of taskbuilder**: the cells of `{each.name}`."
    yield ""


def _figures(several: Sequence[MethodResults]) -> Iterator[str]:
    yield from (f"![Performance profile, interquartile mean and all runs]({PICTURE})", "")
    yield from ("## Over the suite", "", *_markdown(suite_table(several)), "")
    yield from (
        "IQM is the interquartile mean of success at the last step over all runs of all tasks:",
        "the mean of the middle half. Brackets contain 95 % bands of a bootstrap that resamples",
        "the runs of each task. The performance profile is the fraction of runs whose success is",
        "above τ. Both are as Agarwal et al. (2021) define them. A cell that failed counts as 0. A",
        "task that the track cannot have is left out, and there are no figures while cells are",
        "missing.",
        "",
    )
    if len(several) > 1:
        yield from ("## By task", "", *_markdown(beside_table(several)), "")


def _method(results: MethodResults) -> Iterator[str]:
    yield from (f"## {_plain(results.name)}", "", *_markdown(task_table(results)), "")
    if results.problems:
        yield from ("What failed, or is not possible on this track:", "")
        yield from (f"- {_plain(each.task)}: {_plain(each.reason)}" for each in results.problems)
        yield ""
    if results.about.method.policy:
        yield "These policies were only evaluated here: **how they were trained is not known, and"
        yield from ("need not be by the protocol of the track**.", "")
    yield from ("CPU minutes of all seeds together:", "", *_markdown(cost_table(results)), "")
    yield from _repeat(results)


def _reading(several: Sequence[MethodResults]) -> Iterator[str]:
    force = f"{several[0].about.track.safe_force:g} N"
    yield from (
        "## How to read the tables",
        "",
        "- *Median seed*: percent of episodes in which success held at the last control step, with",
        "  95 % Wilson intervals, for the median seed; of two the lower.",
        "- *Seed*: the same of each seed; x is a cell that failed.",
        "- *Safe*: percent of episodes with success at the last step and no contact between robots",
        f"  above {force} at any time, after success too, for the median seed.",
        "- *CPU min*: CPU time of the training of the median seed, with the evaluations by which",
        "  its policy was chosen.",
        *(f"- `{mark}`: {says}." for mark, says in marks(several)),
        "",
        "## Baselines",
        "",
        *_markdown(baseline_table(several[0])),
        "",
        "They play the first episodes of the first test variation.",
        "",
    )


def _repeat(results: MethodResults) -> Iterator[str]:
    about = results.about
    finished = [cell for each in results.tasks for cell in each.there]
    certified = next((cell for cell in finished if cell.certificates), None)
    if command := command_of(about):
        first = command_of(about, Cell(about.suite.tasks[0], about.seeds[0]))
        yield from ("The whole and one cell are repeated, and one cell is verified, by:", "")
        yield from ("```sh", command, first)
        if certified is not None:
            folder = cell_folder(Path(), certified.task, certified.seed).as_posix()
            yield f"taskbuilder evaluate --verify {folder}/{certified.certificates[0]}"
        yield from ("```", "")
    made = next((cell for cell in finished if cell.versions), None)
    if made is not None:
        names = ("taskbuilder", "python", "pybullet", "numpy", "torch")
        listed = [f"{name} {made.versions[name]}" for name in names if name in made.versions]
        machine = made.processor.get("name") or made.processor.get("architecture", "not known")
        yield from (f"Made with {_plain(', '.join(listed))}, on {_plain(machine)}.", "")


def _protocol(several: Sequence[MethodResults]) -> Iterator[str]:
    about = several[0].about
    track, suite = about.track, about.suite
    train, test = (", ".join(map(str, numbers)) for numbers in (suite.train, suite.test))
    yield from ("## Protocol", "", f"{track.summary} Policies observe {track.observes}.", "")
    shown, budget = track.demonstrations, track.training
    if shown:
        yield f"- Demonstrations: {shown.episodes} episodes of the expert of each task, from seed"
        yield f"  {shown.first_seed} on, in variations {train} in turns. All seeds and methods"
        yield "  learn from the same. The expert's actions have noise in"
        yield f"  {shown.noise_share:.0%} of the control steps: the strongest of"
        yield f"  {', '.join(map(str, shown.noise))} under which it succeeds in"
        yield f"  {shown.trials_needed} of {shown.trials} trials, or none."
    else:
        yield f"- No demonstrations. Policies act in variation {suite.train[0]}."
    unit = "updates" if shown else "control steps"
    yield f"- Training: {budget.steps:,} {unit}, in at most {budget.cpu_minutes:g} min of CPU time."
    yield f"  Every {budget.evaluate_every:,} {unit}, the policy plays {budget.evaluate_episodes}"
    yield "  episodes with seeds from 800000 on, by which the policy of a run is chosen."
    yield f"- Evaluation: {track.episodes} episodes in each of the test variations ({test}), with"
    yield f"  seeds from {track.first_seed} on, which belong to version {track.version} alone."
    yield f"- Methods may be tuned on these tasks alone: {', '.join(track.development)}."
    yield "- Tuning runs are declared by whoever ran the benchmark, and cannot be checked."
    yield from (f"- Tasks: {suite.labels}.", "")
    yield f"Every number is in `{TABLE}` and `{DATA}`; certificates are in `{CELLS}/`."
    yield ""


def _markdown(rows: Rows) -> Iterator[str]:
    head, *body = [[_plain(cell) for cell in row] for row in rows]
    yield f"| {' | '.join(head)} |"
    yield "|" + "---|" * len(head)
    yield from (f"| {' | '.join(row)} |" for row in body)


def _plain(text: str) -> str:
    """A text of anybody's as a cell of a table or a line of a list."""
    line = html.escape(" ".join(text.split()), quote=False)
    return line.replace("|", "\\|").replace("*", "\\*").replace("_", "\\_")
