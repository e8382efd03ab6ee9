"""Where work is done: in processes of this machine, or on the nodes of a cluster."""

from __future__ import annotations

import argparse
from contextlib import AbstractContextManager

from taskbuilder.cluster import cluster
from taskbuilder.errors import UsageError
from taskbuilder.jobs import Map, workers
from taskbuilder.processes import cores


def check_spread(arguments: argparse.Namespace) -> None:
    """Refuse --jobs beside --ray.

    Raises:
        UsageError: Both are given.
    """
    if arguments.ray and arguments.jobs:
        raise UsageError("--jobs does not go with --ray, which uses every core of the cluster")


def spread_over(
    arguments: argparse.Namespace, pieces: int, default: int | None = None
) -> AbstractContextManager[Map]:
    """A `map` over what --jobs or --ray ask for.

    Args:
        arguments: Of the command line.
        pieces: Number of pieces of work.
        default: Number of processes without --jobs; by default one for each core.
    """
    check_spread(arguments)
    if arguments.ray:
        return cluster(arguments.ray)
    return workers(min(arguments.jobs or default or cores(), pieces))
