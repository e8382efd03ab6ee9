"""`taskbuilder collect`."""

from __future__ import annotations

import argparse
import sys
import time
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

from taskbuilder.cli import output
from taskbuilder.cli.dataset_command import print_summary
from taskbuilder.cli.env_options import asked_options
from taskbuilder.cli.output import print_json, warn
from taskbuilder.cli.spreading import check_spread
from taskbuilder.cli.tasks import asked_suite, asked_tasks, catalogue_of
from taskbuilder.cluster import cluster
from taskbuilder.data.collecting import CollectProgress, Report
from taskbuilder.data.collection import collect
from taskbuilder.data.formats import ExportOptions, export_dataset
from taskbuilder.data.summary import (
    MissingVariation,
    missing_variations,
    summarize_dataset,
)
from taskbuilder.env.options import EnvOptions
from taskbuilder.errors import UsageError, display_path
from taskbuilder.jobs import Map
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.wording import duration


def run(arguments: argparse.Namespace) -> int:
    """Collect a data set, say what is in it, and export it."""
    exported = Path(f"{arguments.out}-{arguments.export}")
    if arguments.export and exported.exists():
        raise UsageError(f"{display_path(exported)} exists; the export would go there")
    check_spread(arguments)
    catalogue = catalogue_of(arguments)
    variations, first_seed = _start(arguments, catalogue)
    with ShownProgress() as report, _nodes(arguments) as nodes:
        dataset = collect(
            asked_tasks(arguments, catalogue),
            arguments.out,
            episodes=arguments.per_variation or arguments.episodes,
            policy=arguments.policy,
            variations=variations,
            per_variation=arguments.per_variation is not None,
            first_seed=first_seed,
            depth=arguments.depth,
            keep_failures=arguments.keep_failures,
            until_success=arguments.until_success,
            license=arguments.license,
            jobs=arguments.jobs,
            nodes=nodes,
            report=report,
            catalogue=catalogue,
            **_options(arguments),
        )
    if arguments.export:
        export_dataset(dataset, arguments.export, exported, ExportOptions(warn=warn))
    told, missing = summarize_dataset(dataset), tuple(missing_variations(dataset))
    if arguments.json:
        export = display_path(exported) if arguments.export else None
        print_json({**told, "export": export, "missing": [asdict(each) for each in missing]})
    else:
        print_summary(told)
        if arguments.export:
            print(display_path(exported))
    for each in missing:
        print(_warning(each), file=sys.stderr)
    return 1 if missing and not arguments.allow_missing else 0


def _warning(missing: MissingVariation) -> str:
    """A sentence about a variation of which there are too few episodes."""
    has = f"{missing.episodes} of {missing.wanted} episodes" if missing.episodes else "no episode"
    told = f"taskbuilder: warning: {missing.task}: {has} of variation {missing.variation}"
    if not missing.attempts:
        return f"{told}, which was never played; ask for more --episodes, or give --per-variation"
    tried = f"{missing.attempts} attempt{'s' * (missing.attempts != 1)}"
    return f"{told} in {tried}; the first failed because {missing.reason}"


def _nodes(arguments: argparse.Namespace) -> AbstractContextManager[Map | None]:
    """A map over the nodes of a cluster, or None without --ray."""
    return cluster(arguments.ray) if arguments.ray else nullcontext()


def _options(arguments: argparse.Namespace) -> EnvOptions:
    """The options of the environments, and which pictures are recorded."""
    pictures: EnvOptions = {
        "cameras": arguments.cameras,
        "camera_size": arguments.size,
        "renderer": arguments.renderer or "auto",
    }
    asked: Any = asked_options(arguments)
    return {**asked, **pictures}


def _start(
    arguments: argparse.Namespace, catalogue: Catalogue
) -> tuple[tuple[int, ...] | Literal["all"], int]:
    """The variations and the first seed; by default those of a suite."""
    suite = asked_suite(arguments, catalogue)
    variations: tuple[int, ...] | None = suite.train.variations if suite else (0,)
    if arguments.per_variation and not suite:
        variations = None
    seed = suite.train.first_seed if suite else 0
    if arguments.variation is not None:
        variations = None if arguments.variation == "all" else (arguments.variation,)
    return (
        "all" if variations is None else variations,
        seed if arguments.seed is None else arguments.seed,
    )


class ShownProgress:
    """Shows progress: a bar on a terminal, else a line now and then."""

    def __init__(self) -> None:
        self._stack = ExitStack()
        self._bar: Any = None
        self._said = time.monotonic()

    def __enter__(self) -> Report:
        return self._show

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def _show(self, tally: CollectProgress) -> None:
        if sys.stderr.isatty():
            self._draw(tally)
        elif time.monotonic() - self._said > output.LINE_EVERY_S and tally.left_s:
            self._said = time.monotonic()
            lost = f", {tally.failed} failed" if tally.failed else ""
            left = f"about {duration(tally.left_s)} left"
            print(f"{tally.kept} of {tally.wanted} episodes{lost}; {left}", file=sys.stderr)

    def _draw(self, tally: CollectProgress) -> None:
        from tqdm import tqdm

        if self._bar is None:
            bar = tqdm(desc="  episodes", total=tally.wanted, leave=False, unit="", delay=0.3)
            self._bar = self._stack.enter_context(bar)
        self._bar.set_postfix(failed=tally.failed)
        self._bar.update(tally.kept - self._bar.n)
