"""Arguments of the command `benchmark`."""

from __future__ import annotations

from pathlib import Path

from taskbuilder import extensions
from taskbuilder.cli.argument_types import Extend, PartName, whole
from taskbuilder.cli.learning_arguments import CommandAdder
from taskbuilder.cli.shared_options import add_json, add_ray
from taskbuilder.learn.algorithms import ALGORITHMS


def add_benchmark(adder: CommandAdder) -> None:
    """`taskbuilder benchmark`."""
    parser = adder.command(
        "measure a method on all tasks of a suite, by a protocol that others can repeat",
        "seed --track imitation --algorithm bc --seeds 11 12 13 --out bench/bc",
    )
    parser.add_argument(
        "suite",
        nargs="?",
        metavar="SUITE",
        help="the tasks: seed, single, pairs, trios, quads, or your own suite",
    )
    parser.add_argument(
        "--track",
        metavar="T",
        help="what the method may use, and how it is evaluated: imitation, vision or reinforcement",
    )
    parser.add_argument(
        "--algorithm",
        type=PartName(ALGORITHMS, extensions.ALGORITHMS),
        metavar="A",
        help="algorithm that trains the policies, such as bc",
    )
    parser.add_argument(
        "--policy",
        metavar="P",
        help="in place of --algorithm: policies that exist, which are only evaluated; {task} and "
        "{seed} stand for the task and the seed, as in zoo:{task}/cloned or "
        "ws://HOST:PORT/{task}?cameras=C,C",
    )
    parser.add_argument("--preset", metavar="P", help="named set of settings of the algorithm")
    parser.add_argument(
        "--set",
        action=Extend,
        nargs="+",
        metavar="K=V",
        help="settings of the algorithm, such as noise=0.1",
    )
    parser.add_argument(
        "--seeds",
        type=whole(0, 2**31 - 1),
        nargs="+",
        metavar="N",
        help="training seeds (default 11 12 13)",
    )
    parser.add_argument(
        "--only",
        nargs="+",
        metavar="TASK",
        help="run only these tasks of the suite now; a later run without --only does the others",
    )
    parser.add_argument(
        "--smoke",
        action="store_true",
        help="run a short version of the track, to see that everything works; its results are not "
        "comparable",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder of the benchmark; a run that was interrupted continues there",
    )
    parser.add_argument(
        "--shared",
        type=Path,
        metavar="DIR",
        help="folder of the demonstrations and baselines, which several methods can share "
        "(default: shared, in the folder of the benchmark)",
    )
    parser.add_argument(
        "--tuning-runs",
        type=whole(0, 1_000_000),
        metavar="N",
        help="training runs that you spent on choosing the settings; the report declares them",
    )
    parser.add_argument(
        "--jobs",
        type=whole(1, 1024),
        metavar="N",
        help="number of cells (a task and a seed) to work on at once (default 1)",
    )
    add_ray(parser, "cells")
    parser.add_argument(
        "--report",
        type=Path,
        nargs="+",
        metavar="DIR",
        help="write the report of these folders again, several methods side by side",
    )
    add_json(parser)
