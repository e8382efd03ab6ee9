"""`taskbuilder collect`."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Mapping
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import Any

from taskbuilder.cli import output
from taskbuilder.cli.dataset_command import print_summary
from taskbuilder.cli.env_options import asked_options
from taskbuilder.cli.output import print_json
from taskbuilder.cli.spreading import check_spread
from taskbuilder.cli.tasks import asked_suite, asked_tasks, catalogue_of
from taskbuilder.cluster import cluster
from taskbuilder.data.collecting import CollectProgress, Report, collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.formats import export_dataset
from taskbuilder.data.plan import CollectPlan
from taskbuilder.data.recording import Cameras
from taskbuilder.data.summary import (
    MissingVariation,
    missing_variations,
    summarize_dataset,
)
from taskbuilder.errors import UsageError, display_path
from taskbuilder.jobs import Map
from taskbuilder.policies.grammar import Player
from taskbuilder.policies.mixture import (
    PolicyShare,
    digests_of_players,
    players_of,
    read_share,
    shared_options,
)
from taskbuilder.processes import cores
from taskbuilder.schema.catalogue import Catalogue


def run(arguments: argparse.Namespace) -> int:
    """Collect a data set, say what is in it, and export it."""
    shares = tuple(read_share(text) for text in arguments.policy)
    players = players_of(shares)
    plan = _plan(arguments, shares, players)
    exported = Path(f"{arguments.out}-{arguments.export}")
    if arguments.export and exported.exists():
        raise UsageError(f"{display_path(exported)} exists; the export would go there")
    check_spread(arguments)
    jobs = arguments.jobs or cores()
    if not plan.per_variation:
        jobs = min(jobs, plan.episodes * len(plan.tasks))
    with _Progress() as report, _nodes(arguments) as nodes:
        collect(plan, arguments.out, jobs=jobs, nodes=nodes, report=report, players=players)
    dataset = load_dataset(arguments.out)
    if arguments.export:
        export_dataset(dataset, arguments.export, exported)
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


def _plan(
    arguments: argparse.Namespace, shares: tuple[PolicyShare, ...], players: Mapping[str, Player]
) -> CollectPlan:
    catalogue = catalogue_of(arguments)
    references = tuple(asked_tasks(arguments, catalogue))
    variations, first_seed = _start(arguments, catalogue)
    return CollectPlan(
        tasks=references,
        episodes=arguments.per_variation or arguments.episodes,
        per_variation=arguments.per_variation is not None,
        policies=shares,
        cameras=Cameras(arguments.cameras, arguments.size, arguments.depth),
        options=shared_options(players, asked_options(arguments)),
        renderer=arguments.renderer or "auto",
        variations=variations,
        first_seed=first_seed,
        keep_failures=arguments.keep_failures,
        until_success=arguments.until_success,
        license=arguments.license,
        policy_digests=digests_of_players(players),
        catalogue=catalogue,
    )


def _start(
    arguments: argparse.Namespace, catalogue: Catalogue
) -> tuple[tuple[int, ...] | None, int]:
    """The variations, or None for all, and the first seed; by default those of a suite."""
    suite = asked_suite(arguments, catalogue)
    variations: tuple[int, ...] | None = suite.train.variations if suite else (0,)
    if arguments.per_variation and not suite:
        variations = None
    seed = suite.train.first_seed if suite else 0
    if arguments.variation is not None:
        variations = None if arguments.variation == "all" else (arguments.variation,)
    return variations, seed if arguments.seed is None else arguments.seed


class _Progress:
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
            left = f"about {_duration(tally.left_s)} left"
            print(f"{tally.kept} of {tally.wanted} episodes{lost}; {left}", file=sys.stderr)

    def _draw(self, tally: CollectProgress) -> None:
        from tqdm import tqdm

        if self._bar is None:
            bar = tqdm(desc="  episodes", total=tally.wanted, leave=False, unit="", delay=0.3)
            self._bar = self._stack.enter_context(bar)
        self._bar.set_postfix(failed=tally.failed)
        self._bar.update(tally.kept - self._bar.n)


def _duration(seconds: float) -> str:
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"
