"""Trials, as `evaluate` plays them and `evaluate --verify` plays them again."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import closing
from os.path import relpath
from pathlib import Path

from taskbuilder.cli.evaluated import Evaluated, named_player
from taskbuilder.cli.output import progress
from taskbuilder.cli.spreading import spread_over
from taskbuilder.trial.arms import Job, TrialConfig, by_arm, play_all
from taskbuilder.trial.certificate import Trial
from taskbuilder.trial.results import Arms


def play_arms(config: TrialConfig, jobs: Sequence[Job], arguments: argparse.Namespace) -> Arms:
    """Play all episodes, by as many processes or on the cluster that are asked for."""
    with (
        spread_over(arguments, len(jobs)) as spread,
        closing(play_all(config, jobs, None if spread is map else spread)) as episodes,
    ):
        return by_arm(progress(episodes, "episodes", len(jobs)))


def trial_of(found: Evaluated, beside: Path, seeds: Sequence[int], compared: int) -> Trial:
    """What a certificate in a file is about; a policy's file is named from its folder on.

    Args:
        found: Who is evaluated.
        beside: The certificate.
        seeds: Of all episodes.
        compared: From how many of them all arms played.
    """
    named, name = named_player(found.name), found.name
    if named is not None:
        name = f"{named[0]}:{found.task.name}"
    elif not name.startswith("zoo:"):
        name = Path(relpath(Path(name).resolve(), beside.resolve().parent)).as_posix()
    return Trial(found.task, name, found.file, found.options, tuple(seeds), compared)
