"""Arguments of the commands `collect` and `dataset`."""

from __future__ import annotations

from argparse import ArgumentParser
from pathlib import Path

from taskbuilder.cli.argument_types import (
    Extend,
    PartName,
    listed,
    listed_choices,
    share,
    side_or_size,
    variation_or_all,
)
from taskbuilder.cli.env_options import add_env_options
from taskbuilder.cli.learning_arguments import CommandAdder
from taskbuilder.cli.shared_options import (
    add_count,
    add_jobs,
    add_json,
    add_ray,
    add_suite,
)
from taskbuilder.data.names import FORMAT_NAMES
from taskbuilder.extensions import DATA_FORMATS

ACTIONS = ("info", "check", "film", "export")


def add_collect(adder: CommandAdder) -> None:
    """`taskbuilder collect`."""
    parser = adder.command(
        "collect a data set of episodes, or continue an interrupted collection",
        "handover --episodes 100 --cameras front,left_wrist --size 128 --out data/handover",
    )
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="names or paths of tasks")
    parser.set_defaults(all=None)  # these commands have no --all
    add_suite(parser)
    count = parser.add_mutually_exclusive_group()
    add_count(count, "--episodes", (1, 10_000_000), "number of episodes of each task", default=10)
    add_count(
        count,
        "--per-variation",
        (1, 10_000_000),
        "number of episodes of each variation of each task; without --variation and --suite, "
        "of all variations",
    )
    parser.add_argument(
        "--policy",
        action=Extend,
        nargs="+",
        default=["expert"],
        metavar="P",
        help="expert, noisy:0.3 (the expert with noise), random, hold (all robots hold still), "
        "ws://HOST:PORT (a policy server), or a trained policy (zoo:TASK/TRACK, the folder of a "
        "run, or a policy file); several "
        "policies take turns, and P*3 plays three times as often (default expert)",
    )
    parser.add_argument(
        "--cameras", type=listed, default=(), metavar="C,C", help="cameras to record (default none)"
    )
    parser.add_argument(
        "--size",
        type=side_or_size,
        metavar="WxH",
        help="size of the pictures in pixels, such as 224 or 320x240 "
        "(default: the size of each camera in the task file)",
    )
    parser.add_argument("--depth", action="store_true", help="also record depth images")
    add_env_options(parser, ("renderer",))
    parser.add_argument(
        "--variation",
        type=variation_or_all,
        default=None,
        metavar="K",
        help="number of the variation, or all: the variations take turns (default 0; "
        "with --suite, the training variations of the suite)",
    )
    parser.add_argument(
        "--allow-missing",
        action="store_true",
        help="exit with status 0 even if the data set has no episode of a variation, or fewer than "
        "--per-variation",
    )
    add_count(
        parser,
        "--seed",
        (0, 2**31 - 1),
        "seed of the first attempt at an episode; the next attempts have the next seeds "
        "(default 0; with --suite, the first training seed of the suite)",
    )
    add_env_options(parser, without=("variation",))
    parser.add_argument(
        "--keep-failures", action="store_true", help="also keep episodes without success"
    )
    add_count(
        parser,
        "--until-success",
        (0, 100_000),
        "end each episode N control steps after success was reached (default: record whole "
        "episodes)",
    )
    parser.add_argument(
        "--license",
        default="MIT",
        metavar="L",
        help="licence that README.md of the data set states (default MIT)",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("data"),
        metavar="DIR",
        help="folder of a new data set, or of a data set to continue (default data)",
    )
    _add_format(parser, "also export the data set to the folder DIR-FORMAT, in this format")
    add_jobs(parser)
    add_ray(parser, "the episodes")
    add_json(parser)


def add_multiply(adder: CommandAdder) -> None:
    """`taskbuilder multiply`."""
    parser = adder.command(
        "make many demonstrations from the few of a data set, and keep those that succeed",
        "data/by-hand --episodes 200 --out data/many",
    )
    parser.add_argument(
        "folder", type=Path, metavar="DIR", help="folder of the data set, which has one task"
    )
    add_count(parser, "--episodes", (1, 10_000_000), "number of new episodes", default=100)
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder of a new data set, or of one to continue (default: DIR-many)",
    )
    add_count(
        parser,
        "--seed",
        (0, 2**31 - 1),
        "seed of the first attempt; the next attempts have the next seeds (default: the one after "
        "those of the data set)",
    )
    parser.add_argument(
        "--keep-failures", action="store_true", help="also keep episodes without success"
    )
    parser.add_argument(
        "--trust",
        nargs="?",
        const=True,
        default=False,
        metavar="SHA256",
        help="run the task that comes with the data set, or the one of this SHA-256; a task is a "
        "program, so read it first",
    )
    add_jobs(parser)
    add_json(parser)


def add_dataset(adder: CommandAdder) -> None:
    """`taskbuilder dataset`."""
    parser = adder.command(
        "show, check, film or export a data set",
        "export data/handover --format lerobot --out data/handover-lerobot",
    )
    parser.add_argument(
        "action", choices=ACTIONS, metavar="ACTION", help=f"one of {', '.join(ACTIONS)}"
    )
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of the data set")
    parser.add_argument(
        "--replay",
        type=share,
        default=0.05,
        metavar="SHARE",
        help="check: fraction of the episodes to replay (default 0.05; if not 0, at least one "
        "episode is replayed)",
    )
    add_count(parser, "--episode", (0, 10_000_000), "film: number of the episode, counted from 0")
    parser.add_argument(
        "--cameras",
        type=listed,
        default=(),
        metavar="C,C",
        help="film: cameras to show (default: the first camera of the scene)",
    )
    parser.add_argument(
        "--size",
        type=side_or_size,
        metavar="WxH",
        help="film: size of the picture of each camera, in pixels",
    )
    parser.add_argument(
        "--trust",
        nargs="?",
        const=True,
        default=False,
        metavar="SHA256",
        help="check, film: run the task that comes with the data set, or the one of this SHA-256; "
        "a task is a program, so read it first",
    )
    _add_format(parser, "export: format to export to")
    parser.add_argument(
        "--pictures",
        action="store_true",
        help="export: write PNG images instead of videos, if the format supports both",
    )
    parser.add_argument(
        "--no-language",
        dest="language",
        action="store_false",
        help="export: for LeRobot 0.5 and earlier, which refuse the column language_persistent; "
        "leave it out",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="film, export: folder to write to")
    add_json(parser)


def _add_format(parser: ArgumentParser, text: str) -> None:
    parser.add_argument(
        "--format",
        dest="export",
        type=PartName(FORMAT_NAMES, DATA_FORMATS),
        metavar=listed_choices(FORMAT_NAMES),
        help=text,
    )
